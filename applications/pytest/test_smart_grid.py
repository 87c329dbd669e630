# SPDX-License-Identifier: Apache-2.0
"""The smart grid, with all its units on boards."""

from __future__ import annotations

import re
from collections.abc import Callable


def test_the_grid_heals_itself(run: Callable[[str], str]) -> None:
    output = run("smart_grid/src/SmartGrid.lf")
    units = re.findall(r"^\w +\| ([A-D]): (open|closed), reaction time [0-9.]+ ms$", output, re.MULTILINE)
    assert dict(units) == {"A": "closed", "B": "open", "C": "open", "D": "closed"}
