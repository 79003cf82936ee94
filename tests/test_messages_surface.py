"""A surface sample in any form a rig may send; whatever else comes is told, and never stops the loop."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.messages import Sample, surface
from vsensor.quality import Quality

ARRIVED = 1_700_000_000_000_000_000
times = st.integers(-(2**63), 2**63 - 1)
encodings = st.one_of(
    st.sampled_from([surface.PROTOBUF, surface.JSON, surface.TEXT, "application/json;charset=utf-8"]),
    st.text(),
)
json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text()),
    lambda inner: st.one_of(st.lists(inner), st.dictionaries(st.text(), inner)),
)
fields = st.sampled_from(
    ["time_ns", "timeNs", "value", "sequence", "standard_deviation", "quality", "reasons", "x"]
)


def read_or_refused(payload: bytes, encoding: str, arrived: int | None) -> None:
    try:
        sample = surface.decode(payload, encoding, lambda: arrived)
    except ValueError:
        return
    assert sample.HasField("value")
    assert sample.HasField("time_ns")


@given(st.binary(), encodings, st.one_of(st.none(), st.integers()))
def test_any_bytes_are_a_sample_or_a_value_error(payload: bytes, encoding: str, arrived: int | None) -> None:
    read_or_refused(payload, encoding, arrived)


@given(st.one_of(json_values, st.dictionaries(fields, json_values)), st.one_of(st.none(), times))
def test_any_json_is_a_sample_or_a_value_error(value: object, arrived: int | None) -> None:
    read_or_refused(json.dumps(value).encode(), surface.JSON, arrived)


@given(st.text())
def test_any_text_is_a_sample_or_a_value_error(text: str) -> None:
    read_or_refused(text.encode(), surface.TEXT, ARRIVED)


@pytest.mark.parametrize(
    "payload", [b"[" * 4000, b'{"x":' * 800, b"1" * 4096, b"\x0b" * 4000, b"1" * 100_000]
)
@pytest.mark.parametrize("encoding", [surface.PROTOBUF, surface.JSON, surface.TEXT])
def test_payloads_that_are_deep_or_long_are_a_sample_or_a_value_error(payload: bytes, encoding: str) -> None:
    read_or_refused(payload, encoding, ARRIVED)


@given(times, st.floats(allow_nan=False), st.integers(0, 2**64 - 1))
def test_protobuf_and_json_say_the_same(time_ns: int, value: float, sequence: int) -> None:
    sample = Sample(time_ns=time_ns, value=value, sequence=sequence)
    text = json.dumps({"time_ns": time_ns, "value": _json_number(value), "sequence": sequence})
    assert surface.decode(sample.SerializeToString(), surface.PROTOBUF, lambda: None) == sample
    assert surface.decode(text.encode(), surface.JSON, lambda: None) == sample


@pytest.mark.parametrize("quality", ["good", "uncertain", "bad", "GOOD", "Bad"])
def test_a_quality_in_json_may_be_written_small(quality: str) -> None:
    text = json.dumps({"time_ns": 1, "value": 2.5, "quality": quality})
    sample = surface.decode(text.encode(), surface.JSON, lambda: None)
    assert Quality(int(sample.quality)).name == quality.upper()


@pytest.mark.parametrize("text", ["5", "[5]", '"5"', "null"])
def test_json_that_is_no_object_is_refused_with_what_would_be_right(text: str) -> None:
    with pytest.raises(
        ValueError, match=r'is not valid application/json: an object was expected, such as {"time_ns"'
    ):
        surface.decode(text.encode(), surface.JSON, lambda: ARRIVED)


def _json_number(value: float) -> float | str:
    """Protobuf's JSON puts what JSON has no number for into quotes."""
    return value if math.isfinite(value) else ("Infinity" if value > 0 else "-Infinity")


@given(st.floats(allow_nan=False))
def test_a_bare_number_bears_the_time_of_its_arrival(value: float) -> None:
    sample = surface.decode(repr(value).encode(), surface.TEXT, lambda: ARRIVED)
    assert (sample.time_ns, sample.value) == (ARRIVED, value)
    assert not sample.HasField("sequence")


def test_a_time_of_its_own_outranks_the_arrival() -> None:
    assert surface.decode(b'{"time_ns": 5, "value": 0}', surface.JSON, lambda: ARRIVED).time_ns == 5


def test_zero_is_a_value_and_absence_is_none() -> None:
    assert surface.decode(b'{"value": 0}', surface.JSON, lambda: 0).HasField("value")
    with pytest.raises(ValueError, match="has no value"):
        surface.decode(b"{}", surface.JSON, lambda: ARRIVED)
    with pytest.raises(ValueError, match="has no time_ns"):
        surface.decode(b"1.5", surface.TEXT, lambda: None)
    with pytest.raises(ValueError, match="is none of application/protobuf"):
        surface.decode(b"1.5", "zenoh/bytes", lambda: ARRIVED)
