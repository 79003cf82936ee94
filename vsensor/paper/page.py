"""The page: one HTML file that needs nothing beside it, and asks nobody for anything."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import NamedTuple

_STYLE = """
:root { color-scheme: light; --ink: #1c1c1c; --quiet: #5c5c5c; --line: #dcdcdc; --shade: #f5f6f7; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2.5rem 1.25rem 5rem; max-width: 60rem; color: var(--ink); background: #fff;
  font: 1.05rem/1.6 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.35rem; margin: 3.2rem 0 .6rem; padding-top: 1.2rem; border-top: 1px solid var(--line); }
p, li { max-width: 46rem; }
.lead { color: var(--quiet); }
nav { margin: 1.5rem 0; padding: .9rem 1.2rem; background: var(--shade); border-radius: .5rem;
  columns: 2; font-size: .95rem; }
nav a { display: block; color: inherit; text-decoration: none; }
nav a:hover { text-decoration: underline; }
pre { margin: 1.2rem 0; padding: .9rem 1.2rem; overflow-x: auto; background: var(--shade);
  border-radius: .5rem; font: .9rem/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }
figure { margin: 1.8rem 0; }
figure img { width: 100%; height: auto; }
figcaption { max-width: 46rem; color: var(--quiet); font-size: .95rem; }
.wide { overflow-x: auto; margin: 1.5rem 0; }
table { border-collapse: collapse; font-size: .92rem; line-height: 1.4; }
caption { text-align: left; padding-bottom: .4rem; color: var(--quiet); }
th, td { padding: .35rem .8rem .35rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number { white-space: nowrap; }
@media (max-width: 40rem) { nav { columns: 1; } }
"""


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Shown(NamedTuple):
    """A figure as it stands on the page."""

    svg: bytes
    caption: str
    alt: str


class Table(NamedTuple):
    """A table; a cell that is a number stands on the right, in `digits` significant digits."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]
    digits: int = 4


class Section(NamedTuple):
    """A headed part of the page; text in its body is HTML, a paragraph unless it begins with a tag."""

    title: str
    body: tuple["str | Table | Figure", ...]


class Figure(NamedTuple):
    """The place of a figure, by its name."""

    name: str


def page(title: str, lead: str, sections: Sequence[Section], figures: Mapping[str, Shown]) -> str:
    """The whole page as HTML, the figures inside it."""
    links = "".join(
        f'<a href="#part-{number}">{escape(section.title)}</a>' for number, section in enumerate(sections, 1)
    )
    parts = "\n".join(
        f'<h2 id="part-{number}">{escape(section.title)}</h2>\n{_body(section.body, figures)}'
        for number, section in enumerate(sections, 1)
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f'<h1>{escape(title)}</h1>\n<p class="lead">{lead}</p>\n<nav>{links}</nav>\n'
        f"{parts}\n</body>\n</html>\n"
    )


def _body(body: Iterable[str | Table | Figure], figures: Mapping[str, Shown]) -> str:
    return "\n".join(_block(block, figures) for block in body)


def _block(block: str | Table | Figure, figures: Mapping[str, Shown]) -> str:
    if isinstance(block, Table):
        return _table(block)
    if isinstance(block, Figure):
        return _figure(figures[block.name])
    return block if block.startswith("<") else f"<p>{block}</p>"


def _figure(shown: Shown) -> str:
    data = b64encode(shown.svg).decode()
    return (
        f'<figure><img alt="{escape(shown.alt)}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{escape(shown.caption)}</figcaption></figure>"
    )


def _table(table: Table) -> str:
    numeric = [any(isinstance(row[i], float) for row in table.rows) for i in range(len(table.head))]
    head = "".join(_cell("th", words, right=right) for words, right in zip(table.head, numeric, strict=True))
    rows = "".join(
        "<tr>"
        + "".join(
            _cell("td", _words(value, table.digits), right=right)
            for value, right in zip(row, numeric, strict=True)
        )
        + "</tr>\n"
        for row in table.rows
    )
    return (
        f'<div class="wide"><table><caption>{escape(table.caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>"
    )


def _cell(tag: str, words: str, *, right: bool) -> str:
    return f'<{tag} class="number">{escape(words)}</{tag}>' if right else f"<{tag}>{escape(words)}</{tag}>"


def _words(value: str | float | None, digits: int) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else number(value, digits)


def number(value: float, digits: int) -> str:
    """A number in so many significant digits as people write it: 17.5, −27, 5.4·10⁻⁵."""
    words = f"{value:.{digits}g}"
    mantissa, _, power = words.replace("-", "−").partition("e")
    return mantissa + (f"·10{str(int(power.replace('−', '-'))).translate(_RAISED)}" if power else "")
