"""`vsensor simulate`: a rig that is not there, in real time."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from vsensor.config import load
from vsensor.errors import ConfigError
from vsensor.simulate.scenario import PLANS, Scenario

LONGEST_S = 1e9
"""Thirty years."""

TruthFile = Annotated[Path | None, typer.Option(help="Write what was true at the bit to this CSV file.")]


def simulate(
    config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")],
    scenario: Annotated[Scenario, typer.Option(help="What the driller does.")] = Scenario.STICK_SLIP,
    duration: Annotated[
        float, typer.Option(help="Seconds; 0 goes on until Ctrl-C.", min=0, max=LONGEST_S)
    ] = 0,
    seed: Annotated[int, typer.Option(help="Of noise and rock: the same seed, the same run.", min=0)] = 1,
    truth: TruthFile = None,
) -> None:
    """Publish surface torque and speed of a simulated rig, as a real one would."""
    from vsensor.bus import SURFACE_CACHE, Outbox, open_session, wait_for_sensor
    from vsensor.service.pace import MonotonicClock, Pace
    from vsensor.signals import until_signalled
    from vsensor.simulate.broadcast import broadcast
    from vsensor.simulate.rig import SimulatedRig

    if truth is not None and truth.suffix != ".csv":
        raise ConfigError(f"--truth {truth}: must end in .csv")
    console = Console()
    rig = load(config)
    with until_signalled() as stopped, open_session(rig.bus, "client") as session:
        if not wait_for_sensor(session, rig.prefix):
            console.print(f"nobody listens on {rig.prefix} yet; publishing all the same")
        # Another takes what kernels need at first: no real rig begins with a second's samples at once.
        SimulatedRig(rig, PLANS[scenario], seed).sample()
        console.print(f"rig {rig.rig.name}: {scenario} at {rig.loop.rate:g} Hz", highlight=False)
        done = broadcast(
            SimulatedRig(rig, PLANS[scenario], seed),
            Outbox(session, rig.prefix, reliable=True, cache=SURFACE_CACHE).put,
            (1 + slot.skipped for slot in Pace(rig.loop.rate, MonotonicClock()).slots()),
            samples=max(1, round(duration * rig.loop.rate)) if duration else 0,
            stopped=stopped,
            truth=truth,
        )
    console.print(f"{done} samples a channel published", highlight=False)
