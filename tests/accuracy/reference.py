"""The reference cases: yardsticks and answers, right and wrong configurations, and the limits."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tests.accuracy import limits, lumps, words
from tests.accuracy.score import Answer, Score, answer, score, span, surface_speed
from tests.accuracy.sticks import Foretold, foretold
from tests.accuracy.tare import off_bottom_first
from tests.accuracy.wrong import rough_law, wrongs
from tests.cases import Columns, Learned, Run, reference_rig, run, table
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.tune import OFFSET
from vsensor.units import factor

FROM_S, LATE_S, LEARNED_S = 10.0, 40.0, 30.0
KINDS = ("confirmed", "now", "forecast")
RPM = factor("rad/s", "rpm")
TORQUE_LIMIT = 300.0
"""Rms error of the confirmed bit torque that the project allows itself, N·m."""


@dataclass(frozen=True)
class Case:
    """One reference case."""

    folder: Path
    name: str
    words: str
    limit: float
    """Rms error of the confirmed bit speed that the project allows itself, share of its range."""

    @property
    def title(self) -> str:
        """Its words as a heading."""
        return self.words[0].upper() + self.words[1:]

    @cached_property
    def rig(self) -> Rig:
        """The right configuration."""
        return reference_rig(self.folder / f"{self.name}.json")

    @cached_property
    def surface(self) -> Columns:
        """What is measured."""
        return table(self.folder / f"{self.name}_surface.csv")

    @cached_property
    def truth(self) -> Columns:
        """What is to be told."""
        return table(self.folder / f"{self.name}_downhole.csv")

    @cached_property
    def run_right(self) -> Run:
        """What comes of the right configuration,"""
        return self.run(self.rig)

    @property
    def right(self) -> Columns:
        """and the estimates of it."""
        return self.run_right.told

    @property
    def sticks(self) -> Foretold:
        """What is foretold of sticks."""
        readings = zip(self.surface["motor_torque_nm"], self.surface["motor_speed_rad_s"], strict=True)
        return foretold(self.rig, ((float(torque), float(speed)) for torque, speed in readings))

    @cached_property
    def tried(self) -> dict[lumps.Tuning, lumps.Filtered]:
        """The two-lump filter with each of its tunings."""
        return {tuning: lumps.watched(self.rig, self.surface, tuning) for tuning in lumps.TUNINGS}

    @cached_property
    def lag(self) -> int:
        """How late our confirmed answer is, in samples."""
        return round(Estimator(self.rig).confirmed_delay * self.rig.loop.rate)

    @property
    def mean_speed(self) -> float:
        """Mean of the true bit speed where it is scored, rad/s."""
        return float(np.mean(self.truth["bit_speed_rad_s"][self.truth["time_s"] >= FROM_S]))

    @property
    def rock(self) -> limits.Rock:
        """The rock's own torque."""
        return limits.Rock(*json.loads((self.folder / f"{self.name}.json").read_text())["bit_noise"])

    def run(self, rig: Rig, learned: Learned | None = None) -> Run:
        """What comes of any configuration, and of what was learned before."""
        return run(rig, self.folder / f"{self.name}_surface.csv", learned=learned)

    def of_lumps(self, filtered: lumps.Filtered, lag: int) -> Answer:
        """What a two-lump filter says `lag` samples late."""
        return lumps.told(filtered, self.surface["time_s"], lag)

    def tuned_by_truth(self, lag: int) -> lumps.Tuning:
        """The tuning with the least error of bit speed at a lag."""
        return min(self.tried, key=lambda one: self.score(self.of_lumps(self.tried[one], lag)).speed)

    def score(self, of: Answer, from_s: float = FROM_S) -> Score:
        """Hold an answer against the truth."""
        return score(of, self.truth, from_s)


def cases(folder: Path) -> list[Case]:
    """All cases that have a range of speed to miss."""
    return [
        Case(folder, "stick_slip", "full stick-slip under a stiff speed controller", 0.005),
        Case(folder, "smooth_drilling", "rotary drilling in rough rock", 0.015),
        Case(folder, "deviated_off_bottom", "a lateral, off bottom: wall friction along the string", 0.015),
    ]


def exact(case: Case) -> Iterator[str]:
    """Yardsticks and answers of a case, and what the project asked of itself."""
    yield f"\n### {case.title}"
    yield words.EXACT_ROWS
    of = case.score(surface_speed(case.surface))
    yield f"| surface speed | {of.speed * RPM:.1f} | {of.share:.2%} | | | | |"
    yield from by_lumps(case)
    for kind in KINDS:
        yield row(f"**{kind}**", case.score(answer(case.right, kind)))
    yield "\n" + verdict(case)


def by_lumps(case: Case) -> Iterator[str]:
    """The two-lump filter, tuned by likelihood and by the truth, now and as late as our confirmed answer."""
    start = round(FROM_S * case.rig.loop.rate)
    likeliest = max(case.tried.values(), key=lambda one: one.likelihood(start))
    lags = {"now": 0, "confirmed": case.lag}
    for kind, lag in lags.items():
        yield row(f"two lumps by likelihood, {kind}", case.score(case.of_lumps(likeliest, lag)))
    for kind, lag in lags.items():
        best = case.tried[case.tuned_by_truth(lag)]
        yield row(f"two lumps by the truth, {kind}", case.score(case.of_lumps(best, lag)))


def row(name: str, of: Score) -> str:
    """A row of the table of errors."""
    return (
        f"| {name} | {of.speed * RPM:.1f} | {of.share:.2%} | {of.torque / 1e3:.2f} | {of.bias:+.0f} "
        f"| {of.speed_within:.0%} | {of.torque_within:.0%} |"
    )


def verdict(case: Case) -> str:
    """Whether the confirmed answer keeps what the project asked of itself."""
    of = case.score(answer(case.right, "confirmed"))

    def kept(value: float, limit: float) -> str:
        return "kept" if value <= limit else "**missed**"

    return (
        f"Asked of the confirmed answer: speed within {case.limit:.1%} of the range, "
        f"{kept(of.share, case.limit)} ({of.share:.2%}); torque within {TORQUE_LIMIT:.0f} N·m rms, "
        f"{kept(of.torque, TORQUE_LIMIT)} ({of.torque:.0f} N·m)."
    )


def least(case: Case) -> dict[str, limits.Limit]:
    """The least errors that anyone can reach in a case whose bit does not stick, by answer."""
    estimator = Estimator(case.rig)
    travel, late = estimator.forecast_horizon, estimator.confirmed_delay
    horizons = {
        "now": late,
        "now, no lag": travel,
        "forecast": late + travel,
        "forecast, no lag": 2 * travel,
    }
    return {
        "confirmed": limits.confirmed(case.rig, case.rock, case.mean_speed),
        **{
            name: limits.foretold(case.rig, case.rock, case.mean_speed, horizon)
            for name, horizon in horizons.items()
        },
    }


def limit(case: Case) -> Iterator[str]:
    """What is said of the least errors."""
    estimator = Estimator(case.rig)
    yield words.LIMIT.format(
        case=case.words,
        rpm=case.mean_speed * RPM,
        std=case.rock.std,
        time=case.rock.time,
        lag=estimator.confirmed_delay - estimator.forecast_horizon,
    )
    ranged = span(case.truth, FROM_S)
    for name, of in least(case).items():
        yield f"| {name} | {of.speed * RPM:.1f} | {of.speed / ranged:.2%} | {of.torque / 1e3:.2f} |"


def wrong(case: Case) -> Iterator[str]:
    """A case with each wrong configuration."""
    yield f"\n### {case.title}, wrong configuration"
    yield words.WRONG_ROWS
    tuning = case.tuned_by_truth(case.lag)
    for name, rig, learned in _configured(case):
        told, corrected = case.run_right if rig is case.rig else case.run(rig, learned)
        yardstick = case.of_lumps(lumps.watched(rig, case.surface, tuning), case.lag)
        answers = [yardstick, *(answer(told, kind) for kind in KINDS)]
        soon, late = ([case.score(of, start) for of in answers] for start in (FROM_S, LATE_S))
        cells = [f"{a} ({b})" for a, b in zip(_wrong_cells(soon), _wrong_cells(late), strict=True)]
        cells += [f"{share:+.1%}" for share in corrected[:OFFSET]]
        yield f"| {name} | {' | '.join(cells)} |"


def _configured(case: Case) -> Iterator[tuple[str, Rig, Learned | None]]:
    """Each wrong configuration by name; those with wrong friction once more after a tare."""
    rigs = wrongs(case.rig)
    for name, rig in rigs.items():
        yield name, rig, None
    for name, rig in rigs.items():
        if rig.string[0].viscous_friction != case.rig.string[0].viscous_friction:
            yield f"{name}, after a tare", rig, off_bottom_first(rig, case.rig)


def _wrong_cells(of: list[Score]) -> list[str]:
    yardstick, confirmed, now, forecast = of
    return [
        *(f"{one.share:.2%}" for one in (yardstick, confirmed)),
        f"{confirmed.torque / 1e3:.2f}",
        *(f"{one.share:.2%}" for one in (now, forecast)),
        *(f"{within:.0%}" for within in (confirmed.speed_within, confirmed.torque_within)),
        *(f"{one.speed_within:.0%}" for one in (now, forecast)),
    ]


def scratch(case: Case) -> Iterator[str]:
    """A case whose load law starts from a rough guess."""
    told = case.run(rough_law(case.rig)).told
    for kind in KINDS:
        rough, right = (case.score(answer(of, kind), LEARNED_S) for of in (told, case.right))
        cells = [f"{a} ({b})" for a, b in zip(_scratch_cells(rough), _scratch_cells(right), strict=True)]
        yield f"| {case.words if kind == KINDS[0] else ''} | {kind} | {' | '.join(cells)} |"


def _scratch_cells(of: Score) -> list[str]:
    return [
        f"{of.share:.2%}",
        f"{of.torque / 1e3:.2f}",
        f"{of.bias:+.0f}",
        f"{of.speed_within:.0%}",
        f"{of.torque_within:.0%}",
    ]
