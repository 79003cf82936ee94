"""Fig. 6: the general line, and what its losses do."""

import numpy as np

from vsensor.paper import general_line
from vsensor.paper.figures.style import BLACK, BLUE, GREEN, RED, Picture, panels
from vsensor.paper.general_line import GeneralLine
from vsensor.paper.results import Results
from vsensor.paper.shaft import SHAFT

MUD_HOSE = general_line.hose(length=4000.0, bore=0.1, density=1200.0, sound_speed=1200.0, viscosity=0.05)
"""Drilling mud inside the pipe: u pressure, y flow."""

TELEPHONE_PAIR = general_line.cable(
    length=5000.0, inductance=0.61e-6, capacitance=51.6e-12, resistance=0.172, conductance=0.07e-9
)
"""A twisted pair of 0.5 mm wire, its usual values."""

ROUGH_SHAFT = SHAFT.model_copy(update={"viscous_friction": 0.05})
"""The paper's shaft, with drag of its wall all along."""


def fig06(_: Results) -> Picture:
    """How much of what goes in at one end arrives at the other, by frequency."""
    figure, (axes,) = panels(height=4.8)
    turns = np.linspace(0.01, 7.99, 1600)
    for line, words, style in (
        (general_line.shaft(SHAFT), "torque in the paper's shaft, $R = G = 0$", {"color": BLACK}),
        (
            general_line.shaft(ROUGH_SHAFT),
            "the same with drag on the wall, $R > 0$",
            {"color": RED, "linestyle": "--"},
        ),
        (MUD_HOSE, "pressure of mud in 4 km of pipe, $R > 0$", {"color": BLUE, "linestyle": "-."}),
        (TELEPHONE_PAIR, "voltage on 5 km of telephone pair, $R, G > 0$", {"color": GREEN, "linestyle": ":"}),
    ):
        axes.semilogy(turns, _gain(line, turns), linewidth=1.8, label=words, **style)
    axes.set(
        title="Fig. 6   The general line: gain to a closed far end",
        xlabel="frequency, in quarter waves on the line",
        ylabel="|u at the far end / u at the near end|",
        xlim=(0, 8),
        ylim=(0.03, 300),
    )
    figure.legend(loc="outside lower center", ncols=2)
    return Picture(
        "fig06_general_line",
        figure,
        "Eq. (12) for three media, the far end letting nothing through: a bit that is held, a closed "
        "valve, an open pair. Without losses every odd quarter wave resounds without bound. Drag takes "
        "that away; in the cable hardly anything of a wave is left.",
        "Gain over frequency on a logarithmic scale: sharp peaks for the lossless shaft, rounded ones for "
        "drag and mud, a steady fall for the cable.",
    )


def _gain(line: GeneralLine, quarter_waves: np.ndarray) -> np.ndarray:
    """|u₁/u₀| with y₁ = 0: 1/|cosh Γl|."""
    s = 1j * (np.pi / 2) * quarter_waves / line.delay
    return np.asarray(1 / np.abs(np.cosh(line.propagation(s))))
