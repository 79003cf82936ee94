"""Everything that the figures, the tables and the page tell, computed once."""

from typing import NamedTuple

from vsensor.paper import cases, comparison, fine, lumped, stick_slip
from vsensor.paper.chain import Motion
from vsensor.paper.comparison import LENGTHS, Errors, Models, Study
from vsensor.paper.shaft import BIT, SHAFT, TORQUE, Response, Trace

RAISED_TORQUE = 9000.0
"""What ends the paper's stick-slip, N·m."""

_HALVINGS = 10
_DRILLING = 80.0
_CASES = 120.0
_CASE_STEPS = 400


class Results(NamedTuple):
    """All that is shown."""

    stick_slip: Motion
    """Under the paper's torque."""
    smooth: Motion
    """Under the raised one."""
    models: dict[float, Models]
    """By length, m."""
    errors: dict[float, tuple[Errors, Errors]]
    """Of the top and of the end, by length."""
    studies: tuple[Study, ...]
    refined: Response
    """The paper's length, its grid refined by Richardson's rule."""
    four_inertias: tuple[Motion, Motion]
    """At 10 and at 12 kN·m."""
    neutral_delay: tuple[Trace, Trace]
    """At 10 and at 15 rad/s."""

    @property
    def paper(self) -> Models:
        """The models of the paper's own length."""
        return self.models[SHAFT.length]

    def outcomes(self) -> tuple[cases.Outcome, ...]:
        """What the cases of others come to."""
        return cases.outcomes(*self.four_inertias, *self.neutral_delay)


def compute() -> Results:
    """Run every model: a few seconds."""
    string = lumped.of_shaft(SHAFT)
    models = {length: comparison.models(length) for length in LENGTHS}
    return Results(
        stick_slip=stick_slip.drill(string, TORQUE, _DRILLING),
        smooth=stick_slip.drill(string, RAISED_TORQUE, _DRILLING),
        models=models,
        errors={length: comparison.errors(of) for length, of in models.items()},
        studies=tuple(comparison.study(length, _HALVINGS) for length in LENGTHS),
        refined=fine.refined(SHAFT, BIT, TORQUE, comparison.WINDOW, comparison.fine_steps(SHAFT)),
        four_inertias=(cases.four_inertias(10e3, _CASES), cases.four_inertias(12e3, _CASES)),
        neutral_delay=(
            cases.neutral_delay(10.0, _CASES, _CASE_STEPS),
            cases.neutral_delay(15.0, _CASES, _CASE_STEPS),
        ),
    )
