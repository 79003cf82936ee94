"""Who gets in: certificates and passwords over real sessions, with the examples that are shipped."""

import json
import os
import subprocess
from pathlib import Path

import pytest

from tests.locks import EXAMPLES, USERS, Etc, make_authority
from vsensor.bus import open_session
from vsensor.bus.access import PASSWORD, SETTINGS
from vsensor.config import Bus, loads
from vsensor.errors import BusError, ConfigError, VsensorError

PIPE = '[[string]]\nlength = "9 m"\nouter_diameter = "5 in"\ninner_diameter = "4 in"\n'
WORD = "hunter2"


@pytest.fixture(scope="module")
def etc(tmp_path_factory: pytest.TempPathFactory) -> Etc:
    return Etc(tmp_path_factory.mktemp("etc"))


def gets_in(daemon: Bus, client: Bus) -> bool:
    """Whether a client gets in where a daemon listens; the daemon itself must come up."""
    with open_session(daemon, "daemon"):
        try:
            with open_session(client, "client"):
                return True
        except BusError:
            return False


@pytest.mark.parametrize("role", ["surface", "viewer", "driller", "sensor"])
def test_a_certificate_of_our_authority_gets_in(etc: Etc, role: str) -> None:
    bus = etc.bus("daemon-mutual-tls")
    assert gets_in(bus, etc.certified(bus, role))


def test_without_a_certificate_nobody_gets_in(etc: Etc) -> None:
    bus = etc.bus("daemon-mutual-tls")
    stranger = etc.certified(bus, "client-tls")
    with (
        open_session(bus, "daemon"),
        pytest.raises(BusError, match=r"up\? .* Does it take our certificate, our user and password\?"),
    ):
        open_session(stranger, "client")


def test_a_certificate_of_a_foreign_authority_does_not_get_in(etc: Etc, tmp_path: Path) -> None:
    """It bears the same names, and its bearer knows our authority's certificate, which is no secret."""
    foreign = Etc(tmp_path)
    (tmp_path / "tls" / "ca.pem").write_bytes((etc.folder / "tls" / "ca.pem").read_bytes())
    bus = etc.bus("daemon-mutual-tls")
    assert not gets_in(bus, foreign.certified(bus, "surface"))


def test_a_daemon_of_a_foreign_authority_is_not_talked_to(etc: Etc, tmp_path: Path) -> None:
    """Nobody stands in for the daemon: password and samples would go to a stranger."""
    for lock in ("daemon-tls", "daemon-password"):
        bus = Etc(tmp_path / lock).bus(lock)
        assert not gets_in(bus, etc.logged_in(bus, "surface"))


def test_without_tls_nobody_gets_in(etc: Etc) -> None:
    bus = etc.bus("daemon-tls")
    plain = tuple(end.replace("tls/", "tcp/") for end in bus.listen)
    assert not gets_in(bus, Bus(connect=plain))
    assert gets_in(bus, etc.logged_in(bus, None))


@pytest.mark.parametrize("user", USERS)
def test_a_user_with_the_right_password_gets_in(etc: Etc, user: str) -> None:
    bus = etc.bus("daemon-password")
    assert gets_in(bus, etc.logged_in(bus, user))


def test_a_wrong_password_no_password_and_an_unknown_user_do_not_get_in(
    etc: Etc, monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = etc.bus("daemon-password")
    assert not gets_in(bus, etc.logged_in(bus, None))
    monkeypatch.setenv(PASSWORD, USERS["surface"])
    assert gets_in(bus, etc.logged_in(bus, "surface"))
    assert not gets_in(bus, etc.logged_in(bus, "viewer"))
    assert not gets_in(bus, etc.logged_in(bus, "nobody"))


def test_the_environment_names_who_we_are_where_no_configuration_does(
    etc: Etc, monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = etc.bus("daemon-mutual-tls")
    assert not gets_in(bus, etc.certified(bus, "client-tls"))
    monkeypatch.setenv(SETTINGS, str(etc.zenoh("viewer")))
    assert gets_in(bus, etc.certified(bus, "client-tls"))
    assert gets_in(bus, Bus(connect=bus.listen))


def test_the_authority_is_kept_and_its_keys_are_ours_alone(tmp_path: Path) -> None:
    make_authority(tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    (tmp_path / "viewer.pem").unlink()
    make_authority(tmp_path, "rig.example", "10.1.2.3")
    after = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    changed = {name for name in after if after[name] != before[name]}
    assert changed == {"viewer.pem", "viewer.key", "ca.srl"}
    assert all(key.stat().st_mode & 0o777 == 0o600 for key in tmp_path.glob("*.key"))


def test_a_certificate_bears_the_hosts_that_were_named(tmp_path: Path) -> None:
    make_authority(tmp_path, "rig.example", "10.1.2.3")
    said = subprocess.run(
        ["openssl", "x509", "-in", tmp_path / "daemon.pem", "-noout", "-ext", "subjectAltName"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    for name in ("DNS:localhost", "IP Address:127.0.0.1", "DNS:rig.example", "IP Address:10.1.2.3"):
        assert name in said


def complaint(bus: Bus) -> str:
    with pytest.raises(VsensorError) as refused:
        open_session(bus, "client")
    return str(refused.value)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('{transport: {auth: {usrpwd: {password: "hunter2}}}}', "1:52"),
        ('{transport: {auth: {usrpwd: "hunter2"}}}', 'invalid type: string "…", expected struct'),
        ('{transport: {auth: {usrpwd: {user: "a", password: ["hunter2"]}}}}', "invalid type"),
        ('{transport: {link: {rx: {buffer_size: "hunter2"}}}}', "line 1, column 39: error parsing number"),
    ],
)
def test_settings_that_cannot_be_read_are_told_by_their_place_alone(
    tmp_path: Path, bus: Bus, text: str, place: str
) -> None:
    file = tmp_path / "zenoh.json5"
    file.write_text(text, encoding="utf-8")
    said = complaint(bus.model_copy(update={"client_zenoh_config": file}))
    assert f"bus.client_zenoh_config {file}: is no Zenoh configuration" in said
    assert place in said
    assert WORD not in said


def test_a_secret_that_everyone_can_read_is_refused(etc: Etc, tmp_path: Path) -> None:
    """The file of a password, a private key, a dictionary, and settings that hold a password."""
    own = Etc(tmp_path)
    bus = own.bus("daemon-password")
    settings = tmp_path / "own.json5"
    settings.write_text('{transport: {auth: {usrpwd: {user: "a", password: "b"}}}}', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"own\.json5: holds a secret that everyone .* chmod o-rwx"):
        open_session(bus.model_copy(update={"client_zenoh_config": settings}), "client")
    for name, opened, role in (
        ("surface.password", own.logged_in(bus, "surface"), "client"),
        ("users.txt", bus, "daemon"),
        ("tls/daemon.key", bus, "daemon"),
        ("tls/viewer.key", own.certified(bus, "viewer"), "client"),
    ):
        (tmp_path / name).chmod(0o644)
        with pytest.raises(ConfigError, match=rf"{name}: holds a secret that everyone"):
            open_session(opened, "daemon" if role == "daemon" else "client")
        (tmp_path / name).chmod(0o640)


def test_a_missing_password_or_key_is_named(etc: Etc, tmp_path: Path) -> None:
    bus = etc.bus("daemon-password")
    no_word = bus.model_copy(update={"user": "viewer"})
    assert f"bus.user viewer: has no password: name its file, password_file, or set {PASSWORD}" in complaint(
        no_word
    )
    gone = tmp_path / "gone"
    assert f"{gone}: cannot be read: No such file" in complaint(
        no_word.model_copy(update={"password_file": gone})
    )
    settings = tmp_path / "zenoh.json5"
    key = {"transport": {"link": {"tls": {"connect_private_key": str(gone)}}}}
    settings.write_text(json.dumps(key), encoding="utf-8")
    assert f"{gone}: cannot be read" in complaint(bus.model_copy(update={"client_zenoh_config": settings}))


def test_a_key_within_an_endpoint_is_refused_unspoken() -> None:
    for end in (f"tls/a:1#connect_private_key_base64={WORD}", f"tls/a:1 #listen_private_key_raw={WORD}"):
        with pytest.raises(ConfigError, match="an endpoint that holds a key itself") as refused:
            loads(f'[rig]\nname = "x"\n{PIPE}[bus]\nlisten = ["{end}"]\n', "rig.toml")
        assert WORD not in str(refused.value)


def test_a_password_in_the_rigs_own_configuration_is_refused_unspoken() -> None:
    with pytest.raises(
        ConfigError, match=r"bus\.password: no such key: did you mean password_file\?"
    ) as refused:
        loads(f'[rig]\nname = "x"\n{PIPE}[bus]\npassword = "{WORD}"\n', "rig.toml")
    assert WORD not in str(refused.value)


def test_the_examples_say_which_lines_of_the_bus_go_with_them() -> None:
    """And those lines are a configuration."""
    for file in EXAMPLES.glob("*.json5"):
        head = [
            line[3:].strip() for line in file.read_text(encoding="utf-8").splitlines() if line[:2] == "//"
        ]
        if "[bus]" not in head:
            continue
        lines = "\n".join(line for line in head[head.index("[bus]") :] if " = " in line or line == "[bus]")
        bus = loads(f'[rig]\nname = "x"\n{PIPE}{lines}\n', file.name).bus
        for named in (bus.zenoh_config, bus.client_zenoh_config):
            assert named is not None
            assert (EXAMPLES / named.name).is_file()


def test_the_script_says_how_it_is_used() -> None:
    done = subprocess.run([EXAMPLES / "make-authority.sh"], capture_output=True, text=True, check=False)
    assert (done.returncode, os.linesep in done.stderr) == (2, True)
    assert "FOLDER [HOST ...]" in done.stderr


def test_the_script_tells_what_openssl_refuses_and_leaves_no_half_of_it(tmp_path: Path) -> None:
    def made(*words: str) -> "subprocess.CompletedProcess[str]":
        command = [f"{EXAMPLES / 'make-authority.sh'}", f"{tmp_path}", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    refused = made("IP:9.9.9.9")
    assert refused.returncode == 1
    assert "bad ip address" in refused.stderr
    assert not (tmp_path / "daemon.pem").exists()
    (tmp_path / "viewer.pem").touch()  # of no bytes, as a full disk leaves it
    assert made().returncode == 0
    assert "BEGIN CERTIFICATE" in (tmp_path / "viewer.pem").read_text()
    assert not list(tmp_path.glob(".made*"))
