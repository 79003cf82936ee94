"""Write the paper's figures, the table of values and the page into a folder."""

from collections.abc import Callable, Iterable
from pathlib import Path

from vsensor.paper import figures, story
from vsensor.paper.figures.style import Picture, rendered, rules
from vsensor.paper.page import Shown, page
from vsensor.paper.results import Results
from vsensor.paper.values import values, write_csv

PAGE = "paper.html"
TABLE = "values.csv"

Draw = Callable[[Results], Picture]
Watch = Callable[[Iterable[Draw]], Iterable[Draw]]


def publish(results: Results, folder: Path, watch: Watch = iter) -> Path:
    """Write NAME.png and NAME.svg of every figure, values.csv and paper.html; returns the page's path.

    `watch` is handed the figures to draw and yields them, so that a caller can show how far it is.
    OSError where the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shown = {}
    for draw in watch(figures.ALL):
        with rules():
            picture = draw(results)
        png, svg = rendered(picture)
        (folder / f"{picture.name}.png").write_bytes(png)
        (folder / f"{picture.name}.svg").write_bytes(svg)
        shown[picture.name] = Shown(svg, picture.caption, picture.alt)
    rows = values(results)
    write_csv(folder / TABLE, rows)
    html = page(story.TITLE, story.LEAD, story.sections(results, rows), shown)
    (folder / PAGE).write_text(html, encoding="utf-8")
    return folder / PAGE
