"""Strings for tests: strategies that draw them, and one that is worked by hand."""

from hypothesis import strategies as st

from vsensor.config import Component, Rig


def components(*, friction: bool = True) -> st.SearchStrategy[Component]:
    """Pipe as it is sold, and a little beyond."""
    share = st.floats(0.2, 0.9)
    rub = st.floats(0.0, 5.0) if friction else st.just(0.0)
    return st.builds(
        lambda length, outer, inner, viscous, kinetic, more: Component(
            length=length,
            outer_diameter=outer,
            inner_diameter=outer * inner,
            viscous_friction=viscous / 100,
            coulomb_friction=kinetic,
            static_friction=kinetic * more,
        ),
        length=st.floats(3.0, 900.0),
        outer=st.floats(0.08, 0.25),
        inner=share,
        viscous=rub,
        kinetic=rub,
        more=st.floats(1.0, 2.0),
    )


def strings(*, friction: bool = True, most: int = 6) -> st.SearchStrategy[tuple[Component, ...]]:
    """One to `most` components."""
    return st.lists(components(friction=friction), min_size=1, max_size=most).map(tuple)


def rig(*string: Component, rate: float = 100.0, **tables: object) -> Rig:
    """A rig of this string, all else by default."""
    given = {"rig": {"name": "test"}, "loop": {"rate": rate}, **tables}
    return Rig.model_validate({"string": [part.model_dump() for part in string], **given})


PIPE = Component(name="pipe", length=1500, outer_diameter=0.127, inner_diameter=0.1086, viscous_friction=0.02)
COLLAR = Component(name="collar", length=150, outer_diameter=0.1652, inner_diameter=0.0714)

# A bit and a top drive that stick-slip together on a long pipe.
BIT = {
    "inertia": 50.0,
    "viscous_friction": 5.0,
    "kinetic_torque": 3e3,
    "static_torque": 8e3,
    "stribeck_speed": 1.5,
}
DRIVE = {"inertia": 2000.0, "torque_lag": 0.005}
