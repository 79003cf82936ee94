"""The paper's figures, and ours beside them, by their numbers."""

from vsensor.paper.figures.comparison import fig09, fig10, fig_errors, fig_lengths
from vsensor.paper.figures.distributed import fig08, fig_fine
from vsensor.paper.figures.line import fig06
from vsensor.paper.figures.lumped import fig02, fig04, fig05
from vsensor.paper.figures.others import fig_others
from vsensor.paper.figures.stress import fig_stress_along, fig_stress_end

ALL = (
    fig02,
    fig04,
    fig05,
    fig06,
    fig08,
    fig_fine,
    fig09,
    fig10,
    fig_lengths,
    fig_errors,
    fig_stress_end,
    fig_stress_along,
    fig_others,
)
"""In the order of the story; each draws a `Picture` from `Results`."""
