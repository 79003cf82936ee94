"""`vsensor verify`: a session's inputs run again must give its estimates, bit for bit."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from vsensor.cli.overrides import changed, overridden
from vsensor.cli.reading import reading
from vsensor.cli.wide import wide_console
from vsensor.config import Rig, load, loads
from vsensor.errors import ConfigError, VsensorError

if TYPE_CHECKING:
    from vsensor.recording.compare import Change, Comparison
    from vsensor.recording.reader import Session
    from vsensor.recording.verify import Gap, Verdict


def verify(
    sessions: Annotated[list[Path], typer.Argument(metavar="SESSION...", help="Recorded sessions.")],
    config: Annotated[
        Path | None, typer.Option(help="Run under this rig instead of the recorded one.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help='Change a value, such as bit.inertia="60 kg*m^2".'),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("-o", "--output", help="Draw what changed: a .png, of one session.")
    ] = None,
) -> None:
    """Run the recorded inputs again and compare every estimate; under another rig, tell what changes."""
    if picture is not None and len(sessions) > 1:
        raise ConfigError(f"{picture}: a picture is of one session, not of {len(sessions)}")
    if picture is not None and picture.suffix != ".png":
        raise ConfigError(f"{picture}: a picture's name must end in .png")
    if picture is not None and not picture.parent.is_dir():
        raise ConfigError(f"{picture}: there is no folder {picture.parent}")
    console = wide_console(soft_wrap=True, highlight=False, markup=False)
    if config:
        load(config)  # its faults are told once, not with each session
    verdicts, refused = [], 0
    for session in sessions:
        try:
            verdicts.append(_verify(console, session, config, settings or [], picture))
        except VsensorError as error:
            if len(sessions) == 1:
                raise
            refused += 1
            typer.echo(f"error: {error}", err=True)
    as_recorded = config is None and not settings
    sound = all(verdict.exact or verdict.idle for verdict in verdicts) and any(v.exact for v in verdicts)
    if refused or (as_recorded and not sound):
        raise typer.Exit(1)


def _verify(
    console: Console, path: Path, config: Path | None, settings: list[str], picture: Path | None
) -> "Verdict":
    """Verify one session and say what came of it."""
    from vsensor.recording.compare import Comparison
    from vsensor.recording.reader import Session
    from vsensor.recording.verify import verify as compare
    from vsensor.service.otherwise import Otherwise

    session = Session(path)
    recorded = _recorded(session)
    rig = overridden(load(config) if config else recorded, settings, f"{config or path} with --set")
    differs = changed(recorded, rig)
    if rig.loop.rate != recorded.loop.rate:
        raise ConfigError(
            f"{path}: its ticks were made at {recorded.loop.rate:g} Hz and can be run at no other rate: "
            "vsensor estimate makes new ones of its samples"
        )
    with reading(path, "verifying", console):
        ticks = sum(topic.messages for topic in session.summary().topics if topic.topic == "sensor/tick")
        comparison = Comparison(ticks)
        verdict = compare(session, Otherwise(rig, recorded), strict=not differs, see=comparison.see)
        comparison.finish()
    if shortfall := session.shortfall():
        console.print(f"{path} {shortfall}; what is left of it is verified")
    console.print(f"{path}: {_words(verdict, as_recorded=not differs)}")
    if differs:
        console.print("under", "\n      ".join(differs))
    if verdict.mismatches:
        console.print(_table(comparison))
        console.print(f"the quality of {comparison.qualities} ticks is another")
    if picture is not None:
        _draw(picture, path, differs, comparison.changes)
        console.print(f"drawn in {picture}")
    return verdict


def _recorded(session: "Session") -> Rig:
    if session.configuration is None:
        raise session.lacks("holds no configuration, so that it cannot be run again")
    return loads(session.configuration, f"{session.path}: recorded configuration")


def _words(verdict: "Verdict", *, as_recorded: bool) -> str:
    if verdict.exact:
        return f"exact: {verdict.compared} estimates came out bit for bit"
    said = [f"{verdict.compared} estimates compared, {verdict.mismatches} differ"]
    if as_recorded and (first := verdict.first) is not None:
        said.append(
            f"the first at tick {first.number}: {first.field} was recorded as {first.recorded}, "
            f"is now {first.recomputed}"
        )
    if as_recorded:
        said += [_hole(gap) for gap in verdict.gaps]
    if verdict.skipped:
        said.append(f"{verdict.skipped} ticks behind that could not be run again")
    if verdict.misfit:
        said.append(f"a recorded state was not taken up: {verdict.misfit}")
    if verdict.compared == 0 and not verdict.skipped:
        said.append("the session holds no estimates of a daemon: nothing to compare")
    return "\n".join(said)


def _hole(gap: "Gap") -> str:
    if gap.expected is None:
        return f"it begins with tick {gap.found}, and without what the sensor remembered then"
    return f"after tick {gap.expected - 1} the next recorded is {gap.found}"


def _table(comparison: "Comparison") -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("changed", "rms", "at most", "at, s", "from, s", "stated ±", "now ±", ""):
        table.add_column(heading, justify="left" if heading in ("changed", "") else "right", no_wrap=True)
    for change in comparison.changes:
        table.add_row(f"{change.quantity.kind} {change.quantity.name}", *_figures(change))
    return table


def _figures(change: "Change") -> list[str]:
    if not change.compared:
        return ["—"]
    stated = [f"{std / change.compared:.4g}" for std in (change.std_recorded, change.std_now)]
    if not change.largest:
        return ["0", "", "", "", *stated, change.quantity.unit]
    return [
        f"{change.rms:.3g}",
        f"{change.largest:+.3g}",
        f"{change.largest_at_s:.2f}",
        f"{change.first_at_s:.2f}",
        *stated,
        change.quantity.unit,
    ]


def _draw(picture: Path, session: Path, differs: list[str], changes: "list[Change]") -> None:
    try:
        from vsensor.recording.picture import draw
    except ImportError as error:
        raise ConfigError('a picture needs matplotlib: pip install "vsensor[paper]"') from error
    title = f"{session.name} run again" + (f" under {', '.join(differs)}" if differs else "")
    draw(picture, title, changes)
