"""A status as Prometheus sees it: which of its fields are told, under which name, and as what."""

from collections.abc import Iterator
from itertools import accumulate

from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
    Metric,
)

from vsensor.messages import Status
from vsensor.messages.books import REFUSALS
from vsensor.messages.states import STATES
from vsensor.messages.vsensor_pb2 import Histogram

# Field of the status → name without `vsensor_`, and what it is.
COUNTERS = {
    "slots_run": ("slots_run", "Turns of the loop that were run."),
    "slots_skipped": ("slots_skipped", "Turns of the loop that passed while it was late."),
    "ticks": ("ticks", "Ticks for which both channels had samples."),
    "restarts": (
        "restarts",
        "Times that the estimator began anew, after a jump of the source's clock or a long gap.",
    ),
    "published": ("published", "Estimates handed to the bus."),
    "recorded": ("recorded", "Messages handed to the recorder."),
    "bus_missed": ("bus_missed_samples", "Samples that the bus lost and could not get back."),
    "recorder_dropped": ("recorder_dropped", "Messages that could not be recorded."),
    "depths_refused": ("depths_refused", "Samples of the depth channels that were refused."),
    "sheddings": ("sheddings", "Times that the loop began to leave something out to keep up."),
    "sticks_foretold": ("sticks_foretold", "Sticks of the bit that came as foretold."),
    "sticks_missed": ("sticks_missed", "Sticks of the bit that came without a word."),
    "sticks_false": ("sticks_false", "Sticks of the bit that were foretold and did not come."),
    "recording_deleted": ("recording_deleted", "Old sessions deleted to keep within the limits."),
}
GAUGES = {
    "uptime_s": ("uptime_seconds", "Since the daemon's start."),
    "rate_hz": ("rate_hertz", "Turns of the loop a second, as configured."),
    "load": ("load_ratio", "Share of the last second in which the loop worked."),
    "shed": ("shed", "What the loop leaves out to keep up: 0 nothing, 1 profile, 2 forecast too."),
    "severity": (
        "severity_ratio",
        "Swing of the bit's speed over twice its mean: stick-slip from 1 on.",
    ),
    "stick_slip_period_s": ("stick_slip_period_seconds", "Period of the bit's swing."),
    "stuck_share": (
        "stuck_ratio",
        "Share of the severity window in which the bit stood while the top turned.",
    ),
    "back_rotation_share": (
        "back_rotation_ratio",
        "Share of the severity window in which the bit turned back.",
    ),
    "top_power_w": ("top_power_watts", "Mean power fed in at the string's top."),
    "bit_power_w": ("bit_power_watts", "Mean power used by the bit."),
    "confirmed_delay_s": ("confirmed_delay_seconds", "How late an answer is confirmed."),
    "forecast_horizon_s": ("forecast_horizon_seconds", "How far ahead the bit is foretold."),
    "string_length_m": ("string_length_meters", "Length of the string."),
    "off_bottom": ("off_bottom", "Whether the bit is held to be off bottom."),
    "depths_silent": ("depths_silent", "Whether a depth channel that has spoken is silent."),
    "rock_std_nm": (
        "rock_torque_std_newton_meters",
        "Standard deviation of what the bit does and the load law does not foresee, as a torque.",
    ),
    "delay_correction": ("delay_correction_ratio", "What the record corrected of the waves' travel time."),
    "impedance_correction": (
        "impedance_correction_ratio",
        "What the record corrected of the string's impedance.",
    ),
    "inertia_correction": (
        "inertia_correction_ratio",
        "What the record corrected of the top drive's inertia.",
    ),
    "friction_correction": ("friction_correction_ratio", "What the record corrected of the wall's friction."),
    "memory_locked": ("memory_locked", "Whether the daemon's memory is locked."),
    "kept_awake": ("kept_awake", "Whether the machine's processors are kept from their idle states."),
    "recording_bytes": ("recording_bytes", "Size of the session that is being written."),
    "recording_free_bytes": ("recording_free_bytes", "Free space on its disk."),
    "inbox_waiting": (
        "inbox_waiting_samples",
        "Samples that waited for one turn of the loop: the most in the last second.",
    ),
    "recorder_queue_bytes": ("recorder_queue_bytes", "What waits in the socket to the recorder."),
    "recorder_queue_limit_bytes": (
        "recorder_queue_limit_bytes",
        "What the socket to the recorder holds: beyond it messages are dropped.",
    ),
    "recording_backlog_bytes": (
        "recording_backlog_bytes",
        "What waited in the recorder for the disk: the most in the last second.",
    ),
}
HISTOGRAMS = {
    "lateness": ("lateness_seconds", "Wake-up of the loop after its deadline."),
    "work": ("work_seconds", "Work of a turn of the loop."),
    "input_age": ("input_age_seconds", "Age of the older channel's newest sample at each turn."),
    "publish": ("publish_seconds", "Time spent on handing a turn's messages to the bus."),
}
EVERY = 4
"""Of the status's buckets, four to each doubling, Prometheus is told one: 25 for each histogram."""


def families(status: Status) -> Iterator[Metric]:
    """Every metric of a status; a field that it does not tell is none."""
    rig = [status.rig]
    build = InfoMetricFamily("vsensor", "The daemon.", labels=["rig"])
    told = {name: getattr(status, name) for name in ("version", "realtime", "scheduling", "processors")}
    build.add_metric(rig, {name: value for name, value in told.items() if value})
    yield build
    yield from _numbers(status, rig)
    yield from _states(status)
    yield from _channels(status)
    for field, (name, text) in HISTOGRAMS.items():
        if status.HasField(field):  # type: ignore[arg-type]  # mypy-protobuf knows the names as literals
            buckets, total = _cumulative(getattr(status, field))
            family = HistogramMetricFamily(f"vsensor_{name}", text, labels=["rig"])
            family.add_metric(rig, buckets, total)
            yield family


def _numbers(status: Status, rig: list[str]) -> Iterator[Metric]:
    kinds = ((CounterMetricFamily, COUNTERS), (GaugeMetricFamily, GAUGES))
    for kind, named in kinds:
        for field, (name, text) in named.items():
            if status.HasField(field):  # type: ignore[arg-type]
                family = kind(f"vsensor_{name}", text, labels=["rig"])
                family.add_metric(rig, float(getattr(status, field)))
                yield family


def _states(status: Status) -> Iterator[Metric]:
    state = GaugeMetricFamily("vsensor_state", "1 for the state that holds.", labels=["rig", "state"])
    for name in dict.fromkeys((*STATES, status.state)):
        state.add_metric([status.rig, name], float(name == status.state))
    yield state
    recording = GaugeMetricFamily("vsensor_recording", "Whether a session is being written.", labels=["rig"])
    recording.add_metric([status.rig], float(bool(status.recording)))
    yield recording
    unsaved = GaugeMetricFamily(
        "vsensor_learned_unsaved", "Whether what is learned cannot be saved.", labels=["rig"]
    )
    unsaved.add_metric([status.rig], float(bool(status.learned_trouble)))
    yield unsaved
    skill = GaugeMetricFamily(
        "vsensor_prediction_error_speed_radians_per_second",
        "Root mean square by which the bit's speed, foretold so far ahead, missed of late.",
        labels=["rig", "ahead_seconds"],
    )
    for each in status.skill:
        if each.HasField("speed_rms_rad_s"):
            skill.add_metric([status.rig, f"{each.ahead_s:.3g}"], each.speed_rms_rad_s)
    yield skill


def _channels(status: Status) -> Iterator[Metric]:
    labels = ["rig", "channel"]
    samples = CounterMetricFamily(
        "vsensor_samples", "Samples received, by what became of them.", labels=[*labels, "outcome"]
    )
    # No counter: a sample that only comes late is no loss any longer.
    lost = GaugeMetricFamily(
        "vsensor_samples_lost",
        "Samples since the start of which only a hole in the sequence tells.",
        labels=labels,
    )
    age = GaugeMetricFamily("vsensor_sample_age_seconds", "Since the last accepted sample.", labels=labels)
    for channel in status.channels:
        of = [status.rig, channel.channel]
        for outcome in ("accepted", *REFUSALS):
            samples.add_metric([*of, outcome], getattr(channel, outcome))
        lost.add_metric(of, channel.lost)
        if channel.HasField("age_s"):
            age.add_metric(of, channel.age_s)
    yield from (samples, lost, age)


def _cumulative(histogram: Histogram) -> tuple[list[tuple[str, float]], float]:
    """Buckets as Prometheus wants them: each holds all below it, the last one everything."""
    counts = list(accumulate(histogram.counts))
    uppers = list(histogram.upper_s)
    buckets = [(str(upper), float(count)) for upper, count in zip(uppers, counts, strict=False)]
    return [*buckets[::EVERY], ("+Inf", float(counts[-1]))], histogram.sum_s
