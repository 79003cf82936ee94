"""The gains: against a Kalman filter of the whole string, closed forms, and what holds for any of them."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.naive_kalman import PAST, Columns, Steady, steady
from tests.strings import COLLAR, PIPE
from vsensor.config import Component
from vsensor.estimator.along import stations
from vsensor.estimator.gains import ROCK_LEVELS, Gains, gains, rock_levels
from vsensor.estimator.responses import MEMORY_S, Plant, rock_fade
from vsensor.estimator.sections import Floats, cut, junction_depths
from vsensor.estimator.spectra import factorised

RATE, STEPS, LAG = 20.0, 2, 4
TORQUE_NOISE, SPEED_NOISE = 80.0, 0.015
FORGETS = math.exp(-1 / (MEMORY_S * RATE))
"""What the string of the design keeps in a tick."""
LEVELS = (0, 4, 8)

root = st.floats(-0.9, 0.9)


class Case(NamedTuple):
    plant: Plant
    gains: Gains
    ahead: tuple[int, int]


def worked_out(*string: Component, drag: float, lag: int = LAG, section: float = 700.0) -> Case:
    cuts = string, 1 / RATE / STEPS, section
    line = cut(*cuts)
    bit_rate, drive_rate = (2 * inertia * RATE * STEPS for inertia in (50.0, 800.0))
    plant = Plant(line, drag, bit_rate, drive_rate, STEPS, RATE, TORQUE_NOISE, SPEED_NOISE)
    travel = int(line.round_trip.sum()) // 2
    ahead = -(-travel // STEPS), -(-2 * travel // STEPS)
    at = stations(string, line, junction_depths(*cuts))
    return Case(plant, gains(plant, at, lag, (float(ahead[0]), float(ahead[1]))), ahead)


SHORT_PIPE = PIPE.model_copy(update={"length": 600.0})
RINGING = worked_out(SHORT_PIPE, COLLAR, drag=40.0)
DAMPED = worked_out(SHORT_PIPE.model_copy(update={"viscous_friction": 0.5}), drag=250.0, section=200.0)


def twin(case: Case, level: int, forgets: float) -> tuple[Columns, Steady]:
    columns = Columns(case.plant, LAG, rock_fade(RATE * STEPS))
    kick = ROCK_LEVELS[level] * math.sqrt(1 - rock_fade(RATE) ** 2)
    return columns, steady(columns, TORQUE_NOISE, SPEED_NOISE, kick, forgets)


def in_state(case: Case, columns: Columns, level: int) -> Floats:
    """The gains, laid out as the twin's state, which has the newest first."""
    told, at = case.gains, columns.at
    gain = np.zeros(columns.size)
    top, top_balance, bit, bit_balance, rock = told.state[level]
    gain[at["speed"].start], gain[at["speed"].stop - 1] = top, bit
    gain[at["top_balance"]], gain[at["bit_balance"]], gain[at["rock"]] = top_balance, bit_balance, rock
    for i in range(len(case.plant.line.impedance)):
        for name, rows in (("wave", told.waves), ("returned", told.returned)):
            gain[at[f"{name}{i}"]][: LAG * STEPS] = rows[level, i, ::-1]
    for name, row in zip(PAST, told.told[level], strict=True):
        gain[at[name]] = row[::-1]
    return gain


@given(root, root, st.floats(1e-3, 1e3))
def test_a_spectrum_with_a_known_factor_gives_it_back(zero: float, pole: float, variance: float) -> None:
    """s |(1 + b/z) / (1 − a/z)|²: the response is 1, a + b, a(a + b), …"""
    z = np.exp(1j * np.pi * np.arange(513) / 512)
    found, causal = factorised(variance * np.abs((1 + zero / z) / (1 - pole / z)) ** 2)
    response = (zero + pole) * pole ** np.arange(100.0)
    assert found == pytest.approx(variance, rel=1e-9)
    np.testing.assert_allclose(np.fft.irfft(causal)[:101], [1.0, *response], atol=1e-9)


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=12))
def test_any_spectrum_is_its_factor_squared_causal_and_causally_invertible(cepstrum: list[float]) -> None:
    angle = np.pi * np.arange(1025) / 1024
    spectrum = np.exp(np.cos(np.outer(angle, np.arange(len(cepstrum)))) @ np.array(cepstrum))
    variance, causal = factorised(spectrum)
    np.testing.assert_allclose(variance * np.abs(causal) ** 2, spectrum, rtol=1e-9)
    for response in (np.fft.irfft(causal), np.fft.irfft(1 / causal)):
        assert response[0] == pytest.approx(1)
        np.testing.assert_allclose(response[1024:], 0, atol=1e-9 * np.abs(response).max())


@pytest.mark.parametrize("case", [RINGING, DAMPED], ids=["ringing", "damped"])
@pytest.mark.parametrize("level", LEVELS)
def test_they_are_those_of_the_naive_kalman_smoother(case: Case, level: int) -> None:
    """Of the string that forgets as the design's does."""
    columns, filtered = twin(case, level, FORGETS)
    at, told = columns.at, case.gains
    # A wave of long ago was kept as it was then.
    kept = np.repeat(FORGETS ** -np.arange(LAG), STEPS)
    expected = filtered.gain.copy()
    for name in [name for name in at if name.startswith(("wave", "returned", *PAST))]:
        expected[at[name]][: LAG * STEPS] *= kept
    assert told.innovation[level] == pytest.approx(filtered.innovation, rel=3e-3)
    found = in_state(case, columns, level)
    for name, where in at.items():
        rows = slice(where.start, min(where.stop, where.start + LAG * STEPS))
        if name == "sample":  # a sample is not corrected, it is what it is
            continue
        if name == "speed":
            rows = where
            expected[where][1:-1] = 0.0  # nor are junctions without inertia: the next waves turn them
        scale = np.abs(expected[rows]).max()
        np.testing.assert_allclose(found[rows], expected[rows], atol=3e-3 * scale, rtol=0, err_msg=name)
    confirmed = [filtered.posterior[at[name], at[name]][-STEPS, -STEPS] * kept[-1] ** 2 for name in PAST]
    np.testing.assert_allclose(told.variance[level, :2], confirmed[:2], rtol=0.03)
    # Of a top that is known a hundred times better than the bit, the last digits are the transforms'.
    np.testing.assert_allclose(told.variance[level, 2:], confirmed[2:], rtol=0.03, atol=1e-3 * confirmed[0])


@pytest.mark.parametrize("level", LEVELS)
def test_what_they_say_of_predictions_is_that_of_the_naive_filter(level: int) -> None:
    columns, filtered = twin(RINGING, level, FORGETS)
    covariance = filtered.posterior
    for tick in range(1, RINGING.ahead[1] + 1):
        covariance = filtered.transition @ covariance @ filtered.transition.T + filtered.noise
        for kind, ahead in enumerate(RINGING.ahead):
            if tick == ahead:
                expected = [covariance[columns.at[name], columns.at[name]][0, 0] for name in PAST[:2]]
                np.testing.assert_allclose(RINGING.gains.unforeseen[level, kind], expected, rtol=3e-3)


def test_the_more_restless_the_rock_the_less_is_known_and_the_more_is_told() -> None:
    for case in (RINGING, DAMPED):
        told = case.gains
        for growing in (told.innovation, *told.variance.T, *told.unforeseen.reshape(len(ROCK_LEVELS), -1).T):
            assert (np.diff(growing) > 0).all()
            assert growing[0] > 0
        assert (np.diff(told.band) >= 0).all()
        assert told.band[-1] > told.band[0]


def test_who_waits_longer_knows_more_and_the_future_is_known_least() -> None:
    patient = worked_out(SHORT_PIPE, COLLAR, drag=40.0, lag=2 * LAG).gains
    assert (patient.variance < RINGING.gains.variance).all()
    unforeseen, confirmed = RINGING.gains.unforeseen, RINGING.gains.variance[:, :2]
    assert (confirmed < unforeseen[:, 0]).all()
    assert (unforeseen[:, 0] < unforeseen[:, 1]).all()


def test_along_the_string_the_bottom_is_known_as_well_as_the_bit() -> None:
    for case in (RINGING, DAMPED):
        np.testing.assert_allclose(case.gains.along[:, 0, -1], case.gains.variance[:, 0], rtol=1e-5)


@settings(max_examples=10)
@given(st.floats(1.0, 900.0))
def test_they_are_rounded_to_what_all_processors_agree_on(drag: float) -> None:
    """26 bits of each number, and of a row of one quantity 26 of its greatest."""
    told = worked_out(SHORT_PIPE, COLLAR, drag=drag).gains
    for name, values in told._asdict().items():
        greatest = np.abs(values)
        if name in ("waves", "returned", "told", "along"):
            greatest = np.broadcast_to(greatest.max(axis=-1, keepdims=True), values.shape)
        units = values / np.ldexp(1.0, np.frexp(greatest)[1] - 26)
        assert (units == np.rint(units)).all(), name
        assert (np.abs(units[(values == greatest) & (values != 0)]) >= 2**25).all(), name


@pytest.mark.parametrize("static", [0.0, 1000.0, 20e3])
def test_a_wells_string_has_the_wells_levels_of_the_rock_whatever_law_is_guessed(static: float) -> None:
    plant = RINGING.plant._replace(torque_noise=80.0, speed_noise=0.015, static=static)
    assert rock_levels(plant).tolist() == ROCK_LEVELS.tolist()


def test_where_little_is_hidden_by_noise_gains_are_ready_for_as_little_rock() -> None:
    """A rod of 10 mm, and a brake of 9 N·m at its end."""
    line = RINGING.plant.line._replace(impedance=1e-4 * RINGING.plant.line.impedance)
    levels = rock_levels(RINGING.plant._replace(line=line, torque_noise=0.1, speed_noise=0.01, static=9.0))
    assert levels[0] <= 0.05
    assert levels[-1] == ROCK_LEVELS[-1]
    assert levels[1:].tolist() == (2 * levels[:-1]).tolist()


def test_without_any_noise_the_levels_end_where_they_do_not_matter() -> None:
    plant = RINGING.plant._replace(torque_noise=0.0, speed_noise=0.0, static=8000.0)
    assert rock_levels(plant)[0] == ROCK_LEVELS[0]
    assert len(rock_levels(plant._replace(static=0.0))) < 30
