# SPDX-License-Identifier: Apache-2.0
"""Single values as `lf-bench` prints them, one in a line of JSON; parts that run applications make the same."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from lf_west.errors import LfError


@dataclass(frozen=True)
class Measured:
    """One value of one round. Rounds of the same row, owner and unit belong together."""

    row: str
    who: str
    unit: str
    value: float | None = None
    # The values from which this one was computed.
    samples: tuple[float, ...] = ()
    error: str = ""


def read(text: str) -> list[Measured]:
    """Parse the output of `lf-bench`."""
    try:
        return [
            Measured(
                it["row"], it["who"], it["unit"], it.get("value"), tuple(it.get("samples", ())), it.get("error", "")
            )
            for it in map(json.loads, text.splitlines())
        ]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LfError(f"lf-bench printed what is no measurement: {error!r}") from error


# A row, an owner, and what measures it once.
Run = tuple[str, str, Callable[[], list[Measured]]]


def in_turns(count: int, runs: Sequence[Run], must_succeed: Collection[str] = ()) -> list[Measured]:
    """Run all of them this many times, in turns. One that has failed is a finding, and not tried again; a failure of
    these owners is an error.
    """
    seen: list[Measured] = []
    failed: set[tuple[str, str]] = set()
    for _ in range(count):
        for row, who, run in runs:
            if (row, who) not in failed:
                try:
                    seen += run()
                except LfError as error:
                    if who in must_succeed:
                        raise
                    failed.add((row, who))
                    seen.append(Measured(row, who, "", error=telling_line(error)))
    return seen


def telling_line(error: LfError) -> str:
    """Return the line of an error that says most: the first that names an error, or else the first one."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    telling = next((line for line in lines if re.search(r"\b(?:error|fatal)\b *[\[:]", line)), lines[0])
    return re.sub(r"^.*?(?=\berror\b)", "", telling)[:120]


def no_result_in(output: str) -> LfError:
    """Return the error for a program that has not printed its result."""
    return LfError(f"there is no result in what was printed:\n{output}")


def percentile(samples: Sequence[float], percent: int) -> float:
    """The sample that this percentage of all samples do not exceed; there has to be one."""
    return sorted(samples)[max(math.ceil(len(samples) * percent / 100), 1) - 1]


def spread_out(measured: Iterable[Measured], percents: dict[str, int]) -> list[Measured]:
    """For each measurement with samples one of each of these percentiles, whose name stands before the unit."""
    return [
        replace(one, unit=f"{name} {one.unit}", value=percentile(one.samples, percent), samples=())
        for one in measured
        if one.samples
        for name, percent in percents.items()
    ]


def rounds(measured: Iterable[Measured], units: Collection[str] = ()) -> dict[tuple[str, str, str], list[float]]:
    """The values of all rounds, by row, owner and unit; of these units where some are named."""
    found: dict[tuple[str, str, str], list[float]] = {}
    for one in measured:
        if one.value is not None and (not units or one.unit in units):
            found.setdefault((one.row, one.who, one.unit), []).append(one.value)
    return found
