"""What is wrong in the paper, so far as the copy that we have can be read; derived in docs/theory.md."""

from typing import NamedTuple


class Erratum(NamedTuple):
    """One of them."""

    where: str
    printed: str
    right: str


ERRATA = (
    Erratum("(1), second line", "C_r(φ̇_r − φ̇_b); J_b φ̇_b", "c(φ̇_r − φ̇_b); J_b φ̈_b"),
    Erratum("(2)", "T_m below the bar", "T_m times the fraction"),
    Erratum("(12), below", "ξ = √(L/C)", "ξ = √((Ls + R)/(Cs + G)); the printed one where nothing is lost"),
    Erratum(
        "before (14)",
        "∂ω/∂x = −L ∂T/∂t, ∂T/∂x = −C ∂ω/∂t",
        "∂T/∂x = −L ∂ω/∂t, ∂ω/∂x = −C ∂T/∂t; L = ρJ, C = 1/(GJ)",
    ),
    Erratum("(14), (17)", "ω = ξ […] T", "T = ξ […] ω, as in its own (23)"),
    Erratum("(16)", "z⁻¹ = e^(−T_p/2)", "z⁻¹ = e^(−s T_p), T_p the round trip; z^(−½) is one way"),
    Erratum("(20)", "1/J_L", "1/(J_L s + D_L)"),
    Erratum("below (21)", "ω₁/T₁ = D_L z/(z − α)", "ω₁/T₁ = β z/(z − α), so that the steady gain is 1/D_L"),
    Erratum("(22)", "X_L = (1 + α + w(1 − α))/D_L", "X_L = (1 + α + w(1 − α))/(β(w + 1))"),
    Erratum(
        "(24), (25)",
        "numerators not divided by what the denominators are; a ξ too many in (25)",
        "over ζ(1 + ζβ); 2β/(1 + ζβ)",
    ),
    Erratum("after (25)", "T_p = 2.536 s", "T_p = 2.5376 s"),
    Erratum("after (25)", "J_L = J_r + J_b = 2500", "1570: ρJL = 930 is the line's own, and counted twice"),
    Erratum(
        "end of IV",
        "less oscillation than the lumped model",
        "that is the stepping; the equations swing hard",
    ),
    Erratum("V", "accuracy falls as the string grows", "only where the step is tied to the round trip"),
)
