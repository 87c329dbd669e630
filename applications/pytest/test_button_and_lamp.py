# SPDX-License-Identifier: Apache-2.0
"""The button and the lamp, on boards of their own."""

from __future__ import annotations

import re
from collections.abc import Callable


def test_each_press_changes_the_lamp(run: Callable[[str], str]) -> None:
    output = run("button_and_lamp/src/ButtonAndLamp.lf")
    presses = re.findall(r"^button +\| press (\d) at \d+ ms$", output, re.MULTILINE)
    changes = re.findall(r"^lamp +\| the lamp is (on|off)$", output, re.MULTILINE)
    assert presses == ["1", "2", "3", "4", "5", "6"]
    assert changes == ["on", "off", "on", "off", "on", "off"]
