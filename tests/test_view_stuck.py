"""A page that is frozen in its browser holds up nobody else, and fills no memory."""

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np
import pytest

from tests.view_process import free_port, until
from vsensor.view.batches import Points
from vsensor.view.blueprint import blueprint
from vsensor.view.place import Place
from vsensor.view.screen import Screen
from vsensor.view.stuck import EVERY_S, PATIENCE_S, Stuck
from vsensor.view.units import Units

pytestmark = pytest.mark.skipif("sys.platform != 'linux'", reason="elsewhere the kernel does not tell")


@contextmanager
def connected(server: socket.socket) -> Iterator[tuple[socket.socket, socket.socket]]:
    """Both ends of a connection."""
    with socket.create_connection(server.getsockname()) as client:
        ours, _ = server.accept()
        with ours:
            ours.setblocking(False)
            yield client, ours


def fill(ours: socket.socket) -> None:
    """Send until nothing more goes."""
    with suppress(BlockingIOError):
        while True:
            ours.send(bytes(1 << 16))


def is_cut(client: socket.socket) -> bool:
    """Whether the end of what was sent is an end of all."""
    client.settimeout(0.2)
    try:
        while client.recv(1 << 20):
            pass
    except TimeoutError:
        return False
    return True


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


def looks(stuck: Stuck, *times_s: float) -> int:
    return sum(stuck.let_go(each) for each in times_s)


def test_who_takes_nothing_is_cut_off_and_the_others_are_not(server: socket.socket) -> None:
    stuck = Stuck(server.getsockname()[1])
    with connected(server) as (frozen, to_frozen), connected(server) as (idle, _):
        fill(to_frozen)
        assert looks(stuck, 100.0, 100.0 + PATIENCE_S - EVERY_S) == 0
        assert looks(stuck, 100.0 + PATIENCE_S) == 1
        assert is_cut(frozen)
        assert not is_cut(idle)
        assert looks(stuck, 300.0, 300.0 + PATIENCE_S) == 0


def test_who_is_slow_is_not_cut_off(server: socket.socket) -> None:
    stuck = Stuck(server.getsockname()[1])
    with connected(server) as (slow, ours):
        for turn in range(10):
            fill(ours)
            assert looks(stuck, 100.0 + turn * PATIENCE_S / 2) == 0
            slow.recv(1 << 20, socket.MSG_WAITALL)


def test_connections_of_other_servers_are_left_alone(server: socket.socket) -> None:
    stuck = Stuck(free_port())
    with connected(server) as (frozen, ours):
        fill(ours)
        assert looks(stuck, 100.0, 200.0) == 0
        assert not is_cut(frozen)


ASKS = (
    b"POST /rerun.sdk_comms.v1alpha1.MessageProxyService/ReadMessages HTTP/1.1\r\nHost: 127.0.0.1\r\n"
    b"Content-Type: application/grpc-web+proto\r\nContent-Length: 5\r\n\r\n" + bytes(5)
)
"""As a browser's page asks for everything."""


@pytest.mark.process
def test_a_page_that_is_frozen_is_let_go_by_reruns_server() -> None:
    place = Place("page", free_port())
    stuck = Stuck(place.data_port)
    with (
        Screen("t", lambda reach: blueprint(30.0, Units(), reach), place) as screen,
        socket.socket() as frozen,
    ):
        frozen.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 14)
        frozen.connect(("127.0.0.1", place.data_port))
        frozen.sendall(ASKS)
        assert frozen.recv(15) == b"HTTP/1.1 200 OK"
        clock_s, turn = time.monotonic(), 0

        def cut() -> bool:
            """Send some more, and look as if a second had passed."""
            nonlocal turn
            turn += 1
            times_ns = np.arange(10_000) + 10_000 * turn
            screen.send([Points("/line", times_ns, np.random.default_rng(turn).normal(size=10_000))])
            return stuck.let_go(clock_s + turn * EVERY_S) == 1

        until(cut)
        assert turn * EVERY_S > PATIENCE_S
        frozen.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        assert is_cut(frozen)
