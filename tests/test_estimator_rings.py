"""The rings have room for what any correction of the delay asks of them: with more room all is the same."""

import numpy as np
import pytest

from tests.strings import BIT, DRIVE, PIPE, rig
from vsensor.config import Rig, Tuning
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.ring import SPARE
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import State
from vsensor.estimator.tune import BOUND, DELAY, PARAMETERS
from vsensor.jit import COMPILED

if not COMPILED:
    pytest.skip("hundreds of thousands of steps: too slow without the compiler", allow_module_level=True)

STEPS = {500.0: 1, 50.0: 5, 20.0: 13}
"""Internal steps of a tick, by its rate, Hz."""


def corrected_to_its_bound(unsure: Rig) -> Estimator:
    estimator = Estimator(unsure)
    saved = estimator.save()
    saved["tuning.value"] = np.zeros(PARAMETERS)
    saved["tuning.value"][DELAY] = BOUND * unsure.tuning.delay
    estimator.restore(saved)
    return estimator


def longer(rings: Floats) -> Floats:
    return np.concatenate([np.tile(rings[..., :-SPARE], 4), rings[..., -SPARE:]], axis=-1)


def roomier(state: State) -> State:
    """Before the first tick, all rings four times as long."""
    return state._replace(
        waves=longer(state.waves),
        returned=longer(state.returned),
        innovations=np.tile(state.innovations, 4),
        levels=np.tile(state.levels, 4),
        told=longer(state.told),
        ahead=longer(state.ahead),
        scores=state.scores._replace(
            foretold=np.tile(state.scores.foretold, 4), laws=np.tile(state.scores.laws, (1, 4, 1, 1))
        ),
    )


@pytest.mark.parametrize("delay", [0.01, 0.04, 0.3])
@pytest.mark.parametrize("rate", STEPS)
def test_a_delay_corrected_to_its_bound_finds_room(rate: float, delay: float) -> None:
    pipe = PIPE.model_copy(update={"length": 2600.0})
    unsure = rig(pipe, bit=BIT, top_drive=DRIVE, rate=rate, estimator={"lag": 0.1})
    unsure = unsure.model_copy(update={"tuning": Tuning(delay=delay)})
    seconds = np.arange(round(14 * rate)) / rate
    torque, speed = 5e3 + 3e3 * np.sin(3 * seconds), 9.0 + 3 * np.sin(2 * seconds)
    told: list[tuple[Floats, Floats]] = []
    for give_room in (False, True):
        estimator = corrected_to_its_bound(unsure)
        assert estimator.steps_per_tick == STEPS[rate]
        assert estimator.tuning[DELAY] == pytest.approx(3 * delay)
        if give_room:
            estimator._state = roomier(estimator._state)
            estimator._run_by(estimator._model)
        told.append((estimator.run(torque, speed).values, estimator.profile()))
    assert np.isfinite(told[0][0][-1, :16]).all()
    np.testing.assert_array_equal(told[0][0], told[1][0])
    np.testing.assert_array_equal(told[0][1], told[1][1])
