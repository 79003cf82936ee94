"""`vsensor run`: the daemon."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from vsensor.config import Rig, effective_toml, load

if TYPE_CHECKING:
    from vsensor.messages import Status
    from vsensor.recording.recorder import Recorder
    from vsensor.service.engine import Engine
    from vsensor.service.keeper import Keeper
    from vsensor.service.realtime import Achieved

FINISH_S = 30.0
"""How long the recorder may take to complete the file."""


def run(config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")]) -> None:
    """Run the virtual sensor beside a rig's telemetry until Ctrl-C or SIGTERM."""
    from vsensor.bus import open_session
    from vsensor.service.daemon import Daemon
    from vsensor.service.engine import Engine
    from vsensor.service.pace import MonotonicClock, Pace
    from vsensor.service.realtime import achieve
    from vsensor.signals import until_signalled

    console = Console()
    rig = load(config)
    with until_signalled() as stopped:
        engine = Engine(rig)
        with ExitStack() as last:
            session = last.enter_context(open_session(rig.bus, "daemon"))
            keeper = last.enter_context(_kept(rig, engine, console))
            achieved = achieve(rig.loop)
            recorder = last.enter_context(_recorder(rig, achieved, console))
            daemon = Daemon(rig, engine, session, recorder, achieved, keeper)
            _introduce(console, rig, engine.estimator.confirmed_delay, engine.estimator.forecast_horizon)
            _tell_achieved(console, achieved)
            console.print("READY")
            teller = Teller(console, recorder)
            pace = Pace(rig.loop.rate, MonotonicClock())
            daemon.run(pace, lambda status: teller.tell(status, daemon.fault), stopped)
        _account(console, daemon.status)


@contextmanager
def _recorder(rig: Rig, achieved: "Achieved", console: Console) -> "Iterator[Recorder]":
    from vsensor.provenance import provenance
    from vsensor.recording.limits import Limits
    from vsensor.recording.names import session_path
    from vsensor.recording.recorder import Recorder

    settings = rig.recording
    recorder = Recorder(
        session_path(settings.folder, rig.rig.name),
        configuration=effective_toml(rig),
        metadata=provenance(rig) | achieved.as_metadata(),
        compression=settings.compression,
        limits=Limits(**{field.name: getattr(settings, field.name) for field in fields(Limits)}),
        begin=settings.enabled,
        processors=achieved.others,
    )
    try:
        yield recorder
    finally:
        completed = recorder.close(FINISH_S)
        for path in recorder.complete:
            console.print(f"recorded {escape(path)}", soft_wrap=True)
        if not completed:
            console.print(f"[red]not complete:[/] {escape(recorder.trouble())}", soft_wrap=True)


@contextmanager
def _kept(rig: Rig, engine: "Engine", console: Console) -> "Iterator[Keeper | None]":
    """What was learned before, taken up; and what will be, kept."""
    from vsensor.service.keeper import Keeper, path_of

    if not rig.state.enabled:
        yield None
        return
    keeper = Keeper(path_of(rig), rig, engine)
    if keeper.begun:
        console.print(escape(keeper.begun), soft_wrap=True, highlight=False)
    try:
        yield keeper
    finally:
        keeper.close()
        if keeper.trouble:
            console.print(f"[red]what was learned is lost:[/] {escape(keeper.trouble)}", soft_wrap=True)


def _introduce(console: Console, rig: Rig, delay: float, horizon: float) -> None:
    console.print(
        f"rig [bold]{rig.rig.name}[/]: {rig.loop.rate:g} Hz, samples awaited on {rig.prefix}/surface/… "
        f"at {', '.join(rig.bus.listen)}\n"
        f"the bit is confirmed {delay:.2f} s late, told for now, and foretold {horizon:.2f} s ahead",
        soft_wrap=True,
        highlight=False,
    )


def _tell_achieved(console: Console, achieved: "Achieved") -> None:
    if achieved.asked != "off":
        console.print(escape(achieved.words), soft_wrap=True, highlight=False)
    for refused in achieved.refused:
        console.print(f"[yellow]not granted:[/] {escape(refused)}", soft_wrap=True, highlight=False)


class Teller:
    """Says each change of state once, rather than each second the same."""

    def __init__(self, console: Console, recorder: "Recorder") -> None:
        self._console = console
        self._recorder = recorder
        self._state = ""
        self._path = ""
        self._trouble = ""
        self._fault = ""
        self._dropped = 0

    def tell(self, status: "Status", fault: str) -> None:
        """Hear the status of this second, and what was wrong with the last unreadable sample."""
        if fault != self._fault:
            self._fault = fault
            self._console.print(f"[red]refused:[/] {escape(fault)}", soft_wrap=True, highlight=False)
        if status.state != self._state:
            self._state = status.state
            self._console.print(f"{time.strftime('%H:%M:%S')} {status.state}", highlight=False)
        self._tell_of_recorder()
        if status.recorder_dropped > self._dropped and not self._trouble:
            self._dropped = status.recorder_dropped
            self._console.print(f"[red]not recorded:[/] {self._dropped} messages so far", highlight=False)

    def _tell_of_recorder(self) -> None:
        if (trouble := self._recorder.trouble()) != self._trouble:
            self._trouble = trouble
            if trouble:
                self._console.print(f"[red]no longer recorded:[/] {escape(trouble)}", soft_wrap=True)
        if (path := self._recorder.path) != self._path:
            self._path = path
            if path:
                self._console.print(f"recording into {escape(path)}", soft_wrap=True, highlight=False)
            elif not trouble:
                self._console.print("recording has ended", highlight=False)


def _account(console: Console, status: "Status") -> None:
    from vsensor.messages.books import refused

    console.print(
        f"{status.slots_run} of {status.slots_due} slots run, {status.ticks} ticks, "
        f"{status.published} estimates published, {status.recorder_dropped} messages not recorded",
        highlight=False,
        soft_wrap=True,
    )
    for channel in status.channels:
        console.print(
            f"{channel.channel}: {channel.received} received, {channel.accepted} accepted, "
            f"{refused(channel)} refused, {channel.lost} lost on the way",
            highlight=False,
            soft_wrap=True,
        )
