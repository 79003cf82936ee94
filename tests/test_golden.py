"""The session in recordings/ must come out bit for bit: any change of a kernel's numbers is told here."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from vsensor.config import loads
from vsensor.estimator import kernel
from vsensor.estimator.state import Model, State
from vsensor.messages import SENSOR_TICK, Estimate, Tick
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

GOLDEN = Path(__file__).parent.parent / "recordings" / "stick_slip.mcap"


def test_the_recorded_session_is_estimated_again_bit_for_bit() -> None:
    session = Session(GOLDEN)
    rig = loads(session.configuration or "", str(GOLDEN))
    verdict = verify(session, Engine(rig))
    assert verdict.exact, verdict
    assert verdict.compared > 15 * rig.loop.rate


def test_a_slightly_different_string_is_noticed() -> None:
    session = Session(GOLDEN)
    rig = loads(session.configuration or "", str(GOLDEN))
    pipe, *rest = rig.string
    # Not longer: how long it is the session's own state tells.
    thicker = pipe.model_copy(update={"outer_diameter": 1.01 * pipe.outer_diameter})
    verdict = verify(session, Engine(rig.model_copy(update={"string": (thicker, *rest)})))
    assert verdict.first is not None
    assert verdict.mismatches > verdict.compared / 2


def test_a_changed_kernel_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers moved in their last bit alone: a kernel's numbers must not change unnoticed by any amount."""
    session = Session(GOLDEN)
    rig = loads(session.configuration or "", str(GOLDEN))

    as_it_stands = kernel.turns

    def nudged(model: Model, state: State, *arrays: Any) -> Iterator[int]:
        for count in as_it_stands(model, state, *arrays):
            arrays[-2][:] *= 1.0 + 2.3e-16
            yield count

    monkeypatch.setattr(kernel, "turns", nudged)
    verdict = verify(session, Engine(rig))
    assert not verdict.exact
    assert verdict.mismatches > verdict.compared / 2


def test_one_changed_input_is_noticed() -> None:
    session = Session(GOLDEN)

    class Nudged(Engine):
        def step(self, tick: Tick) -> Estimate:
            if tick.number == 500:
                tick.motor_torque_nm += 1e-6
            return super().step(tick)

    assert sum(1 for _ in session.messages((SENSOR_TICK,))) > 500
    assert not verify(session, Nudged(loads(session.configuration or "", str(GOLDEN)))).exact
