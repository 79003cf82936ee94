"""A session's report put together: read twice, told in words, drawn."""

from pathlib import Path

from vsensor.config import loads
from vsensor.errors import InputError, VsensorError
from vsensor.recording.reader import Session
from vsensor.recording.summary import Summary
from vsensor.report import plots, words
from vsensor.report.again import read_again
from vsensor.report.foretold import counted
from vsensor.report.gather import Story, gather
from vsensor.report.page import folded, page, pair, place, section, table
from vsensor.report.seconds import Severity

WINDOW_S = 20.0
"""Of the severity, where the session's configuration does not tell."""


def report(session: Session) -> str:
    """The report as HTML. Raises InputError where the session holds no estimates."""
    story, summary = gather(session), session.summary()
    severity, worst = story.seconds.severity(_window(session)), story.seconds.worst()
    sticks, again = story.stands.told(), read_again(session, story, worst)
    of_late = counted([story.status] if story.status else [])
    drawn = {
        "over-time": plots.over_time(story, severity, worst),
        "closely": plots.closely(again.closely, worst),
        "portrait": plots.portrait(again.portrait, _law(story)),
        "by-horizon": plots.by_horizon(story.foretold.skill(), story.counted.skill(), of_late),
    }
    if story.along is not None:
        drawn["along"] = plots.along(story.along)
    if again.lateness is not None:
        drawn["lateness"] = plots.lateness(again.lateness)
    about = (
        f"{summary.rig or 'a rig without a name'} · {words.began(summary.first_ns)} · "
        f"{words.lasted(summary.duration_s)} · {session.path.name}"
    )
    shortfall = session.shortfall()
    said = (
        words.headline(story, severity, sticks),
        words.strained(story.along),
        f"The session {shortfall}." if shortfall else "",
    )
    parts = _parts(session, story, summary, severity, (worst[1] - worst[0]) / 1e9, set(drawn))
    return page(
        f"Report: {session.path.name}",
        about,
        said,
        words.keys(story, summary, severity, sticks),
        parts,
        drawn,
    )


def write(path: Path, html: str) -> None:
    """Write a page; InputError where it cannot be."""
    try:
        path.write_text(html, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


def _parts(
    session: Session, story: Story, summary: Summary, severity: Severity, minute_s: float, drawn: set[str]
) -> str:
    late = place("lateness") if "lateness" in drawn else _note("No loop ran: made offline.")
    return "".join(
        (
            _over_time(severity, minute_s),
            _string_and_rock(story, drawn),
            _foretold(),
            pair(
                section("Losses", "Everything that was counted as lost.", table(_losses(story, summary))),
                section("The loop's lateness", "Wake-up after the deadline of each tick.", late),
            ),
            section("Events", "What was told to the driller.", table(_events(story)), long=True),
            section(
                "Configuration",
                "As recorded with the session.",
                folded("configuration.toml", session.configuration or "none was recorded")
                + table([(name.replace("_", " "), told) for name, told in summary.metadata.items()]),
                long=True,
            ),
        )
    )


def _over_time(severity: Severity, minute_s: float) -> str:
    return section(
        "The whole session",
        "Bit and top of the string as confirmed. Each stretch too short to be drawn is shown by its "
        f"least and greatest. Severity is (ω_max − ω_min) / (2 ω_mean) of the bit's speed over "
        f"{severity.window_s:g} s: 0 is smooth, from 1 (dotted) on the bit stops. Shaded: the worst "
        "stretch, shown below.",
        place("over-time"),
    ) + section(
        f"The worst {minute_s:g} s",
        "Every tick of the stretch in which bit and top were furthest apart (rms). Now was said at "
        "the time, foretold as far ahead as the waves in the string tell; confirmed is what both "
        "were held against later.",
        place("closely"),
    )


def _string_and_rock(story: Story, drawn: set[str]) -> str:
    return section(
        "How the bit and the rock got on",
        "Where the bit was, the darker the oftener (by tenfold steps); red: the load law learned, "
        f"{_law_words(story)}.",
        place("portrait"),
    ) + section(
        "Along the string",
        "The greatest torque and shear stress at each depth in the session, what the components "
        "bear, and the least that was left, 100 % being no load.",
        place("along") if "along" in drawn else _note("The session holds no profiles of the string."),
    )


def _foretold() -> str:
    return section(
        "How well it was foretold",
        "Root mean square of what was said less what was confirmed in the end: now and forecast of "
        "every tick, and at five horizons what the sensor counted while it ran, over the session and "
        "in its last minute.",
        place("by-horizon"),
    )


def _note(words: str) -> str:
    return f'<p class="note">{words}</p>'


def _window(session: Session) -> float:
    try:
        return loads(session.configuration or "", str(session.path)).estimator.severity_window
    except VsensorError:  # none, or one of another version: the report does without
        return WINDOW_S


def _law(story: Story) -> tuple[float, float, float, float] | None:
    status = story.status
    if status is None or not status.HasField("law_kinetic_nm"):
        return None
    return (
        status.law_viscous_nm_s_rad,
        status.law_kinetic_nm,
        status.law_static_nm,
        status.law_stribeck_rad_s,
    )


def _law_words(story: Story) -> str:
    law = _law(story)
    if law is None:
        return "of which the session tells nothing"
    viscous, kinetic, static, stribeck = law
    return (
        f"T = {viscous:.0f} N·m·s/rad · ω + {kinetic * plots.KNM:.2f} kN·m + "
        f"{(static - kinetic) * plots.KNM:.2f} kN·m · exp(−ω / {stribeck * plots.RPM:.0f} rpm)"
    )


def _losses(story: Story, summary: Summary) -> list[tuple[str, str]]:
    return [
        (name, "not counted" if count is None else f"{count}") for name, count in words.losses(story, summary)
    ]


def _events(story: Story) -> list[tuple[str, str]]:
    told = [
        (f"{(event.time_ns - story.first_ns) / 1e9:.1f} s", event.text or event.name)
        for event in story.events
    ]
    return told + ([("…", f"{story.more_events} more")] if story.more_events else [])
