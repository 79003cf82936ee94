"""Configurations that are wrong on purpose, as those of a real rig are without anyone knowing."""

from collections.abc import Mapping

from vsensor.config import Component, Rig

MODULUS, WALL, INERTIA, FRICTION = 0.97, 1.05, 1.1, 0.7
LAW_UP, LAW_DOWN = 1.5, 0.5


def wrong_modulus(rig: Rig, factor: float = MODULUS) -> Rig:
    """Shear modulus of every component times `factor`: travel time and impedance turn wrong."""
    return _each_component(rig, "shear_modulus", factor=factor)


def wrong_wall(rig: Rig, factor: float = WALL) -> Rig:
    """Every component's wall times `factor`, by its bore, as if worn ones were new: impedance turns wrong."""

    def thicker(part: Component) -> Component:
        bore = part.outer_diameter - factor * (part.outer_diameter - part.inner_diameter)
        return part.model_copy(update={"inner_diameter": max(0.0, bore)})

    return rig.model_copy(update={"string": tuple(thicker(part) for part in rig.string)})


def wrong_inertia(rig: Rig, factor: float = INERTIA) -> Rig:
    """The top drive's inertia times `factor`."""
    drive = rig.top_drive.model_copy(update={"inertia": rig.top_drive.inertia * factor})
    return rig.model_copy(update={"top_drive": drive})


def wrong_friction(rig: Rig, factor: float = FRICTION) -> Rig:
    """Wall friction of every component, viscous and Coulomb (kinetic and static), times `factor`."""
    return _each_component(rig, "viscous_friction", "coulomb_friction", "static_friction", factor=factor)


def wrong_string(rig: Rig, delay: float, impedance: float) -> Rig:
    """Every component's delay and impedance times such factors: θ goes with √(ρ/G), ζ with √(ρG)."""
    stiffer = _each_component(rig, "shear_modulus", factor=impedance / delay)
    return _each_component(stiffer, "density", factor=impedance * delay)


def wrong_law(rig: Rig, factor: float) -> Rig:
    """The first guess of the load law, viscous, kinetic and static, times `factor`."""
    names = ("viscous_friction", "kinetic_torque", "static_torque")
    bit = rig.bit.model_copy(update={name: getattr(rig.bit, name) * factor for name in names})
    return rig.model_copy(update={"bit": bit})


def rough_law(rig: Rig) -> Rig:
    """A law as one puts it in who knows nothing of the rock: 1 kN·m, whatever the speed."""
    guess = {"viscous_friction": 0.0, "kinetic_torque": 1e3, "static_torque": 1e3, "stribeck_speed": 1.0}
    return rig.model_copy(update={"bit": rig.bit.model_copy(update=guess)})


def wrongs(rig: Rig) -> Mapping[str, Rig]:
    """Each wrong alone, and all together but for the wall, by name; the right one first."""
    hardware = wrong_friction(wrong_inertia(wrong_modulus(rig)))
    return {
        "nothing": rig,
        "G −3 %": wrong_modulus(rig),
        "wall +5 %": wrong_wall(rig),
        "inertia +10 %": wrong_inertia(rig),
        "friction −30 %": wrong_friction(rig),
        "load law +50 %": wrong_law(rig, LAW_UP),
        "load law −50 %": wrong_law(rig, LAW_DOWN),
        "all, load law +50 %": wrong_law(hardware, LAW_UP),
        "all, load law −50 %": wrong_law(hardware, LAW_DOWN),
    }


def _each_component(rig: Rig, *names: str, factor: float) -> Rig:
    def scaled(part: Component) -> Component:
        return part.model_copy(update={name: getattr(part, name) * factor for name in names})

    return rig.model_copy(update={"string": tuple(scaled(part) for part in rig.string)})
