# SPDX-License-Identifier: Apache-2.0
"""Images for the board of the thesis: built, looked into, and their crate read by clippy.

The files of tests run in the order of their names. Building for this board takes longest, so it comes last.
"""

from __future__ import annotations

import os
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import BUILD
from test_zephyr import ALLOCATOR, PROGRAMS, _arm, lf, symbols

from lf_west.workspace import REPOSITORY

__all__ = ["_arm"]

pytestmark = pytest.mark.zephyr


@pytest.fixture(scope="module")
def images(_arm: None) -> Path:
    """Images with what the applications use of this board: devices, clock synchronization over UDP, an RTI."""
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
    return build / "zephyr"


def test_images_for_the_board_of_the_thesis_have_what_they_use_and_no_allocator(images: Path) -> None:
    linked = {
        "ClockSync/board": {"lf_main"},
        "Thermostat/thermostat": {"lf_main", "lf_i2c_transfer", "lf_adc_sample", "lf_pwm_set_pulse"},
        "SmartGrid/a": {"lf_main", "lf_rti_main"},
    }
    for image, entries in linked.items():
        names = set(symbols(images / image))
        assert entries <= names, image
        assert [name for name in names if ALLOCATOR.fullmatch(name)] == [], image


def test_the_crate_of_images_has_no_warnings(images: Path) -> None:
    settings = images / "Thermostat/thermostat/lf/cargo_settings.cmake"
    cargo = re.search(r"^set\(cargo \[==\[(.+)\]==\]\)$", settings.read_text(), re.MULTILINE)
    assert cargo is not None
    if not Path(cargo[1]).with_name("cargo-clippy").is_file():
        pytest.skip(f"there is no cargo-clippy beside {cargo[1]}; .ci/run installs it")
    script = REPOSITORY / "zephyr/cmake/lf_cargo_build.cmake"
    command = ["cmake", f"-DSETTINGS={settings}", "-DLINT=lf-zephyr", "-P", str(script)]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert result.returncode == 0, result.stdout
