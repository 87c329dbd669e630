# SPDX-License-Identifier: Apache-2.0
"""The environment of the boards in a run: an oscilloscope, moved inputs, clock drifts."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from conftest import World
from test_runs import BOARD
from test_zephyr import run

from lf_west.workspace import REPOSITORY

CLOCKS = "clock_sync/src/ClockSyncPins.lf"


@pytest.fixture
def grid(grid: World) -> World:
    """A program and an image with pins, which print their arguments."""
    grid.set("STAND_IN_CONFIG", "CONFIG_LF_OSCILLOSCOPE=y")
    grid.set("STAND_IN_MOVES", "1000 sw0 1 1")
    return grid


def test_each_participant_records_into_a_file_of_its_own(grid: World, tmp_path: Path) -> None:
    result = grid.run("--vcd", str(tmp_path / "pins.vcd"), "--timeout", "10min")
    assert result.returncode == 0, result.stderr
    said = {line.split(" | ")[0].strip(): line for line in result.stdout.splitlines() if "vcd" in line}
    assert said["a"].endswith("/a.vcd")
    assert "-lf-vcd=" in said["b"]
    assert said["b"].endswith("/b.vcd")
    assert "0 pins recorded" in result.stdout + result.stderr


def test_a_program_reads_the_script_and_an_image_a_list_of_moves(grid: World, tmp_path: Path) -> None:
    script = tmp_path / "script.txt"
    script.write_text("1 us b.sw0 1\n")
    result = grid.run("--devices", str(script), "--timeout", "10min")
    assert result.returncode == 0, result.stderr
    assert f"--devices {script}\n" in result.stdout
    (image,) = [line for line in result.stdout.splitlines() if "-lf-devices=" in line]
    assert Path(image.rpartition("=")[2]).read_text() == "1000 sw0 1 1\n"


def test_only_images_on_native_sim_drift(grid: World) -> None:
    result = grid.run("--drift", "b=26e-6", "--timeout", "10min")
    assert result.returncode == 0, result.stderr
    assert "-rt-drift=2.6e-05\n" in result.stdout
    result = grid.run("--no-build", "--drift", "a=26e-6")
    assert "--drift: a is no image on native_sim; there are b." in result.stderr
    assert grid.run("--drift", "b=fast").returncode == 2


def test_images_without_pins_get_no_options(grid: World, tmp_path: Path) -> None:
    grid.describe(a=BOARD, b=BOARD)
    grid.set("STAND_IN_CONFIG", "")
    result = grid.run("--vcd", str(tmp_path / "pins.vcd"), "--timeout", "10min")
    assert result.returncode == 0, result.stderr
    assert "-lf-vcd" not in result.stdout


@pytest.mark.zephyr
def test_edges_of_two_images_are_on_one_clock(lfz_itself: Path, tmp_path: Path) -> None:
    vcd, svg = tmp_path / "pins.vcd", tmp_path / "edges.svg"
    source = tmp_path / "src" / "ClockSyncPins.lf"
    _short_copy(tmp_path)
    deployment = ("--deployment", str(tmp_path / "deployment/pins_native_sim.yaml"))
    output = run(source, *deployment, "--drift", "b=26e-6", "--vcd", str(vcd))
    assert "2 pins recorded" in output, output
    words = ["--reference", "a.led0", "--json", "--svg", str(svg)]
    result = subprocess.run([lfz_itself, "scope", vcd, *words], stdout=subprocess.PIPE, text=True, check=True)
    report = json.loads(result.stdout)
    (compared,) = report["compared"]
    # From 0 to 3 s, every half a second; how far apart they are is the computer's affair.
    assert (report["edges"], compared["signal"], compared["edges"]) == (7, "b.led0", 7)
    assert len(compared["pairs"]) + compared["missing"] == 7
    assert svg.read_text(encoding="utf-8").startswith("<svg")


def _short_copy(folder: Path) -> None:
    """The application, for three seconds."""
    application = REPOSITORY / "applications/clock_sync"
    for name in ("src/ClockSyncPins.lf", "deployment/pins_native_sim.yaml", "prj.conf"):
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        text = (application / name).read_text(encoding="utf-8")
        file.write_text(text.replace("timeout: 60 sec", "timeout: 3 sec"), encoding="utf-8")
