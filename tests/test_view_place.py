"""Where the view is shown: what was asked for, or the next best thing, and told so."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from vsensor.view.place import Place, ViewError, choose


@pytest.fixture
def taken() -> Iterator[int]:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        yield other.getsockname()[1]


def chosen(said: list[str], **asked: object) -> Place:
    wishes: dict[str, object] = {"web": False, "save": None, "page_port": None, "data_port": None} | asked
    with choose(say=said.append, **wishes) as place:  # type: ignore[arg-type]
        return place


@pytest.mark.parametrize("display", ["DISPLAY", "WAYLAND_DISPLAY"])
def test_with_a_display_a_window_is_opened(monkeypatch: pytest.MonkeyPatch, display: str) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv(display, ":0")
    assert chosen([]).kind == "window"


def test_without_a_display_the_page_is_served_and_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    said: list[str] = []
    assert chosen(said).kind == "page"
    assert "no display" in said[0]


def test_a_file_needs_neither_display_nor_port(tmp_path: Path) -> None:
    assert chosen([], save=tmp_path / "a.rrd") == Place("file", save=tmp_path / "a.rrd")


def test_a_page_and_a_file_go_together(tmp_path: Path) -> None:
    place = chosen([], web=True, save=tmp_path / "a.rrd")
    assert (place.kind, place.save) == ("page", tmp_path / "a.rrd")


def test_a_port_that_was_asked_for_and_is_taken_is_refused_by_name(taken: int) -> None:
    with pytest.raises(ViewError, match=f"--port {taken}"):
        chosen([], web=True, page_port=taken)
    with pytest.raises(ViewError, match=f"--data-port {taken}"):
        chosen([], web=True, data_port=taken)


def test_where_the_usual_port_is_taken_another_is(monkeypatch: pytest.MonkeyPatch, taken: int) -> None:
    monkeypatch.setattr("vsensor.view.place.DATA_PORT", taken)
    place = chosen([], web=True)
    assert place.data_port != taken
    assert place.source == f"rerun+http://127.0.0.1:{place.data_port}/proxy"


def test_two_views_that_start_at_once_take_different_ports() -> None:
    """Neither is served at yet."""
    with choose(web=True, save=None, page_port=None, data_port=None, say=print) as one:
        other = chosen([], web=True)
        assert len({one.data_port, one.page_port, other.data_port, other.page_port}) == 4
        with pytest.raises(ViewError, match=f"--port {one.page_port}"):
            chosen([], web=True, page_port=one.page_port)
    assert chosen([], web=True, page_port=one.page_port).page_port == one.page_port


def test_the_page_is_a_whole_address_on_this_machine_alone() -> None:
    page = Place("page", 9876, 9090).page
    address = "http://127.0.0.1:9090/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A9876%2Fproxy"
    assert page == f"{address}&theme=dark&hide_welcome_screen"


def test_later_recordings_get_files_of_their_own() -> None:
    place = Place("file", save=Path("a/view.rrd"))
    assert [str(place.numbered(count)) for count in (1, 2, 3)] == [
        "a/view.rrd",
        "a/view-2.rrd",
        "a/view-3.rrd",
    ]
    assert Place("page").numbered(2) is None


def test_it_is_served_elsewhere_only_where_told_and_says_so() -> None:
    place = chosen([], web=True, bind="0.0.0.0")  # noqa: S104 -- that is what is tested
    host = socket.gethostname()
    assert place.page.startswith(f"http://{host}:{place.page_port}/?url=rerun%2Bhttp%3A%2F%2F{host}%3A")
    assert place.origins == [f"http://{host}:{place.page_port}"]
    assert "whoever reaches this machine can look on" in place.words()
    assert "whoever" not in chosen([], web=True).words()


@pytest.mark.parametrize("address", ["rig-7", "192.0.2.1", "300.1.1.1"])
def test_an_address_that_is_not_of_this_machine_is_refused_by_name(address: str) -> None:
    with pytest.raises(ViewError, match=f"--bind {address}: is no address of this machine"):
        chosen([], web=True, bind=address)
