"""Figs. 9 and 10 for any length: what falls with the shaft's length, and what does not."""

import numpy as np
import pytest

from vsensor.estimator import component
from vsensor.paper import comparison
from vsensor.paper.comparison import FINE_STEP, LENGTHS, Errors, models


@pytest.fixture(scope="module")
def errors() -> dict[float, tuple[Errors, Errors]]:
    return {length: comparison.errors(models(length)) for length in LENGTHS}


def test_the_papers_model_gets_worse_as_the_shaft_grows(
    errors: dict[float, tuple[Errors, Errors]],
) -> None:
    at_the_bit = [errors[length][1] for length in LENGTHS]
    for name in ("printed", "stepping", "samples"):
        assert np.all(np.diff([getattr(error, name) for error in at_the_bit]) > 0)
    assert at_the_bit[0].stepping > 0.01
    assert at_the_bit[-1].stepping > 0.1


def test_nearly_all_of_that_is_its_stepping(errors: dict[float, tuple[Errors, Errors]]) -> None:
    for _, end in errors.values():
        assert end.stepping == pytest.approx(end.printed, rel=0.05)


def test_ours_does_not(errors: dict[float, tuple[Errors, Errors]]) -> None:
    for ends in zip(*(errors[length] for length in LENGTHS), strict=True):
        fine = [error.fine for error in ends]
        assert np.all(np.diff(fine) < 0)
    assert max(end.fine for _, end in errors.values()) < 2e-6
    assert max(top.fine for top, _ in errors.values()) < 1e-4


def test_the_lumped_string_is_no_worse_at_the_bit_than_the_papers_model(
    errors: dict[float, tuple[Errors, Errors]],
) -> None:
    for _, end in errors.values():
        assert end.lumped < end.printed


def test_the_error_hangs_on_the_step() -> None:
    """In steps of about one size a shaft twice as long does no worse, by either rule."""
    short, long = comparison.study(1000.0, 7), comparison.study(2000.0, 8)
    np.testing.assert_allclose(long.step[1:], short.step)
    assert np.all(long.papers_rule[1:] <= short.papers_rule * 1.3)
    assert np.all(long.kernels[2:] <= short.kernels[1:])


def test_one_step_a_round_trip_is_the_papers_own_error(
    errors: dict[float, tuple[Errors, Errors]],
) -> None:
    assert comparison.study(4000.0, 1).papers_rule[0] == errors[4000.0][1].samples


def test_the_papers_rule_is_of_first_order_and_the_kernels_of_second() -> None:
    study = comparison.study(4000.0, 10)
    assert study.papers_rule[-2] / study.papers_rule[-1] == pytest.approx(2, rel=0.05)
    assert study.kernels[-2] / study.kernels[-1] == pytest.approx(4, rel=0.05)
    assert np.isnan(study.kernels[0])


def test_the_lumped_bit_starts_at_once_and_the_distributed_after_its_delay() -> None:
    of = models(4000.0)
    theta = component.delay(of.shaft)
    assert of.lumped.end.value[1] > 0
    for trace in (of.printed.end, of.fine.end):
        moving = trace.time[trace.value > 0][0]
        assert moving == pytest.approx(theta, abs=FINE_STEP)


def test_the_lumped_string_does_not_swing_and_the_distributed_one_does() -> None:
    of = models(4000.0)
    assert of.lumped.top.value.max() < 17.5
    assert of.printed.top.value.max() < 17.5
    assert of.fine.top.value.max() > 2 * 17.5
    assert of.fine.top.value.min() < 0
