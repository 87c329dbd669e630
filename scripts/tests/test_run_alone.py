# SPDX-License-Identifier: Apache-2.0
"""lf-run: a program without federates, from its build to its status."""

from __future__ import annotations

import pytest
from conftest import World

from lf_west import qemu

BOARD = "native_sim/native/64"


@pytest.mark.parametrize("status", [0, 3])
def test_a_program_is_built_and_run_and_its_status_is_that_of_the_command(world: World, status: int) -> None:
    world.describe_unfederated()
    world.set("STAND_IN_IMAGE", f"import sys\nprint('hello')\nsys.exit({status})")
    result = world.run("-w", f"-b {BOARD}", command="lf-run")
    assert result.returncode == status, result.stderr
    assert len(world.calls("west")) == 1
    # No name is before the lines of the only one.
    assert "\nhello\n" in result.stdout


def test_a_program_that_does_not_end_is_stopped(world: World) -> None:
    world.describe_unfederated()
    world.set("STAND_IN_IMAGE", "import signal\nsignal.pause()")
    result = world.run("-w", f"-b {BOARD}", "--timeout", "10ms", command="lf-run")
    assert result.returncode == 124, result.stderr


def test_an_image_for_qemu_is_played_without_a_network_and_says_its_status(world: World) -> None:
    world.describe_unfederated("qemu_cortex_m3")
    world.program(qemu.PROGRAM, f"print({qemu.STATUS_LINE + '5'!r}, flush=True)\nsignal.pause()")
    result = world.run("-w", "-b qemu_cortex_m3", command="lf-run")
    assert result.returncode == 5, result.stderr
    (call,) = world.calls(qemu.PROGRAM)
    assert call[call.index("-nic") + 1] == "none"
    assert call[-1].endswith("/zephyr/zephyr.elf")


def test_other_boards_are_flashed_and_not_run(world: World) -> None:
    world.describe_unfederated("plank")
    result = world.run("-w", "-b plank", command="lf-run")
    assert result.returncode == 1
    assert "plank does not run on this computer." in result.stderr
    assert "west flash -d" in result.stderr


def test_federations_have_another_command(world: World) -> None:
    result = world.run("-w", f"-b {BOARD}", command="lf-run")
    assert result.returncode == 1
    assert "Grid is federated" in result.stderr
    assert "west lf-fed-run" in result.stderr
