# SPDX-License-Identifier: Apache-2.0
"""The thermostat on a board, with the display on this computer."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest


def test_the_fan_cools_the_room_as_far_as_the_knob_says(run: Callable[..., str]) -> None:
    output = run("thermostat/src/Thermostat.lf", "--deployment", "deployment/native_sim.yaml")
    shown = re.findall(r"^display +\| ([\d.]+) °C, ([\d.]+) °C wanted, fan at (\d+) %$", output, re.MULTILINE)
    assert len(shown) == 6
    rooms = [float(room) for room, _, _ in shown]
    assert rooms == sorted(rooms, reverse=True)
    assert rooms[0] > 23
    for room, wanted, fan_percent in shown:
        assert float(wanted) == pytest.approx(20, abs=0.1)
        # The display rounds the temperature that was wanted.
        assert int(fan_percent) == pytest.approx(min(25 * (float(room) - float(wanted)), 100), abs=2)
