# SPDX-License-Identifier: Apache-2.0
"""The table at the end of a build."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west.memory import Memory

_TITLES = ("federate", "board", "flash", "RAM", "image")
_UNKNOWN = "–"


@dataclass(frozen=True)
class Row:
    """One federate that was built."""

    name: str
    # "host" for a program of this computer.
    board: str
    memory: Memory | None
    image: Path | None


def table(rows: Sequence[Row]) -> str:
    """The rows in columns, sizes in KiB."""
    lines = [_TITLES, *(_texts(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(_TITLES))]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def _texts(row: Row) -> tuple[str, str, str, str, str]:
    flash = _UNKNOWN if row.memory is None else _kib(row.memory.flash)
    ram = _UNKNOWN if row.memory is None else _kib(row.memory.ram)
    return row.name, row.board, flash, ram, _UNKNOWN if row.image is None else str(row.image)


def _kib(size: int) -> str:
    return f"{size / 1024:.1f} KiB"
