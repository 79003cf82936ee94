"""What the commands say of sessions that are torn, damaged or mended: never that all is there."""

from pathlib import Path

import pytest
from mcap.reader import make_reader

from tests.test_cli_recording import CONFIG, vsensor


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of some chunks that verifies."""
    folder = tmp_path_factory.mktemp("made")
    lines = [f"{n / 100},{n % 50 * 100},{9 + n % 7 / 10}\n" for n in range(1500)]
    (folder / "a.csv").write_text("time_s,motor_torque_nm,motor_speed_rad_s\n" + "".join(lines))
    (folder / "rig.toml").write_text(CONFIG)
    done = vsensor("estimate", folder / "a.csv", folder / "rig.toml", "-o", folder / "a.mcap")
    assert done.exit_code == 0, done.output
    return folder / "a.mcap"


def chunks(path: Path) -> list[int]:
    """Where they begin."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [at.chunk_start_offset for at in summary.chunk_indexes]


def damaged(made: Path, path: Path, at: int, *, torn: bool = False) -> Path:
    """One bit flipped, and where it is to be torn, without its end."""
    data = bytearray(made.read_bytes())
    data[at] ^= 1
    path.write_bytes(data[:-20] if torn else data)
    return path


def test_recover_tells_where_what_it_lost_stood(made: Path, tmp_path: Path) -> None:
    at = chunks(made)[1]
    done = vsensor("recover", damaged(made, tmp_path / "b.mcap", at + 1000))
    assert done.exit_code == 0
    assert f"bytes from byte {at}," in done.output
    assert f"of {tmp_path / 'b.mcap'} " in done.output
    assert "all of" in vsensor("recover", made, "-o", tmp_path / "c.mcap").output


def test_recover_of_nothing_is_an_error(tmp_path: Path, made: Path) -> None:
    (tmp_path / "b.mcap").write_bytes(made.read_bytes()[:100])
    done = vsensor("recover", tmp_path / "b.mcap")
    assert (done.exit_code, "b.mcap: nothing of it could be saved" in done.output) == (1, True)
    assert [path.name for path in tmp_path.iterdir()] == ["b.mcap"]


def test_a_mended_session_does_not_claim_to_be_whole(made: Path, tmp_path: Path) -> None:
    torn = damaged(made, tmp_path / "b.mcap", chunks(made)[-1] + 1000)
    assert vsensor("recover", torn).exit_code == 0
    mended = tmp_path / "b.recovered.mcap"
    said = " ".join(vsensor("info", mended).output.split())
    assert "state recovered, but not whole" in said
    assert f"bytes from byte {chunks(made)[-1]}" in said
    told = "was recovered from b.mcap, of which"
    for words in (("verify", mended), ("estimate", mended, "-o", tmp_path / "x.csv")):
        done = vsensor(*words)
        assert done.exit_code == 0, done.output
        assert told in done.output
    assert "exact" in vsensor("verify", mended).output


def test_verification_goes_on_and_is_not_exact_over_a_hole(made: Path, tmp_path: Path) -> None:
    assert vsensor("verify", made).exit_code == 0
    vsensor("recover", damaged(made, tmp_path / "b.mcap", chunks(made)[1] + 1000))
    done = vsensor("verify", tmp_path / "b.recovered.mcap")
    assert done.exit_code == 1
    assert "exact" not in done.output
    assert "the next recorded is" in done.output


def test_info_names_the_place_of_damage(made: Path, tmp_path: Path) -> None:
    at = chunks(made)[1]
    said = " ".join(vsensor("info", damaged(made, tmp_path / "b.mcap", at + 1000, torn=True)).output.split())
    assert "state torn, damaged or still being written: " in said
    assert f"bytes from byte {at}, " in said
    flipped = damaged(made, tmp_path / "c.mcap", made.read_bytes().index(b"[rig]"))
    assert "bytes from byte" in vsensor("info", flipped).output


@pytest.mark.parametrize(
    ("command", "format_"), [("export", "csv"), ("estimate", "csv"), ("estimate", "mcap")]
)
def test_a_table_of_what_is_left_says_so(made: Path, tmp_path: Path, command: str, format_: str) -> None:
    torn = tmp_path / "b.mcap"
    torn.write_bytes(made.read_bytes()[: chunks(made)[-1] + 1000])
    done = vsensor(command, torn, "-o", tmp_path / f"x.{format_}")
    assert done.exit_code == 0, done.output
    assert f"{torn} is torn, damaged or still being written: 1000 bytes from byte" in done.stderr
    assert "torn" not in vsensor(command, made, "-o", tmp_path / f"y.{format_}").output


def test_what_damage_has_taken_is_not_said_never_to_have_been(made: Path, tmp_path: Path) -> None:
    at = chunks(made)[0]
    torn = tmp_path / "b.mcap"
    torn.write_bytes(made.read_bytes()[: at + 1000])
    done = vsensor("export", torn, "-o", tmp_path / "x.csv")
    assert done.exit_code == 1
    assert (
        f"1000 bytes from byte {at} cannot be read; what is left of it holds no bit/estimate" in done.output
    )
    done = vsensor("estimate", torn, "-o", tmp_path / "x.csv")
    assert f"1000 bytes from byte {at} cannot be read; what is left of it gives no tick" in done.output


def test_each_of_several_sessions_is_verified_whatever_the_others_are(made: Path, tmp_path: Path) -> None:
    torn = damaged(made, tmp_path / "b.mcap", chunks(made)[1] + 1000, torn=True)
    broken = damaged(made, tmp_path / "c.mcap", chunks(made)[1] + 1000)
    bare = tmp_path / "d.mcap"
    vsensor("import", made.with_suffix(".csv"), "-o", bare, "--rig", "r")
    done = vsensor("verify", tmp_path / "no.mcap", bare, torn, broken, made)
    assert done.exit_code == 1
    assert f"error: {tmp_path / 'no.mcap'}: no such file" in done.output
    assert f"error: {bare}: holds no configuration" in done.output
    assert f"{torn} is torn, damaged or still being written" in done.output
    assert f"error: {broken}: is damaged after byte" in done.output
    assert f"{made}: exact" in done.output
    assert vsensor("verify", made, made).exit_code == 0
