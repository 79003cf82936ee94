"""`vsensor paper`: what stands in the folder, and that the page needs nothing else."""

import csv
import re
import sys
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vsensor.cli.main import app
from vsensor.cli.paper import paper
from vsensor.errors import VsensorError
from vsensor.paper import figures
from vsensor.paper.page import Section, Table, number, page


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("paper") / "new" / "folder"
    result = CliRunner().invoke(app, ["paper", "-o", str(made)])
    assert result.exit_code == 0, result.output
    assert str(made / "paper.html") in result.output.replace("\n", "")
    return made


def test_every_figure_is_there_as_png_and_svg(folder: Path) -> None:
    pngs, svgs = sorted(folder.glob("*.png")), sorted(folder.glob("*.svg"))
    assert len(pngs) == len(svgs) == len(figures.ALL)
    assert {png.stem[:5] for png in pngs} >= {"fig02", "fig04", "fig05", "fig06", "fig08", "fig09", "fig10"}
    for png, svg in zip(pngs, svgs, strict=True):
        assert png.stem == svg.stem
        assert png.read_bytes().startswith(b"\x89PNG\r\n")
        assert ET.parse(svg).getroot().tag.endswith("svg")  # noqa: S314


class Reader(HTMLParser):
    """Gathers what a page refers to, and whether every tag is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.refers: list[str] = []
        self.alts: list[str] = []
        self.ids: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.refers += [given[name] or "" for name in ("src", "href") if name in given]
        self.ids += [str(given["id"])] if "id" in given else []
        if tag == "img":
            self.alts.append(given["alt"] or "")
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_holds_every_figure_and_asks_nobody(folder: Path) -> None:
    html = (folder / "paper.html").read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(html)
    assert not reader.open
    images = [at for at in reader.refers if not at.startswith("#")]
    assert len(images) == len(figures.ALL)
    assert all(at.startswith("data:image/svg+xml;base64,") for at in images)
    assert all(len(alt) > 20 for alt in reader.alts)
    assert {at[1:] for at in reader.refers if at.startswith("#")} == set(reader.ids)
    assert not re.search(r"url\(|@import|<script|https?://", html)


def test_the_table_holds_what_the_paper_has_and_what_is_right(folder: Path) -> None:
    with (folder / "values.csv").open(newline="", encoding="utf-8") as file:
        rows = {(row["topic"], row["quantity"]): row for row in csv.DictReader(file)}
    trip = rows["shaft", "round trip T_p"]
    assert float(trip["value"]) == pytest.approx(2.537597, rel=1e-6)
    assert float(trip["expected"]) == 2.536
    steady = rows["eq. (24), (25), J_L = 2500 kg·m²", "steady speed, T₀/D_L"]
    assert float(steady["value"]) == 17.5
    assert float(rows["rms error, 8000 m", "bit, fine"]["value"]) < 1e-6
    assert rows["shaft", "impedance ζ"]["expected"] == ""
    assert len({unit for row in rows.values() if (unit := row["unit"])}) > 8


def test_the_page_tells_the_numbers_of_the_table(folder: Path) -> None:
    html = (folder / "paper.html").read_text(encoding="utf-8")
    assert "20,672 rad/s" in html
    assert "<td>polar second moment J</td><td>m⁴</td>" in html
    assert '<td class="number">2.90311·10⁻⁵</td>' in html


def test_an_output_that_is_a_file_is_wrong_use(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    assert CliRunner().invoke(app, ["paper", "-o", str(file)]).exit_code == 2


def test_an_output_that_cannot_be_written_says_so(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    result = CliRunner().invoke(app, ["paper", "-o", str(file / "under")])
    assert result.exit_code == 1
    assert f"{file / 'under'}: cannot be written" in result.output.replace("\n", "")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (17.5, "17.5"),
        (-27.3, "−27"),
        (5.37e-5, "5.4·10⁻⁵"),
        (0.0, "0"),
        (2.2e7, "2.2·10⁷"),
        (-1e-9, "−1·10⁻⁹"),
    ],
)
def test_numbers_as_people_write_them(value: float, words: str) -> None:
    assert number(value, 3 if value == 17.5 else 2) == words


def test_text_in_tables_and_titles_is_not_taken_for_html() -> None:
    table = Table("a < b", ("x & y", "n"), [("<b>", 1.0), (None, 2.0)])
    html = page("R < L", "lead", [Section("S & T", ("text", table))], {})
    assert "<title>R &lt; L</title>" in html
    assert "a &lt; b" in html
    assert "<td>&lt;b&gt;</td>" in html
    assert '<td class="number">1</td>' in html
    assert "S &amp; T" in html


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in [name for name in sys.modules if name.startswith("vsensor.paper")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(VsensorError, match=r"needs matplotlib, an extra: pip install 'vsensor\[paper\]'"):
        paper(tmp_path)
