# SPDX-License-Identifier: Apache-2.0
"""The findings of the parts, in the shape of `results.json`, the source of the printed text and the page."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from typing import Any, TypedDict

from lf_evaluate.measured import Measured, rounds
from lf_west.errors import LfError

# The version of results.json; it changes when older files cannot be read any more.
FORMAT = 1


class _Value(TypedDict):
    value: float
    # The number of digits after the point.
    digits: int


class Number(_Value, total=False):
    """The round that counts, and all rounds where there were several."""

    rounds: list[float]


Cell = str | Number


class Table(TypedDict):
    """Cells below headings."""

    title: str
    headings: list[str]
    rows: list[list[Cell]]


# One of our numbers beside another one.
Comparison = TypedDict(
    "Comparison",
    {"what": str, "unit": str, "less_is_better": bool, "ours": Cell, "with": str, "theirs": Cell},
)


class Figure(TypedDict):
    """A drawing as data: `plot` has one key, which is `rows`, `curves` or `stacked`."""

    title: str
    # The part of the thesis beside it, such as "figure 6.6".
    thesis: str
    caption: str
    plot: dict[str, Any]


class Finding(TypedDict):
    """The finding of one part."""

    title: str
    question: str
    method: list[str]
    compared: list[Comparison]
    tables: list[Table]
    figures: list[Figure]
    # The comparisons that are impossible, and why.
    limits: list[str]


Pick = Callable[[Sequence[float]], float]


def best(unit: str) -> Pick:
    """Rates are to be large, everything else is to be small."""
    return max if unit in ("messages/s", "grants/s") else min


def number(value: float, all_rounds: Sequence[float] = (), digits: int | None = None) -> Number:
    """A cell; three digits of the least round count unless their number is given, and none behind whole numbers."""
    if digits is None:
        sizes = [abs(it) for it in (value, *all_rounds)]
        digits = 0 if all(map(float.is_integer, map(float, sizes))) else max(0, 3 - len(str(int(min(sizes)))))
    return Number(value=value, digits=digits, rounds=list(all_rounds))


def of_rounds(values: Sequence[float], pick: Pick) -> Cell:
    """The round that counts; nothing where there is none."""
    return number(pick(values), values) if values else ""


def _extremes(cell: Number) -> tuple[float, float]:
    rounds = [*cell.get("rounds", ()), cell["value"]]
    return min(rounds), max(rounds)


def shown(value: float, digits: int) -> str:
    """A number as people read it."""
    return f"{value:,.{digits}f}"


def value_of(cell: Cell) -> str:
    """A cell without the range of its rounds."""
    return cell if isinstance(cell, str) else shown(cell["value"], cell["digits"])


def range_of(cell: Cell) -> str:
    """The range of the rounds; nothing where they are the same."""
    if isinstance(cell, str):
        return ""
    least, greatest = (shown(value, cell["digits"]) for value in _extremes(cell))
    return "" if least == greatest else f"{least}–{greatest}"


def verdict(comparison: Comparison) -> tuple[str, str]:
    """Return whether ours is better, worse or equal, and in words; nothing if a number is missing.

    Values that differ by less than a tenth, or by less than rounds do, count as equal.
    """
    ours, theirs = comparison["ours"], comparison["theirs"]
    if isinstance(ours, str) or isinstance(theirs, str) or not ours["value"] or not theirs["value"]:
        return "", ""
    (least, greatest), (their_least, their_greatest) = _extremes(ours), _extremes(theirs)
    if least <= their_greatest and their_least <= greatest:
        return "equal", "within the spread"
    ratio = ours["value"] / theirs["value"]
    factor = 1 / ratio if comparison["less_is_better"] else ratio
    if 1 / 1.1 < factor < 1.1:
        return "equal", "about equal"
    word, times = ("better", factor) if factor > 1 else ("worse", 1 / factor)
    return word, f"{'over 10,000' if times > 10_000 else f'{times:.3g}'} × {word}"


def tabulate(measured: Iterable[Measured], first: str = "", pick: Pick | None = None, title: str = "") -> Table:
    """A line for each row, a column for each owner and unit; the best round counts unless `pick` says otherwise."""
    measured = list(measured)
    values = rounds(measured)
    errors: dict[tuple[str, str], Cell] = {(one.row, one.who): one.error for one in measured if one.error}
    columns = dict.fromkeys((who, unit) for _, who, unit in values)
    columns |= dict.fromkeys((who, "") for _, who in errors if all(who != measured_who for measured_who, _ in columns))

    def cell(row: str, who: str, unit: str) -> Cell:
        # An error takes the place of the first value.
        return errors.pop((row, who), "") or of_rounds(values.get((row, who, unit), []), pick or best(unit))

    rows = [[row, *(cell(row, *column) for column in columns)] for row in dict.fromkeys(one.row for one in measured)]
    return Table(title=title, headings=[first, *(": ".join(filter(None, column)) for column in columns)], rows=rows)


def compare(
    measured: Iterable[Measured], ours: Collection[str], units: Collection[str], pick: Pick | None = None
) -> list[Comparison]:
    """Each of ours beside each other owner, where both have a value in the same row and one of these units."""
    cells = {key: of_rounds(values, pick or best(key[2])) for key, values in rounds(measured, units).items()}
    return [
        compared(", ".join(filter(None, [row, who, unit.rpartition(" ")[0]])), unit.split()[-1], cell, whose, theirs)
        for (row, who, unit), cell in cells.items()
        if who in ours
        for (their_row, whose, their_unit), theirs in cells.items()
        if (their_row, their_unit) == (row, unit) and whose not in ours
    ]


def compared(what: str, unit: str, ours: Cell, whose: str, theirs: Cell) -> Comparison:
    """One of our numbers beside another one."""
    return {
        "what": what, "unit": unit, "less_is_better": best(unit) is min, "ours": ours, "with": whose, "theirs": theirs
    }  # fmt: skip


def finding(
    title: str,
    question: str,
    method: Sequence[str],
    measured: Iterable[Measured] = (),
    ours: Collection[str] = (),
    units: Collection[str] = (),
    first: str = "",
    pick: Pick | None = None,
    figures: Iterable[Figure] = (),
    limits: Sequence[str] = (),
) -> Finding:
    """A finding with a table of all that was measured, and ours beside the others in these units."""
    measured = list(measured)
    return Finding(
        title=title,
        question=question,
        method=list(method),
        compared=compare(measured, ours, units, pick),
        tables=[tabulate(measured, first, pick)] if measured else [],
        figures=list(figures),
        limits=list(limits),
    )


def table_text(table: Table) -> str:
    """A table in Markdown, whose columns are aligned."""
    rows = [table["headings"], *([_words(cell) for cell in row] for row in table["rows"])]
    widths = [max(len(row[column]) for row in rows) for column in range(len(table["headings"]))]
    lines = ["| " + " | ".join(map(str.ljust, row, widths)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(([table["title"], ""] if table["title"] else []) + lines)


def _words(cell: Cell) -> str:
    spread = range_of(cell)
    return f"{value_of(cell)} ({spread})" if spread else value_of(cell)


def finding_text(finding: Finding) -> str:
    """Return the text of a finding."""
    comparisons: list[list[Cell]] = [
        [one["what"], one["unit"], value_of(one["ours"]), value_of(one["theirs"]), one["with"], verdict(one)[1]]
        for one in finding["compared"]
    ]
    headings = ["compared", "unit", "ours", "theirs", "whose", "ours is"]
    tables = [*finding["tables"], Table(title="", headings=headings, rows=comparisons)]
    texts = ["\n" + table_text(table) + "\n" for table in tables if table["rows"]]
    return "\n".join(["", finding["title"], *finding["method"], *texts, *finding["limits"]])


def load(file: Path) -> dict[str, Any]:
    """Results that were written before, also by older versions."""
    try:
        results = json.loads(file.read_text(encoding="utf-8"))
        version = results["format"]
    except OSError as error:
        raise LfError(f"--from {file}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise LfError(f"--from {file}: {error!r}; give a results.json that --report has written") from error
    if version != FORMAT:
        raise LfError(f"--from {file}: it has format {version}, and this program reads {FORMAT}")
    return dict(results)
