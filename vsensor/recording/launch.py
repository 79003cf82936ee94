"""Starts the recorder's process, and waits until it stands ready."""

import json
import socket
import subprocess
import sys
import tempfile
from collections.abc import Collection, Mapping

from vsensor.errors import InputError, VsensorError
from vsensor.recording import wire

BUFFER_BYTES = 8 << 20
"""Asked of the kernel; without privileges it grants net.core.wmem_max (usually 208 KiB: 0.3 s at 1 kHz)."""

START_S = 20.0
"""A process that is not ready by then will not be."""

_SO_SNDBUFFORCE = 32  # linux/socket.h; Python does not name it


def launch(
    order: Mapping[str, object], processors: Collection[int]
) -> tuple[socket.socket, subprocess.Popen[bytes]]:
    """Start the process with its order, and wait until it is ready; returns our end of the socket, and it.

    Raises InputError with what it complains of, VsensorError where it says nothing.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    _enlarge(ours)
    with theirs, tempfile.TemporaryFile() as stdin:
        stdin.write(json.dumps(order).encode())
        stdin.seek(0)
        # A session (setsid) of its own: Ctrl-C at the terminal must not end the recorder before
        # the daemon has said its last. -P keeps the folder we run in off its module path.
        process = subprocess.Popen(
            [
                *(sys.executable, "-P", "-m", "vsensor.recording.process"),
                *(str(theirs.fileno()), ",".join(map(str, processors))),
            ],
            stdin=stdin,
            stdout=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(),),
            start_new_session=True,
        )
    try:
        _await_ready(ours, str(order["path"]))
    except BaseException:
        ours.close()
        process.kill()
        process.wait()
        raise
    ours.setblocking(False)
    return ours, process


def _await_ready(ours: socket.socket, path: str) -> None:
    ours.settimeout(START_S)
    try:
        answer = ours.recv(wire.PACKET_BYTES).decode()
    except TimeoutError as error:
        raise VsensorError(f"{path}: the recorder was not ready within {START_S:g} s") from error
    if not answer:
        raise VsensorError(f"{path}: the recorder ended at once; it said why above")
    if answer != wire.READY:
        raise InputError(answer)


def _enlarge(ours: socket.socket) -> None:
    try:
        ours.setsockopt(socket.SOL_SOCKET, _SO_SNDBUFFORCE, BUFFER_BYTES)
    except PermissionError:
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
