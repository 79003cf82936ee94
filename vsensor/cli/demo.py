"""`vsensor demo`: a simulated rig, the daemon, a recording and the live view, all on this machine."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from vsensor.simulate.scenario import Scenario


def demo(
    config: Annotated[Path | None, typer.Argument(help="The rig; by default our example string.")] = None,
    headless: Annotated[bool, typer.Option("--headless", help="No view; ends with an account.")] = False,
    web: Annotated[bool, typer.Option("--web", help="The view in a browser.")] = False,
    duration: Annotated[float, typer.Option(help="Seconds; 0 goes on until Ctrl-C.", min=0)] = 0,
    scenario: Annotated[Scenario, typer.Option(help="What the driller does.")] = Scenario.STICK_SLIP,
) -> None:
    """Show the whole of it: the bit of a simulated rig, seen from the surface."""
    from vsensor import demo as stage
    from vsensor.config import load
    from vsensor.signals import until_signalled

    console = Console()
    rig = stage.on_free_port(load(config or stage.example("drilling.toml")))
    view = None if headless else stage.how_to_view(web=web, say=console.print)
    with tempfile.TemporaryDirectory(prefix="vsensor-demo-") as folder, until_signalled() as stopped:
        seconds = duration or (20 if headless else 0)
        played = stage.play(rig, Path(folder), str(scenario), view, seconds, console.print, stopped)
        console.print(stage.account(rig, played), highlight=False, soft_wrap=True)
