"""Surface samples as rigs send them: protobuf, JSON or a bare number, by the stated encoding."""

import json
from collections.abc import Callable

from google.protobuf import json_format
from google.protobuf.message import DecodeError

from vsensor.messages.vsensor_pb2 import Sample

PROTOBUF = "application/protobuf"
JSON = "application/json"
TEXT = "text/plain"

MAX_BYTES = 4096
"""A sample takes some fifty bytes; whatever is far larger is none."""


def decode(payload: bytes, encoding: str, arrival_time_ns: Callable[[], int | None]) -> Sample:
    """Read one surface sample.

    Where it bears no time of its own `arrival_time_ns` is asked for one (Zenoh's timestamp, Unix; None
    where it has none). Raises ValueError with what was wrong and what would be right.
    """
    check_size(len(payload))
    sample = _by_encoding(payload, encoding.partition(";")[0])
    if not sample.HasField("value"):
        raise ValueError("has no value")
    if not sample.HasField("time_ns"):
        if (arrived_ns := arrival_time_ns()) is None:
            raise ValueError("has no time_ns, and the bus gave it no timestamp")
        sample.time_ns = arrived_ns
    return sample


def check_size(size: int) -> None:
    """Raise ValueError where so many bytes are no sample."""
    if size > MAX_BYTES:
        raise ValueError(f"{size} bytes: a sample takes at most {MAX_BYTES}")


def _by_encoding(payload: bytes, encoding: str) -> Sample:
    try:
        match encoding:
            case "application/protobuf":
                return Sample.FromString(payload)
            case "application/json":
                return _by_json(payload)
            case "text/plain":
                return Sample(value=float(payload))
    except (DecodeError, json_format.ParseError, ValueError, RecursionError) as error:
        raise ValueError(f"is not valid {encoding}: {error}") from error
    raise ValueError(f"encoding {encoding!r} is none of {PROTOBUF}, {JSON}, {TEXT}")


def _by_json(payload: bytes) -> Sample:
    """Protobuf's JSON, in which a quality may also be written small, as it is everywhere else."""
    told = json.loads(payload)
    if not isinstance(told, dict):
        raise ValueError('an object was expected, such as {"time_ns": 1700000000000000000, "value": 12.5}')
    if isinstance(quality := told.get("quality"), str):
        told["quality"] = quality.upper()
    return json_format.ParseDict(told, Sample())
