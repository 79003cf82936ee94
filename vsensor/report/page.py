"""The page: one HTML file that needs nothing beside it and asks nobody for anything; it prints on A4."""

import json
from collections.abc import Mapping, Sequence
from html import escape

from plotly.offline import get_plotlyjs

from vsensor.report.plots import Plot
from vsensor.report.words import Key

_STYLE = """
:root { color-scheme: light; --ink: #1c1c1c; --quiet: #5c5c5c; --line: #dcdcdc; --shade: #f5f6f7;
  --grave: #D55E00; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1.25rem 4rem; max-width: 66rem; color: var(--ink); background: #fff;
  font: 1rem/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
header p { margin: 0; color: var(--quiet); }
h1 { font-size: 1.55rem; line-height: 1.3; margin: .3rem 0 .6rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .2rem; padding-top: .9rem; border-top: 1px solid var(--line); }
.said { font-size: 1.05rem; margin: 0 0 1rem; }
.note { color: var(--quiet); font-size: .92rem; margin: .1rem 0 .3rem; max-width: 54rem; }
.keys { display: grid; grid-template-columns: repeat(5, 1fr); gap: .6rem; margin: 1rem 0; }
.key { background: var(--shade); border-radius: .45rem; padding: .55rem .7rem;
  border-left: .25rem solid #bbb; }
.key.grave { border-color: var(--grave); }
.key b { display: block; font-size: 1.2rem; line-height: 1.25; font-variant-numeric: tabular-nums; }
.key.grave b { color: var(--grave); }
.key span { display: block; font-size: .82rem; color: var(--quiet); }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 24px; }
.pair > * { min-width: 0; }
table { border-collapse: collapse; font-size: .92rem; margin: .5rem 0; }
td, th { padding: .25rem 1rem .25rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
pre { background: var(--shade); padding: .8rem 1rem; border-radius: .45rem; overflow-x: auto;
  font: .8rem/1.45 ui-monospace, "DejaVu Sans Mono", monospace; }
summary { cursor: pointer; }
@media screen and (max-width: 50rem) {
  .keys { grid-template-columns: 1fr 1fr; } .pair { grid-template-columns: 1fr; }
}
@page { size: A4; margin: 12mm; }
@media print {
  body { padding: 0; max-width: none; width: 1056px; zoom: .66; }
  section { break-inside: avoid; } section.long { break-inside: auto; }
  pre { white-space: pre-wrap; } .modebar { display: none; }
}
"""

_DRAW = """
for (const [name, plot] of Object.entries(JSON.parse(document.getElementById("plots").textContent)))
  Plotly.newPlot(name, plot.data, {...plot.layout, height: plot.height},
    {responsive: true, displaylogo: false, displayModeBar: "hover",
     modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"]});
const drawn = document.querySelectorAll(".plot.js-plotly-plot");
addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach(d => d.open = true);
  // On paper a plot is as wide as the page, not as the window in which it was drawn.
  drawn.forEach(plot => Plotly.relayout(plot, {width: plot.closest(".pair") ? (1056 - 24) / 2 : 1056}));
});
addEventListener("afterprint", () =>
  drawn.forEach(plot => Plotly.relayout(plot, {width: null, autosize: true})));
"""


def page(
    title: str,
    about: str,
    said: Sequence[str],
    keys: Sequence[Key],
    parts: str,
    plots: Mapping[str, Plot],
) -> str:
    """The whole page; `parts` is HTML in which `place` has left room for the plots."""
    first, *more = said
    sentences = "".join(f'<p class="said">{escape(sentence)}</p>' for sentence in more if sentence)
    cards = "".join(map(_card, keys))
    # «</» would end the script that holds the numbers.
    data = json.dumps(plots, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{escape(title)}</title><style>{_STYLE}</style></head><body>
<header><p>{escape(about)}</p><h1>{escape(first)}</h1>{sentences}</header>
<div class="keys">{cards}</div>
{parts}
<script type="application/json" id="plots">{data}</script>
<script>{get_plotlyjs()}</script>
<script>{_DRAW}</script>
</body></html>
"""


def section(title: str, note: str, body: str, *, long: bool = False) -> str:
    """A headed part of the page, on paper on one sheet unless it is long; `body` is HTML."""
    kind = ' class="long"' if long else ""
    return f'<section{kind}><h2>{escape(title)}</h2><p class="note">{escape(note)}</p>{body}</section>\n'


def place(name: str) -> str:
    """Room for a plot."""
    return f'<div class="plot" id="{name}"></div>'


def pair(left: str, right: str) -> str:
    """Two parts side by side, where there is room."""
    return f'<div class="pair">{left}{right}</div>'


def table(rows: Sequence[tuple[str, str]]) -> str:
    """Names and figures."""
    cells = "".join(f"<tr><td>{escape(name)}</td><td>{escape(told)}</td></tr>" for name, told in rows)
    return f"<table>{cells}</table>"


def folded(title: str, text: str) -> str:
    """Text that is seen when asked for, and printed in any case."""
    return f"<details><summary>{escape(title)}</summary><pre>{escape(text)}</pre></details>"


def _card(key: Key) -> str:
    grave = " grave" if key.grave else ""
    return (
        f'<div class="key{grave}"><span>{escape(key.name)}</span><b>{escape(key.value)}</b>'
        f"<span>{escape(key.beside)}</span></div>"
    )
