# SPDX-License-Identifier: Apache-2.0
"""The button and the lamp, on boards of their own: a script presses the one, and an oscilloscope is at both."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[1] / "button_and_lamp/src/presses.txt"


def changes(vcd: str, pin: str) -> list[tuple[int, str]]:
    """When a pin has changed, in nanoseconds, and to what."""
    found = re.search(rf"^\$var wire 1 (\S+) {pin} \$end$", vcd, re.MULTILINE)
    assert found is not None
    now, level, result = 0, "0", []
    for line in vcd.splitlines():
        if line.startswith("#"):
            now = int(line[1:])
        elif line[1:] == found[1] and line[0] != level:
            level = line[0]
            result.append((now, level))
    return result


def test_each_press_changes_the_lamp(run: Callable[..., str], tmp_path: Path) -> None:
    file = tmp_path / "pins.vcd"
    output = run("button_and_lamp/src/ButtonAndLamp.lf", "--devices", str(SCRIPT), "--vcd", str(file))
    presses = re.findall(r"^button +\| press (\d) at \d+ ms$", output, re.MULTILINE)
    told = re.findall(r"^lamp +\| the lamp is (on|off)$", output, re.MULTILINE)
    assert presses == ["1", "2", "3", "4", "5", "6"]
    assert told == ["on", "off", "on", "off", "on", "off"]

    recorded = file.read_text(encoding="utf-8")
    button, lamp = changes(recorded, "sw0"), changes(recorded, "led0")
    # The contact bounces: two edges of the script's make a press.
    assert [level for _, level in button[:4]] == ["1", "0", "1", "0"]
    assert [level for _, level in lamp] == ["1", "0", "1", "0", "1", "0"]
    # Both are on one clock, so no change of the lamp is before the first press.
    assert lamp[0][0] > button[0][0]
