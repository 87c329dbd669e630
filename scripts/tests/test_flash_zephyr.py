# SPDX-License-Identifier: Apache-2.0
"""Zephyr's own runners with the commands: each passes the right probe to its tool."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest
from conftest import World

from lf_west.flash import Flash
from lf_west.runners import takes_probe, zephyr_runners
from lf_west.workspace import Workspace, find_workspace

pytestmark = pytest.mark.zephyr

PROBE = "02440000AAAA"
RUNNERS_YAML = """
runners: [{runner}]
flash-runner: {runner}
config: {{board_dir: /nowhere, elf_file: zephyr.elf, hex_file: zephyr.hex, bin_file: zephyr.bin}}
args: {{{runner}: {arguments}}}
"""


@pytest.fixture(scope="module")
def workspace() -> Workspace:
    """The real one, which the stand-ins of a test's world would hide."""
    return find_workspace(os.environ)


def built(world: World, workspace: Workspace, runner: str, arguments: Sequence[str]) -> Path:
    """A build folder with as much as `west flash` reads."""
    folder = world.top / "build" / runner
    (folder / "zephyr").mkdir(parents=True)
    for name in ("elf", "hex", "bin"):
        (folder / f"zephyr/zephyr.{name}").write_text("")
    (folder / "CMakeCache.txt").write_text(f"ZEPHYR_BASE:PATH={workspace.zephyr_base}\n")
    config = ['CONFIG_BOARD_TARGET="plank"', "CONFIG_FLASH_BASE_ADDRESS=0x0", "CONFIG_FLASH_LOAD_OFFSET=0x0"]
    (folder / "zephyr/.config").write_text("\n".join([*config, "CONFIG_HAS_FLASH_LOAD_OFFSET=y", ""]))
    text = RUNNERS_YAML.format(runner=runner, arguments=list(arguments))
    (folder / "zephyr/runners.yaml").write_text(text)
    return folder


@pytest.mark.parametrize(
    ("runner", "tool", "arguments", "words"),
    [
        ("pyocd", "pyocd", ["--target=x"], ["-u", PROBE]),
        ("pyocd", "pyocd", ["--target=x"], ["--no-wait"]),
        ("linkserver", "LinkServer", ["--device=x"], ["--probe", PROBE]),
        ("probe-rs", "probe-rs", ["--chip=x"], ["--probe", PROBE]),
        (
            "openocd",
            "openocd",
            ["--cmd-load=flash write_image erase", "--cmd-verify=verify_image"],
            ["-c", f"adapter serial {PROBE}"],
        ),
    ],
)
def test_the_tool_is_told_the_probe(
    runner: str, tool: str, arguments: list[str], words: list[str], workspace: Workspace, world: World
) -> None:
    (world.bin / "west").unlink()
    # The workspace's configuration says where its commands are.
    world.monkeypatch.delenv("WEST_CONFIG_LOCAL")
    world.program(tool, 'print("LinkServer v25.3.1")\n')
    command = Flash("b", runner, PROBE, built(world, workspace, runner, arguments), ()).command()
    subprocess.run(command, cwd=workspace.topdir, env=workspace.environment(os.environ), check=True)
    calls = world.calls(tool)
    assert any(words == call[index : index + len(words)] for call in calls for index in range(len(call))), calls


def test_zephyrs_runners_say_what_they_can(workspace: Workspace) -> None:
    known = zephyr_runners(workspace)
    assert known["jlink"].flashes and takes_probe("jlink", known["jlink"])
    assert known["openocd"].flashes and not known["openocd"].takes_dev_id
    assert takes_probe("openocd", known["openocd"])
    assert not takes_probe("teensy", known["teensy"])
    assert not known["qemu"].flashes
