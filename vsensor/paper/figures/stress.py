"""What the abstract promises: shear stress at the shaft's end and along it."""

import numpy as np

from vsensor.estimator import component
from vsensor.paper.comparison import WINDOW
from vsensor.paper.figures.style import EXACT, FINE, GREY, LUMPED, PRINTED, Picture, panels
from vsensor.paper.results import Results
from vsensor.paper.shaft import TORQUE, Trace, shear_stress
from vsensor.paper.stress import torque_along, wave_between, wave_held

_MPA = 1e-6
_SHOWN = 16.0
_TIME = np.linspace(0, _SHOWN, 481)


def fig_stress_end(results: Results) -> Picture:
    """At the end, by each model."""
    of = results.paper
    figure, (axes,) = panels(height=4.8)

    def stress(trace: Trace) -> Trace:
        return Trace(trace.time, _MPA * shear_stress(of.shaft, trace.value))

    time = np.linspace(0, WINDOW, 6001)
    exact = stress(Trace(time, of.truth.end_torque(time)))
    axes.plot(*exact, **EXACT | {"linewidth": 3.4, "alpha": 0.25})
    fine = stress(of.fine.end_torque)
    axes.plot(*fine, **FINE | {"linewidth": 1.1})
    lumped = stress(of.lumped.end_torque)
    axes.plot(*lumped, **LUMPED)
    printed = stress(of.printed.end_torque)
    axes.step(*printed, **PRINTED)
    steady = _MPA * float(shear_stress(of.shaft, TORQUE))
    first = exact.value[exact.time < 2 * component.delay(of.shaft)].max()
    axes.axhline(steady, color=GREY, linewidth=0.9)
    axes.set(
        title="Shear stress at the end of the shaft, 4000 m",
        xlabel="time since the step of torque, s",
        ylabel="shear stress, MPa",
        xlim=(0, WINDOW),
        ylim=(-35, 95),
    )
    axes.annotate(
        "steady", (WINDOW, steady), xytext=(3, -3), textcoords="offset points", annotation_clip=False
    )
    axes.legend(loc="upper right", ncols=2)
    return Picture(
        "stress_end",
        figure,
        f"Shear stress T₁ r_o/J. A load that cannot turn at once doubles the first wave: {first:.1f} MPa, "
        f"where the motor's torque makes {steady:.1f} MPa in the mean; its echoes reach "
        f"{exact.value.max():.0f} MPa, and {-exact.value.min():.0f} MPa the other way, which would loosen "
        f"a joint. The paper's steps show {printed.value.max():.1f} MPa at most. The lumped spring shows "
        f"{lumped.value.max():.1f} MPa and settles at half the torque: it has half the drag at the top.",
        "Shear stress at the end over time: the fine model jumps between about −27 and 60 MPa, the other "
        "two stay below 26.",
    )


def fig_stress_along(results: Results) -> Picture:
    """Along the shaft over time, by each model."""
    of = results.paper
    depth = np.linspace(0, of.shaft.length, 161)
    maps = (
        ("lumped", np.tile(np.interp(_TIME, *of.lumped.end_torque), (len(depth), 1))),
        (
            "distributed, one step a round trip",
            torque_along(wave_held(of.printed, of.shaft, TORQUE), of.shaft, TORQUE, depth, _TIME),
        ),
        (
            "distributed, stepped finely",
            torque_along(wave_between(of.fine, of.shaft, TORQUE), of.shaft, TORQUE, depth, _TIME),
        ),
    )
    figure, axes = panels(3, height=7.6, sharex=True)
    largest = _MPA * float(shear_stress(of.shaft, maps[-1][1]).max())
    for panel, (words, torque) in zip(axes, maps, strict=True):
        image = panel.imshow(
            _MPA * shear_stress(of.shaft, torque),
            extent=(0, _SHOWN, of.shaft.length, 0),
            aspect="auto",
            cmap="RdBu_r",
            vmin=-largest,
            vmax=largest,
            interpolation="nearest",
        )
        panel.grid(visible=False)
        panel.set(title=f"Shear stress along the shaft   {words}", ylabel="depth, m")
    axes[-1].set_xlabel("time since the step of torque, s")
    figure.colorbar(image, ax=axes, label="shear stress, MPa", shrink=0.7)
    trip = 2 * component.delay(of.shaft)
    return Picture(
        "stress_along",
        figure,
        "Depth downward, time to the right. A spring (top) has one stress for the whole shaft. The "
        f"paper's model (middle) has waves, but all that its load does happens once in {trip:.2f} s. "
        "Stepped finely (bottom) the fronts can be followed down, and up again doubled.",
        "Three maps of shear stress over depth and time: uniform, in large triangles, and with sharp fronts.",
    )
