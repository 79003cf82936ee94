"""e^x against as many digits as one likes."""

import math
from decimal import Context, Decimal

from hypothesis import example, given
from hypothesis import strategies as st

from vsensor.estimator.exponential import LEAST, exponential

EXACT = Context(prec=40)


@given(st.floats(LEAST, 0.0))
@example(0.0)
@example(-0.0)
@example(-5e-324)
@example(LEAST)
def test_it_is_within_one_place_of_the_last(x: float) -> None:
    told = exponential(x)
    assert abs(Decimal(told) - EXACT.exp(Decimal(x))) <= Decimal(math.ulp(told))


@given(st.floats(max_value=LEAST, exclude_max=True))
def test_what_is_too_small_is_nothing(x: float) -> None:
    assert exponential(x) == 0.0
