"""What the page says, in the paper's order."""

from collections.abc import Iterator
from itertools import groupby

from vsensor.estimator import component
from vsensor.paper import distributed
from vsensor.paper.cases import period
from vsensor.paper.errata import ERRATA
from vsensor.paper.page import Figure, Section, Table, number
from vsensor.paper.results import RAISED_TORQUE, Results
from vsensor.paper.shaft import SHAFT, TORQUE, load_as_printed, shear_stress
from vsensor.paper.stick_slip import CATCH_SPEED, CAUGHT, FREE, STICKTION
from vsensor.paper.values import Value

TITLE = "A long slender shaft, by its own equations"
LEAD = (
    "<em>Real Time Monitoring of Long Slender Shaft by Distributed-Lumped Modeling Techniques</em> asks "
    "what the bit of a drill string feels, from what is known at its top. Here is every model and figure "
    "of it, running: what the paper says, what is right, and what the same equations tell when they are "
    "stepped finely. Numbers of equations and figures are the paper's."
)


def sections(results: Results, rows: tuple[Value, ...]) -> tuple[Section, ...]:
    """The page's parts."""
    return (
        _findings(results),
        _lumped(),
        _stick_slip(results),
        _line(),
        _distributed(results),
        _fine(),
        _comparison(results),
        _stress(results),
        _others(results),
        _errata(),
        Section(
            "All numbers",
            (
                "Also in <code>values.csv</code>. “Expected” is what the paper prints, or what an "
                "independent simulation gave.",
                *_by_topic(rows),
            ),
        ),
    )


def _by_topic(rows: tuple[Value, ...]) -> Iterator[Table]:
    for topic, told in groupby(rows, key=lambda row: row.topic):
        yield Table(topic, ("quantity", "unit", "value", "expected"), [row[1:] for row in told], 6)


def _findings(results: Results) -> Section:
    of = results.paper
    shortest, longest = min(results.errors), max(results.errors)
    near, far = results.errors[shortest][1], results.errors[longest][1]
    ends = {
        name: shear_stress(SHAFT, getattr(of, name).end_torque.value) / 1e6 for name in ("printed", "fine")
    }
    items = (
        "<b>The idea holds.</b> A shaft is a delay line for two waves. The bit turns "
        f"{component.delay(SHAFT):.2f} s after the top, and no lumped model can say so.",
        "<b>The printed transfer functions do not.</b> (24) and (25) as printed settle at "
        f"{_steady_as_printed():,.0f} rad/s instead of {TORQUE / load_as_printed(SHAFT).damping:g}. With "
        "their numerators mended they are sound.",
        "<b>“Less oscillation than the lumped model” is the stepping.</b> The paper looks at the load "
        f"once a round trip, each {2 * component.delay(SHAFT):.2f} s. Stepped finely, the top swings between "
        f"{number(of.fine.top.value.min(), 2)} and {number(of.fine.top.value.max(), 2)} rad/s; the lumped "
        "string does not overshoot at all.",
        "<b>“Accuracy falls as the string grows” is the stepping too.</b> Its step is tied to the length: "
        f"from {shortest:.0f} to {longest:.0f} m the error of the bit's speed goes from "
        f"{_percent(near.stepping)} to {_percent(far.stepping)}. In steps of 1 ms it goes from "
        f"{_percent(near.fine)} to {_percent(far.fine)}.",
        "<b>Stress is what it costs.</b> At the end of the shaft the paper's steps show at most "
        f"{ends['printed'].max():.0f} MPa. In the string's equations there are "
        f"{ends['fine'].max():.0f} MPa, and {-ends['fine'].min():.0f} MPa the other way.",
        "<b>The shaft's inertia is counted twice</b>, once in the line and once in J_L.",
    )
    return Section("In short", ("<ul>" + "".join(f"<li>{item}</li>" for item in items) + "</ul>",))


def _steady_as_printed() -> float:
    return distributed.steady_as_printed(SHAFT, load_as_printed(SHAFT), TORQUE)


def _percent(share: float) -> str:
    return f"{number(100 * share, 2)} %"


def _lumped() -> Section:
    return Section(
        "Two inertias and a spring: eq. (1) to (3)",
        (
            "The pipe is one inertia, collars and bit another, a damped spring between them. The second "
            "line of (1) is misprinted: the spring's damping there must be the c of the first line, or "
            "torque would be lost on its way.",
            "<pre>T_m                           = (J_r s + C_r) ω_r + c (ω_r − ω_b) + k (φ_r − φ_b)\n"
            "k (φ_r − φ_b) + c (ω_r − ω_b) = (J_b s + C_b) ω_b</pre>",
            Figure("fig02_lumped"),
        ),
    )


def _stick_slip(results: Results) -> Section:
    motion = results.stick_slip
    return Section(
        "Stick-slip: section III",
        (
            f"The paper shows stick-slip at {TORQUE:.0f} N·m, the bit between 0 and {CATCH_SPEED:g} "
            f"rad/s, and none at {RAISED_TORQUE:.0f} N·m. It prints neither friction law nor values. The "
            "ones here are ours, and take its words as they stand, “caught by friction … and then "
            "release”, switched by a relay with two points:",
            f"<pre>at rest   held until the shaft's torque passes {STICKTION:.0f} N·m, by the pipe's swing\n"
            f"free      turns against {FREE:.0f} N·m, until it is faster than {CATCH_SPEED:g} rad/s\n"
            f"caught    turns against {CAUGHT:.0f} N·m, until it is at rest</pre>",
            "The instants of change are found by root search, and each stretch between them is smooth: "
            f"nothing chatters. The period is {period(motion.times('free')):.1f} s.",
            Figure("fig04_stick_slip"),
            Figure("fig05_smooth"),
            "Why not friction that falls with speed, as in the textbooks? Because with the paper's own "
            "values it cannot swing. However steep the fall, the two inertias' swing against each other "
            "dies out, damped by c = 200 N·m·s/rad; what grows instead is the mean speed. Strings that do "
            "it by falling friction are at the end of this page.",
        ),
    )


def _line() -> Section:
    return Section(
        "Any line: eq. (4) to (17)",
        (
            "Voltage and current, pressure and flow, torque and speed: with losses R in series and G in "
            "shunt, one pair of equations, one matrix. The paper writes it in w = coth Γl and in z⁻¹ = "
            "e^(−2Γl); both are here, agree to rounding, and agree with the program's own kernels.",
            "<pre>du/dx = −(Ls + R) y      dy/dx = −(Cs + G) u      Γ = √((Ls+R)(Cs+G))      ξ = "
            "√((Ls+R)/(Cs+G))</pre>",
            Figure("fig06_general_line"),
        ),
    )


def _distributed(results: Results) -> Section:
    first = results.paper.printed.end.value[0]
    return Section(
        "The distributed-lumped string: eq. (18) to (25)",
        (
            "The shaft is the line without losses, the load T₁ = (J_L s + D_L) ω₁ is stepped once a round "
            "trip, and both become difference equations in x = z⁻¹. Multiplied out, with α = e^(−D_L "
            "T_p/J_L) and β = (1 − α)/D_L:",
            "<pre>ω₀/T₀ = [(1+ζβ) + (ζβ−1−α) x + α x²] / { ζ [(1+ζβ) + (1−α−ζβ) x − α x²] }     (24)\n"
            "ω₁/T₀ = 2β x^½ / [(1+ζβ) + (1−α−ζβ) x − α x²]                                 (25)</pre>",
            Figure("fig08_distributed"),
            f"The first sample of the bit is {first:.2f} rad/s at the very instant when the first wave "
            "arrives. A load of inertia cannot do that: the rule lets the torque of a sample act on the "
            "whole round trip before it.",
        ),
    )


def _fine() -> Section:
    return Section(
        "The same, stepped finely",
        (
            "The program's kernels step the load by the trapezoid rule in steps as fine as one likes. "
            "Beside them stands a closed form: each echo is a Laguerre function, and their sum is exact.",
            "<pre>F(s) = (2T₀/s) Σ (−Γ e^(−2θs))ⁿ      Γ = (J s + D − ζ)/(J s + D + ζ)      echo n:  "
            "e^(−pt) Lₙ(at)</pre>",
            Figure("fig08_fine"),
        ),
    )


def _comparison(results: Results) -> Section:
    def table(words: str, end: int) -> Table:
        head = (
            "length, m",
            "round trip, s",
            "lumped",
            "the paper's",
            "its stepping alone",
            "at its own samples",
            "1 ms steps",
        )
        rows: list[tuple[str | float, ...]] = [
            (
                f"{length:.0f}",
                f"{2 * component.delay(results.models[length].shaft):.3f}",
                *(100 * e for e in errors[end]),
            )
            for length, errors in results.errors.items()
        ]
        return Table(f"Rms error of the speed {words} over 40 s, in % of the steady speed", head, rows, 3)

    return Section(
        "Compared, for any length: Figs. 9 and 10",
        (
            Figure("fig09_top"),
            Figure("fig10_end"),
            "Does accuracy fall as the string grows? The paper's does, and the table says why. “Its "
            "stepping alone” is held against the very same equations with the same load, solved exactly: "
            "almost the whole error is in it, also “at its own samples”. So much is lost that at the bit "
            "the lumped model is nearer to the truth at every length. What a distributed model is for, it "
            "gives away by looking once a round trip.",
            table("at the bit", 1),
            table("at the top", 0),
            Figure("errors"),
            Figure("fig09_10_lengths"),
            "Note what all of this leaves out. These equations lose nothing along the shaft, and their "
            "torque is held whatever the top does, so echoes last for minutes. A real string has wall "
            "friction and a top drive's inertia, which is why the program has both.",
        ),
    )


def _stress(results: Results) -> Section:
    fine = shear_stress(SHAFT, results.paper.fine.end_torque.value) / 1e6
    return Section(
        "Stress, at the end and along the shaft",
        (
            "The abstract promises stress levels at the end of the shaft. Torque there is T₁, the stress "
            "T r_o/J. Along the shaft it takes only the wave that left the top: T(x, t) = T₀ + ½ [f(t − "
            "x/c) − f(t + x/c)].",
            Figure("stress_end"),
            Figure("stress_along"),
            f"Between {number(fine.min(), 2)} and {number(fine.max(), 2)} MPa: that range, not the mean, "
            "is what tires a joint, and the sign is what unscrews it. One has to step finely to see "
            "either.",
        ),
    )


def _others(results: Results) -> Section:
    rows = [(o.case, o.quantity, o.unit, o.expected, o.ours) for o in results.outcomes()]
    return Section(
        "Strings of others",
        (
            "Three systems from the literature, run by the same models: four inertias with friction that "
            "falls with speed (Navarro-López and Cortés, the paper's reference [3]); a shaft with delay, "
            "a neutral equation (Saldivar and others); the natural frequencies of pipe and collars. Each "
            "had been simulated once before, independently; that is “expected”.",
            Table("", ("case", "quantity", "unit", "expected", "ours"), rows),
            Figure("others"),
        ),
    )


def _errata() -> Section:
    return Section(
        "What the paper has wrong",
        (
            "So far as the copy that we have can be read. The derivations are in docs/theory.md.",
            Table("", ("where", "printed", "right"), ERRATA),
        ),
    )
