# SPDX-License-Identifier: Apache-2.0
"""Images for the board of the thesis: built, and looked into.

The files of tests run in the order of their names. Building for this board takes longest, so it comes last.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import BUILD
from test_zephyr import ALLOCATOR, PROGRAMS, _arm, lf, symbols

__all__ = ["_arm"]

pytestmark = pytest.mark.zephyr


@pytest.mark.usefixtures("_arm")
def test_images_are_built_for_the_board_of_the_thesis() -> None:
    """They have what the applications use of it: devices, clock synchronization over UDP, an RTI."""
    build = BUILD / "evk"
    board = "mimxrt1170_evk@B/mimxrt1176/cm7"
    thermostat = ["-f", "thermostat", "--deployment", "deployment/board.yaml"]
    joint = ["-f", "a", "--deployment", str(PROGRAMS / "smart_grid_evk.yaml")]
    commands = [
        ["lf-fed-build", "clock_sync/src/ClockSync.lf", "-f", "board", "-w", f"-b {board}"],
        ["lf-fed-build", "thermostat/src/Thermostat.lf", *thermostat],
        ["lf-fed-build", "smart_grid/src/SmartGrid.lf", *joint],
    ]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        assert all(pool.map(lambda command: lf(*command, build=build), commands))
    linked = {
        "ClockSync/board": {"lf_main"},
        "Thermostat/thermostat": {"lf_main", "lf_i2c_transfer", "lf_adc_sample", "lf_pwm_set_pulse"},
        "SmartGrid/a": {"lf_main", "lf_rti_main"},
    }
    for image, entries in linked.items():
        names = set(symbols(build / "zephyr" / image))
        assert entries <= names, image
        assert [name for name in names if ALLOCATOR.fullmatch(name)] == [], image
