# SPDX-License-Identifier: Apache-2.0
"""Drawings as data, apart from how they are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from lf_evaluate.measured import Measured, percentile, rounds
from lf_evaluate.results import Figure

# The owner of each name, which has the owner's colour; all other names are ours.
_OWNERS = {"lfz rti": "ours", "ours": "ours", "decentralized": "ours", "federates": "ours", "Linux": "ours"} | {
    "stock RTI": "stock",
    "stock algorithm": "stock",
    "forwarder, asleep": "raw",
    "forwarder, awake": "raw",
    "raw TCP": "raw",
    "thesis": "thesis",
}


def owner(who: str) -> str:
    """The key of a colour."""
    return _OWNERS.get(who, "ours_too")


def axis(label: str, is_logarithmic: bool = False) -> dict[str, Any]:
    """An axis, whose steps may be multiples."""
    return {"label": label, "is_logarithmic": is_logarithmic}


def mark(label: str, who: str, at: float) -> dict[str, Any]:
    """A value to compare all others with."""
    return {"label": label, "who": owner(who), "at": at}


def dots(
    title: str,
    across: dict[str, Any],
    unit: str,
    measured: Iterable[Measured],
    marks: Sequence[dict[str, Any]] = (),
    thesis: str = "",
    caption: str = "A dot for each round, and the median.",
) -> Figure:
    """A row of dots for all rounds with this unit."""
    rows = [
        {"label": f"{row}, {who}", "who": owner(who), "values": values}
        for (row, who, _), values in rounds(measured, [unit]).items()
    ]
    plot = {"rows": {"axis": across, "rows": rows, "marks": list(marks)}}
    return Figure(title=title, thesis=thesis, caption=caption, plot=plot)


def curve(label: str, who: str, points: Iterable[Sequence[float]], line: str = "solid") -> dict[str, Any]:
    """Points that belong together; the line is `solid`, `dashed` or `points`."""
    return {"label": label, "who": owner(who), "line": line, "points": [list(point) for point in points]}


def curves(
    title: str,
    across: dict[str, Any],
    up: dict[str, Any],
    drawn: Sequence[dict[str, Any]],
    caption: str,
    marks: Sequence[dict[str, Any]] = (),
    thesis: str = "",
) -> Figure:
    """One value over another."""
    plot = {"curves": {"x": across, "y": up, "curves": list(drawn), "marks": list(marks)}}
    return Figure(title=title, thesis=thesis, caption=caption, plot=plot)


def distributions(
    title: str, measured: Iterable[Measured], marks: Sequence[dict[str, Any]] = (), thesis: str = ""
) -> Figure:
    """Return the distribution of each owner's samples: percentages over times in µs."""
    samples: dict[str, list[float]] = {}
    for one in measured:
        samples.setdefault(one.who, []).extend(one.samples)
    # The slowest one of a hundred may be a thousand times slower than the others.
    drawn = [
        curve(who, who, [(percentile(values, percent), percent) for percent in range(100)])
        for who, values in samples.items()
    ]
    caption = "How many of all took at most so long, without the slowest one of a hundred; all rounds together."
    return curves(title, axis("time in µs", True), axis("% of all"), drawn, caption, marks, thesis)


def stacked(title: str, caption: str, unit: str, parts: Sequence[str], bars: dict[str, list[float]]) -> Figure:
    """A bar for each of several things, of the same parts."""
    plot = {"stacked": {"axis": axis(unit), "parts": list(parts), "bars": [[*bar] for bar in bars.items()]}}
    return Figure(title=title, thesis="", caption=caption, plot=plot)
