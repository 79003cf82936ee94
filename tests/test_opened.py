"""Sessions in other programs: Rerun's own reader takes them whole; each layout names only what is there."""

import json
import re
import subprocess
from collections import Counter
from importlib.resources import files
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from vsensor.messages import message_type
from vsensor.recording.reader import Session
from vsensor.view import opened

ROOT = Path(__file__).parents[1]
GOLDEN = ROOT / "recordings" / "stick_slip.mcap"


def field_of(topic: str, field: str) -> bool:
    kind = message_type(topic)
    return kind is not None and field in kind.DESCRIPTOR.fields_by_name


def test_the_foxglove_layout_names_fields_that_there_are() -> None:
    layout = json.loads((ROOT / "config" / "views" / "foxglove.json").read_text(encoding="utf-8"))
    paths = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", ())]
    assert len(paths) >= 10
    for path in paths:
        topic, _, field = path.partition(".")
        assert field_of(topic, field), path
    panels = set(re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"])))
    assert panels == set(layout["configById"])


def test_the_plotjuggler_layout_names_numbers_that_there_are() -> None:
    layout = (ROOT / "config" / "views" / "plotjuggler.xml").read_text(encoding="utf-8")
    curves = re.findall(r'<curve name="([^"]+)"', layout)
    assert len(curves) >= 10
    for curve in curves:
        topic, _, field = curve.rpartition("/")
        assert field_of(topic, field), curve
        kind = message_type(topic)
        assert kind is not None
        assert kind.DESCRIPTOR.fields_by_name[field].enum_type is None  # these it shows as words


@pytest.mark.parametrize("lines", [opened.SPEEDS, opened.TORQUES, opened.ROUGHNESS, opened.LATENESS])
def test_the_rerun_layout_names_fields_that_there_are(lines: opened.Lines) -> None:
    for topic, fields in lines.items():
        assert all(field_of(topic, field) for field in fields)


def rerun(*words: str) -> str:
    """What the binary says; the script about it would look for a network."""
    done = subprocess.run(
        [str(files("rerun_cli") / "rerun"), *words],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env={"CI": "1", "RUST_LOG": "error", "HOME": "/nonexistent"},
    )
    return done.stdout


@pytest.mark.process
def test_rerun_reads_every_message_of_a_session(tmp_path: Path) -> None:
    rerun("mcap", "convert", str(GOLDEN), "-o", str(tmp_path / "a.rrd"))
    found: Counter[str] = Counter()
    for rows, topic, kind in re.findall(
        r"with (\d+) rows [^\n]* - /(\S+) - data columns: \[/\S+@(vsensor\.\w+):message\]",
        rerun("rrd", "print", "-v", str(tmp_path / "a.rrd")),
    ):
        expected = message_type(topic)
        assert expected is not None
        assert expected.DESCRIPTOR.full_name == kind
        found[topic] += int(rows)
    assert found == {topic.topic: topic.messages for topic in Session(GOLDEN).summary().topics}


@pytest.mark.process
def test_the_shipped_layout_is_one_that_rerun_reads() -> None:
    said = rerun("rrd", "print", str(ROOT / "config" / "views" / "session.rbl"))
    assert opened.APPLICATION in said


def test_who_knows_nothing_of_us_can_decode_a_session() -> None:
    """As Foxglove and PlotJuggler do: by the schemas in the file alone."""
    with GOLDEN.open("rb") as file:
        decoded = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        speeds = [
            message.confirmed_bit_speed_rad_s
            for _, channel, _, message in decoded
            if channel.topic == "bit/estimate" and message.HasField("confirmed_bit_speed_rad_s")
        ]
    assert len(speeds) > 1000
    assert max(speeds) > 20
