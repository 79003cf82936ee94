"""The session in recordings/ must come out bit for bit: any change of a kernel's numbers is told here."""

from pathlib import Path

from vsensor.config import loads
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
    longer = rig.model_copy(update={"string": (pipe.model_copy(update={"length": pipe.length + 10}), *rest)})
    verdict = verify(session, Engine(longer))
    assert verdict.first is not None
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
