"""`vsensor run`: the daemon."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vsensor.cli.log import Form, logging
from vsensor.config import Rig, effective_toml, load

if TYPE_CHECKING:
    from structlog.typing import FilteringBoundLogger

    from vsensor.cli.teller import Trouble
    from vsensor.messages import Status
    from vsensor.metrics.exporter import Exporter
    from vsensor.recording.recorder import Recorder
    from vsensor.service.engine import Engine
    from vsensor.service.keeper import Keeper
    from vsensor.service.realtime import Achieved

FINISH_S = 30.0
"""How long the recorder may take to complete the file."""


def run(
    config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")],
    stand_by: Annotated[
        bool, typer.Option("--stand-by", help="Say nothing while another sensor of this rig does.")
    ] = False,
    log: Annotated[
        Form, typer.Option(help="How lines are written; auto: text on a terminal, else logfmt.")
    ] = Form.AUTO,
) -> None:
    """Run the virtual sensor beside a rig's telemetry until Ctrl-C or SIGTERM; SIGHUP reads CONFIG again."""
    from vsensor.bus import open_session
    from vsensor.cli.teller import Teller
    from vsensor.service.daemon import Daemon
    from vsensor.service.engine import Engine
    from vsensor.service.pace import MonotonicClock, Pace
    from vsensor.service.realtime import achieve, settle
    from vsensor.service.reload import Reload
    from vsensor.service.systemd import Supervisor
    from vsensor.signals import at_hangup, until_signalled

    rig = load(config)
    supervisor = Supervisor()
    reload = Reload(config)
    with (
        until_signalled() as stopped,
        at_hangup(reload.begin),
        logging(log, rig=rig.rig.name) as say,
    ):
        engine = Engine(rig)
        with ExitStack() as last:
            session = last.enter_context(open_session(rig.bus, "daemon"))
            exporter = last.enter_context(_exporter(rig, say))
            keeper = last.enter_context(_kept(rig, engine, say))
            settle()
            achieved = achieve(rig.loop)
            recorder = last.enter_context(_recorder(rig, achieved, say))
            daemon = Daemon(rig, engine, session, recorder, achieved, keeper, reload, stand_by=stand_by)
            _introduce(say, rig, engine.estimator.confirmed_delay, engine.estimator.forecast_horizon)
            _tell_achieved(say, achieved)
            teller = Teller(say, _troubles(recorder, keeper, exporter))
            supervisor.ready()
            say.info("READY")

            def tell_log(status: "Status") -> None:
                teller.tell(status, daemon.faults, daemon.voice.news())

            pace = Pace(rig.loop.rate, MonotonicClock(), daemon.prepare)
            ears = (supervisor.each_second, tell_log, *((exporter.tell,) if exporter is not None else ()))
            daemon.run(pace, ears, stopped)
            supervisor.stopping()
        _account(say, daemon.health.status)


def _troubles(
    recorder: "Recorder", keeper: "Keeper | None", exporter: "Exporter | None"
) -> "Iterable[Trouble]":
    from vsensor.cli.teller import Trouble

    yield Trouble("no longer recorded", "nothing keeps from recording any longer", recorder.trouble)
    if keeper is not None:
        ends = "what is learned is saved again"
        yield Trouble("what is learned is not saved", ends, lambda: keeper.trouble)
    if exporter is not None:
        yield Trouble("no metrics are served", "metrics are served again", lambda: exporter.trouble)


@contextmanager
def _exporter(rig: Rig, say: "FilteringBoundLogger") -> "Iterator[Exporter | None]":
    if not rig.metrics.enabled:
        yield None
        return
    from vsensor.metrics.exporter import Exporter

    with Exporter(rig.metrics) as exporter:
        say.info("metrics", at=f"http://{rig.metrics.host}:{rig.metrics.port}/metrics")
        yield exporter


@contextmanager
def _recorder(rig: Rig, achieved: "Achieved", say: "FilteringBoundLogger") -> "Iterator[Recorder]":
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
            say.info("recorded", path=path)
        if not completed:
            say.error("not complete", why=recorder.trouble())


@contextmanager
def _kept(rig: Rig, engine: "Engine", say: "FilteringBoundLogger") -> "Iterator[Keeper | None]":
    """What was learned before, taken up; and what will be, kept."""
    from vsensor.service.keeper import Keeper, path_of

    if not rig.state.enabled:
        yield None
        return
    keeper = Keeper(path_of(rig), rig, engine)
    if (begun := keeper.begun).words:
        (say.warning if begun.refused else say.info)("learned before", what=begun.words)
    try:
        yield keeper
    finally:
        keeper.close()
        if keeper.trouble:
            say.error("what was learned is lost", why=keeper.trouble)


def _introduce(say: "FilteringBoundLogger", rig: Rig, delay: float, horizon: float) -> None:
    say.info("listening", at=",".join(rig.bus.listen), to=f"{rig.prefix}/surface/*", rate_hz=rig.loop.rate)
    say.info("the bit", confirmed_late_s=round(delay, 2), foretold_ahead_s=round(horizon, 2))


def _tell_achieved(say: "FilteringBoundLogger", achieved: "Achieved") -> None:
    if achieved.asked != "off":
        say.info("real time", granted=achieved.words)
    for refused in achieved.refused:
        say.warning("not granted", what=refused)


def _account(say: "FilteringBoundLogger", status: "Status") -> None:
    from vsensor.messages.books import refused

    say.info(
        "ended",
        slots_run=status.slots_run,
        slots_due=status.slots_due,
        ticks=status.ticks,
        published=status.published,
        not_recorded=status.recorder_dropped,
    )
    for channel in status.channels:
        say.info(
            f"{channel.channel} in all",
            received=channel.received,
            accepted=channel.accepted,
            refused=refused(channel),
            lost=channel.lost,
        )
