"""A session's surface samples as the sensor takes them: by columns, in the order of arrival."""

from collections.abc import Callable, Collection, Iterator, Mapping

import numpy as np

from vsensor.intake.arrivals import Arrivals, Feed
from vsensor.messages import (
    DEPTH_TOPICS,
    SENSOR_EVENT,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Event,
    Sample,
)
from vsensor.recording.columns import Columns, read_columns
from vsensor.recording.reader import Session

_FIELDS = ("time_ns", "value", "quality", "sequence")
_CHANNELS = (SURFACE_TORQUE, SURFACE_SPEED)


def _not_settled(_topic: str, _sample: Sample) -> bool:
    return False


def feed(
    session: Session, obeyed: Collection[str], settles: Callable[[str, Sample], bool] = _not_settled
) -> Feed:
    """Yield surface samples and, at their places between them, depths and the events of these names.

    A depth that `settles` takes itself is not yielded, and the samples around it stay together: most depths
    change nothing, and to part the samples at each would cost more than all the rest.
    """
    wanted = dict.fromkeys(_CHANNELS, _FIELDS)
    for piece in read_columns(session, wanted, whole=(*DEPTH_TOPICS, SENSOR_EVENT)):
        place, arrivals = _arrivals(piece)
        start = 0
        for at, topic, message in sorted(_between(piece, obeyed), key=lambda told: told[0]):
            if isinstance(message, Sample) and settles(topic, message):
                continue
            end = int(np.searchsorted(place, at))
            if end > start:
                yield arrivals.part(start, end)
            yield topic, message
            start = end
        if start < len(place):
            yield arrivals.part(start, len(place))


def _arrivals(piece: Mapping[str, Columns]) -> tuple[np.ndarray, Arrivals]:
    """Both channels' samples in one order, and which message of the session each is."""
    came = [(topic == SURFACE_SPEED, piece[topic]) for topic in _CHANNELS if topic in piece]
    if not came:
        return np.empty(0, np.int64), Arrivals.none()
    place = np.concatenate([columns.place for _, columns in came])
    order = np.argsort(place)
    values = {name: np.concatenate([columns.values[name] for _, columns in came])[order] for name in _FIELDS}
    numbered = np.concatenate([columns.known["sequence"] for _, columns in came])[order]
    is_speed = np.concatenate([np.full(len(columns), speed) for speed, columns in came])[order]
    return place[order], Arrivals(is_speed=is_speed, numbered=numbered, **values)


def _between(
    piece: Mapping[str, Columns], obeyed: Collection[str]
) -> Iterator[tuple[int, str, Sample | Event]]:
    for topic in (*DEPTH_TOPICS, SENSOR_EVENT):
        if topic in piece:
            for place, message in zip(piece[topic].place.tolist(), piece[topic].messages, strict=True):
                if isinstance(message, Sample) or (isinstance(message, Event) and message.name in obeyed):
                    yield place, topic, message
