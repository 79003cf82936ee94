"""`vsensor check`: what a configuration means for waves in the string."""

import math
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from vsensor.cli.oddities import oddities, wall_torque
from vsensor.cli.wide import wide_console
from vsensor.config import Rig, load
from vsensor.config.well import Wellbore
from vsensor.estimator import component
from vsensor.estimator.modes import torsional_modes
from vsensor.estimator.strength import torsional_limit
from vsensor.estimator.tension import greatest_tension
from vsensor.estimator.wall import contact, wall_friction
from vsensor.estimator.wellpath import direction, vertical_depth, well_path

MODES = 4
RPM = 30 / math.pi
DOGLEG = math.degrees(30.0)
"""Degrees in 30 m, the driller's measure of curvature, in one rad/m."""


def check(
    config: Annotated[Path, typer.Argument(metavar="CONFIG", help="A configuration, as in config/.")],
) -> None:
    """Explain a configuration: each component's impedance and delay, the string's modes, what looks odd.

    Exit status 0 also where something looks odd, 2 where the configuration cannot be used.
    """
    rig = load(config)
    console = wide_console(highlight=False, markup=False)
    console.print(f"{rig.rig.name} ({config}) is valid.", style="bold")
    _print_table(console, "The string, from the top drive down", _components(rig))
    _print_table(console, "Altogether", _totals(rig))
    if rig.wellbore:
        _print_table(console, "The well, and the string in it while it turns", _well(rig, rig.wellbore))
    hanging = "at the most" if rig.wellbore else "the string hanging in air"
    _print_table(console, f"What each component bears in torsion, at its top, {hanging}", _limits(rig))
    with console.status("compiling the kernels, once"):
        told = _answers(rig)
    _print_table(console, "What the sensor will tell of the bit", told)
    _print_table(console, "Lowest torsional modes, the top held as by a stiff top drive", _modes(rig))
    _print_oddities(console, oddities(rig))


def _print_table(console: Console, title: str, table: Table) -> None:
    console.print(f"\n{title}", style="bold")
    console.print(table)


def _components(rig: Rig) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("component")
    for head in ("length\nm", "OD\nmm", "ID\nmm", "impedance ζ\nN·m·s/rad", "delay\nms", "inertia\nkg·m²"):
        table.add_column(head, justify="right")
    table.add_column("wall friction\nN·m", justify="right")
    walls = wall_friction(rig.string, rig.survey, rig.wellbore).kinetic
    for part, wall in zip(rig.string, walls, strict=True):
        table.add_row(
            Text(part.name),
            f"{part.length:.2f}",
            f"{part.outer_diameter * 1e3:.1f}",
            f"{part.inner_diameter * 1e3:.1f}",
            f"{component.impedance(part):.2f}",
            f"{component.delay(part) * 1e3:.2f}",
            f"{component.inertia(part):.1f}",
            f"{wall:.0f}",
        )
    return table


def _limits(rig: Rig) -> Table:
    tops = np.cumsum([0.0, *(part.length for part in rig.string)])[:-1]
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("component")
    for head in ("tension\nkN", "limit\nkN·m"):
        table.add_column(head, justify="right")
    table.add_column("set by")
    tensions = greatest_tension(rig.string, tops, rig.survey, rig.wellbore).tolist()
    for part, tension in zip(rig.string, tensions, strict=True):
        limit = torsional_limit(part, tension)
        told = (f"{limit.torque / 1e3:.1f}", limit.by) if limit else ("-", "no strength is configured")
        table.add_row(Text(part.name), f"{tension / 1e3:.0f}", *told)
    return table


def _totals(rig: Rig) -> Table:
    delay = sum(component.delay(part) for part in rig.string)
    compliance = sum(1 / component.stiffness(part) for part in rig.string)
    table = _pairs()
    table.add_row("length", f"{sum(part.length for part in rig.string):.2f} m")
    table.add_row("a wave's way down", f"{delay:.4f} s")
    table.add_row("and back up", f"{2 * delay:.4f} s")
    table.add_row("inertia of the string", f"{sum(component.inertia(part) for part in rig.string):.1f} kg·m²")
    table.add_row("static stiffness", f"{1 / compliance:.1f} N·m/rad")
    table.add_row("wind-up", f"{1e3 * compliance / (2 * math.pi):.3f} turns per kN·m")
    table.add_row("wall friction", f"{wall_torque(rig) / 1e3:.2f} kN·m while turning")
    return table


def _well(rig: Rig, wellbore: Wellbore) -> Table:
    path = well_path(rig.survey)
    bit = np.array([sum(part.length for part in rig.string)])
    ((north, east, down),), _ = direction(path, bit)
    lies = contact(rig.string, path, wellbore)
    bent = int(np.argmax(path.curvature))
    pressed = int(np.argmax(lies.side_force))
    table = _pairs()
    table.add_row("bit", f"{vertical_depth(path, bit)[0]:.1f} m below surface")
    table.add_row("inclination at the bit", f"{math.degrees(math.atan2(math.hypot(north, east), down)):.1f}°")
    table.add_row(
        "sharpest dogleg", f"{path.curvature[bent] * DOGLEG:.2f}° in 30 m, below {path.depth[bent]:.0f} m"
    )
    table.add_row(
        "greatest side force",
        f"{lies.side_force[pressed] / 1e3:.2f} kN/m, at {lies.depth[pressed]:.0f} m",
    )
    return table


def _answers(rig: Rig) -> Table:
    from vsensor.estimator.estimator import Estimator

    sensor = Estimator(rig)
    step_ms = 1e3 / rig.loop.rate / sensor.steps_per_tick
    table = _pairs()
    table.add_row("first answer", f"{sensor.warm_up:.2f} s after the first samples")
    table.add_row("confirmed", f"{sensor.confirmed_delay:.3f} s late")
    speed, torque = sensor.noise.tolist()
    table.add_row("  its noise", f"{speed * RPM:.1f} rpm, {torque:.0f} N·m (one σ, in middling rock)")
    table.add_row("forecast", f"{sensor.forecast_horizon:.3f} s ahead")
    table.add_row("band", f"up to {sensor.bandwidth:.1f} Hz the rock is told more than guessed")
    table.add_row("grid", f"{len(sensor.line.impedance)} sections, steps of {step_ms:g} ms")
    return table


def _modes(rig: Rig) -> Table:
    table = _pairs()
    for number, frequency in enumerate(torsional_modes(rig.string, rig.bit.inertia, MODES), 1):
        table.add_row(f"mode {number}", f"{frequency:.4f} Hz, period {1 / frequency:.2f} s")
    return table


def _pairs() -> Table:
    table = Table(box=None, show_header=False, padding=(0, 2))
    table.add_column(no_wrap=True)
    return table


def _print_oddities(console: Console, odd: list[str]) -> None:
    if not odd:
        console.print("\nNothing looks odd.", style="green")
        return
    console.print(f"\nWhat looks odd ({len(odd)})", style="bold yellow")
    bullets = Table.grid(padding=(0, 1))
    for sentence in odd:
        bullets.add_row("  •", Text(sentence))
    console.print(bullets)
