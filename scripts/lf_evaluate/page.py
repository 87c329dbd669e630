# SPDX-License-Identifier: Apache-2.0
"""The results as one page that needs nothing else: no script, no font and no image from anywhere.

It is made of results.json alone. The libraries for it are needed only where a report is asked for.
"""

from __future__ import annotations

import io
import shlex
from importlib.util import find_spec
from itertools import accumulate
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from lf_evaluate import results
from lf_west.errors import LfError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LIBRARIES = {"matplotlib": "matplotlib", "jinja2": "Jinja2"}
_COLOURS = {"ours": "#1f60a9", "ours_too": "#2a9084", "stock": "#c26b17", "raw": "#767d86", "thesis": "#b32655"}
_PARTS = ("#9aa3ad", "#c8ced5", "#1f5fa8", "#2a8f83", "#c26a16", "#7a4ea3", "#b23a5e", "#6c8e34", "#546e90")


def require_libraries() -> None:
    """Ends with what to install, before anything is measured, when the page could not be made."""
    missing = [package for module, package in _LIBRARIES.items() if find_spec(module) is None]
    if missing:
        install = f"python3 -m pip install {' '.join(missing)}"
        raise LfError(f"a report needs {' and '.join(missing)}, which Python does not find here.", install)


def render(measured: dict[str, Any]) -> str:
    """The page of some results."""
    import jinja2
    from markupsafe import Markup

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    template = environment.from_string(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    try:
        page: str = template.render(
            results=measured,
            value_of=results.value_of,
            range_of=results.range_of,
            verdict=results.verdict,
            command=shlex.join(["cargo", "xtask", "evaluate", *measured["arguments"]]),
            draw=lambda figure: Markup(draw(figure)),
        )
    except (jinja2.TemplateError, LookupError, TypeError, ValueError) as error:
        raise LfError(f"these results are not whole, so there is no page of them: {error!r}") from error
    return page


def draw(figure: results.Figure) -> str:
    """A drawing alone, as SVG, whose texts are texts."""
    import matplotlib
    from matplotlib.figure import Figure

    ((kind, plot),) = figure["plot"].items()
    lines = max(len(plot.get(lines, ())) for lines in ("rows", "bars", "parts")) + 1.5 * len(plot.get("marks", ()))
    # Names of things are taken literally, and not as formulas.
    style = {"svg.fonttype": "none", "font.family": "sans-serif", "text.parse_math": False, "svg.hashsalt": "lf"}
    with matplotlib.rc_context(style):
        canvas = Figure(figsize=(9, 4 if kind == "curves" else 1.6 + 0.3 * lines), layout="constrained")
        axes = canvas.subplots()
        {"rows": _rows, "curves": _curves, "stacked": _stacked}[kind](axes, plot)
        for mark in plot.get("marks", ()):
            axes.axvline(mark["at"], color=_COLOURS[mark["who"]], linestyle="--", label=mark["label"])
        axes.grid(axis="both" if kind == "curves" else "x", color="#dde1e6")
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        if axes.get_legend_handles_labels()[0]:
            canvas.legend(loc=f"outside {'lower' if kind == 'rows' else 'right'} center", frameon=False)
        text = io.StringIO()
        canvas.savefig(text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    drawing = text.getvalue()
    return drawing[drawing.index("<svg") :]


def _scale(axes: Axes, name: str, axis: dict[str, Any], values: list[float]) -> None:
    """Describes an axis, whose steps are plain numbers."""
    from matplotlib import ticker

    axes.set(**{f"{name}label": axis["label"]})
    drawn = axes.xaxis if name == "x" else axes.yaxis
    if axis["is_logarithmic"] and any(value > 0 for value in values):
        axes.set(**{f"{name}scale": "log"})
        drawn.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        drawn.set_minor_locator(ticker.NullLocator())
    drawn.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:,.10g}"))


def _rows(axes: Axes, plot: dict[str, Any]) -> None:
    rows = plot["rows"]
    for place, row in enumerate(rows):
        values, colour = row["values"], _COLOURS[row["who"]]
        axes.plot(values, [place] * len(values), "o", color=colour, alpha=0.4, clip_on=False)
        if values:
            axes.plot([median(values)], [place], "|", color=colour, markersize=18, markeredgewidth=2.5)
    labels = [row["label"] + ("" if row["values"] else " (none)") for row in rows]
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    _scale(axes, "x", plot["axis"], [value for row in rows for value in row["values"]])


def _curves(axes: Axes, plot: dict[str, Any]) -> None:
    styles = {"solid": "-", "dashed": "--", "points": "o"}
    # Two of one owner are told apart by their lines.
    seen: set[tuple[str, str]] = set()
    for curve in plot["curves"]:
        style = styles[curve["line"]]
        style = "--" if style == "-" and (curve["who"], style) in seen else style
        seen.add((curve["who"], style))
        across, up = [point[0] for point in curve["points"]], [point[1] for point in curve["points"]]
        axes.plot(across, up, style, color=_COLOURS[curve["who"]], label=curve["label"], markersize=4)
    points = [point for curve in plot["curves"] for point in curve["points"]]
    _scale(axes, "x", plot["x"], [point[0] for point in points])
    _scale(axes, "y", plot["y"], [point[1] for point in points])


def _stacked(axes: Axes, plot: dict[str, Any]) -> None:
    names = [name for name, _ in plot["bars"]]
    for index, part in enumerate(plot["parts"]):
        starts = [sum(values[:index]) for _, values in plot["bars"]]
        widths = [values[index] for _, values in plot["bars"]]
        bars = axes.barh(range(len(names)), widths, left=starts, label=part, color=_PARTS[index % len(_PARTS)])
        # A part that is wide enough has its number in it.
        total = max((sum(values) for _, values in plot["bars"]), default=0)
        axes.bar_label(bars, [f"{width:.1f}" if width > total / 15 else "" for width in widths], label_type="center")
    for place, (_, values) in enumerate(plot["bars"]):
        axes.text([*accumulate(values)][-1], place, f" {sum(values):.1f}", va="center", weight="bold")
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    _scale(axes, "x", plot["axis"], [])
