"""`vsensor verify`: a session's inputs run again must give its estimates, bit for bit."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from vsensor.config import loads
from vsensor.errors import InputError

if TYPE_CHECKING:
    from vsensor.recording.verify import Gap, Verdict


def verify(session: Annotated[Path, typer.Argument(help="A recorded session.")]) -> None:
    """Run the recorded inputs again under the recorded configuration and compare every estimate."""
    from vsensor.recording.reader import Session
    from vsensor.recording.verify import verify as compare
    from vsensor.service.engine import Engine

    recorded = Session(session)
    if recorded.configuration is None:
        raise InputError(f"{session}: holds no configuration, so that it cannot be run again")
    rig = loads(recorded.configuration, f"{session}: recorded configuration")
    console = Console()
    with console.status(f"verifying {session}"):
        verdict = compare(recorded, Engine(rig))
    if not recorded.complete:
        console.print(f"{session} is torn: what survives of it is verified", highlight=False, soft_wrap=True)
    console.print(_words(verdict), highlight=False)
    if not verdict.exact:
        raise typer.Exit(1)


def _words(verdict: "Verdict") -> str:
    if verdict.exact:
        return f"exact: {verdict.compared} estimates came out bit for bit"
    said = [f"{verdict.compared} estimates compared, {verdict.mismatches} differ"]
    if (first := verdict.first) is not None:
        said.append(
            f"the first at tick {first.number}: {first.field} was recorded as {first.recorded}, "
            f"is now {first.recomputed}"
        )
    said += [_hole(gap) for gap in verdict.gaps]
    if verdict.skipped:
        said.append(f"{verdict.skipped} ticks behind that could not be run again")
    if verdict.misfit:
        said.append(f"a recorded state was not taken up: {verdict.misfit}")
    if verdict.compared == 0:
        said.append("the session holds no estimates of a daemon: nothing to compare")
    return "\n".join(said)


def _hole(gap: "Gap") -> str:
    if gap.expected is None:
        return f"it begins with tick {gap.found}, and without what the sensor remembered then"
    return f"after tick {gap.expected - 1} the next recorded is {gap.found}"
