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
from vsensor.config import Rig, load
from vsensor.estimator import component
from vsensor.estimator.modes import torsional_modes
from vsensor.estimator.strength import hanging_weight, torsional_limit

MODES = 4
RPM = 30 / math.pi
PIPE_WIDTH = 120
"""Columns of text when nobody's window sets them."""


def check(
    config: Annotated[Path, typer.Argument(metavar="CONFIG", help="A configuration, as in config/.")],
) -> None:
    """Explain a configuration: each component's impedance and delay, the string's modes, what looks odd.

    Exit status 0 also where something looks odd, 2 where the configuration cannot be used.
    """
    rig = load(config)
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = PIPE_WIDTH
    console.print(f"{rig.rig.name} ({config}) is valid.", style="bold")
    _print_table(console, "The string, from the top drive down", _components(rig))
    _print_table(console, "Altogether", _totals(rig))
    _print_table(
        console, "What each component bears in torsion, at its top, the string hanging in air", _limits(rig)
    )
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
    for part in rig.string:
        table.add_row(
            Text(part.name),
            f"{part.length:.2f}",
            f"{part.outer_diameter * 1e3:.1f}",
            f"{part.inner_diameter * 1e3:.1f}",
            f"{component.impedance(part):.2f}",
            f"{component.delay(part) * 1e3:.2f}",
            f"{component.inertia(part):.1f}",
            f"{part.coulomb_friction * part.length:.0f}",
        )
    return table


def _limits(rig: Rig) -> Table:
    tops = np.cumsum([0.0, *(part.length for part in rig.string)])[:-1]
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("component")
    for head in ("tension\nkN", "limit\nkN·m"):
        table.add_column(head, justify="right")
    table.add_column("set by")
    for part, tension in zip(rig.string, hanging_weight(rig.string, tops).tolist(), strict=True):
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


def _answers(rig: Rig) -> Table:
    from vsensor.estimator.estimator import Estimator

    sensor = Estimator(rig)
    step_ms = 1e3 / rig.loop.rate / sensor.steps_per_tick
    table = _pairs()
    table.add_row("first answer", f"{sensor.warm_up:.2f} s after the first samples")
    table.add_row("confirmed", f"{sensor.confirmed_delay:.3f} s late")
    table.add_row("  its noise", f"{sensor.speed_noise * RPM:.1f} rpm, {sensor.torque_noise:.0f} N·m (one σ)")
    table.add_row("forecast", f"{sensor.forecast_horizon:.3f} s ahead")
    table.add_row("band", f"{rig.estimator.bandwidth:g} Hz")
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
