"""From the start of the daemon to its first answer, with kernels to compile and with kernels at hand."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import zenoh

from vsensor import demo
from vsensor.bench.live import rig_at
from vsensor.bench.table import Table
from vsensor.bus import open_session
from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.estimator.estimator import Estimator
from vsensor.messages import BIT_ESTIMATE, Estimate

PATIENCE_S = 300.0


def tables(rate_hz: float, say: Callable[[str], None]) -> Iterator[Table]:
    """Start the demonstration's daemon again and again. Raises VsensorError where one does not answer."""
    rig = rig_at(rate_hz)
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        recording = rig.recording.model_copy(update={"folder": Path(name)})
        rig = demo.on_free_port(rig.model_copy(update={"recording": recording}))
        config = Path(name) / "rig.toml"
        config.write_text(effective_toml(rig), encoding="utf-8")
        say("the daemon starts, with kernels to compile")
        cold = _start(rig, config, {"NUMBA_CACHE_DIR": f"{name}/kernels"})
        say("and again, with the kernels of before")
        warm = _start(rig, config, {"NUMBA_CACHE_DIR": f"{name}/kernels"})
    needed = Estimator(rig).warm_up
    yield Table(
        f"Start of the daemon at {rate_hz:g} Hz",
        ("kernels", "until READY, s", "until the first answer, s", "samples needed, s"),
        (("to compile", *cold, needed), ("at hand", *warm, needed)),
        ("the yardstick is the last column: so much of the rig's samples the waves in this string take",),
    )


def _start(rig: Rig, config: Path, environment: dict[str, str]) -> tuple[float, float]:
    """Time until it is ready, and until the first answer."""
    begun = time.monotonic()
    with ExitStack() as running:
        daemon = running.enter_context(_daemon(config, environment))
        demo.await_ready(daemon)
        ready = time.monotonic() - begun
        running.enter_context(demo.process("simulate", str(config)))
        session = running.enter_context(open_session(rig.bus, "client"))
        heard = session.declare_subscriber(
            f"{rig.prefix}/{BIT_ESTIMATE}", zenoh.handlers.RingChannel(1 << 16)
        )
        while time.monotonic() - begun < PATIENCE_S:
            raw = heard.try_recv()
            if raw is None:
                time.sleep(0.005)
            elif Estimate.FromString(raw.payload.to_bytes()).HasField("confirmed_bit_speed_rad_s"):
                return ready, time.monotonic() - begun
    raise VsensorError(f"the daemon has told nothing of the bit within {PATIENCE_S:g} s")


@contextmanager
def _daemon(config: Path, environment: dict[str, str]) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", "run", str(config)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
        start_new_session=True,
    ) as running:
        try:
            yield running
        finally:
            running.terminate()
            running.communicate(timeout=demo.END_S)
