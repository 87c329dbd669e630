# SPDX-License-Identifier: Apache-2.0
"""Zephyr's runners: which of them a built image has, and how each is told which probe to use."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from lf_west.errors import LfError
from lf_west.workspace import Workspace

# Zephyr's runners are Python classes that say themselves what they can do. They are asked in a process of their own,
# because they change what can be imported.
_ASK = """
import json, sys
sys.path.insert(0, sys.argv[1])
from runners import ZephyrBinaryRunner
answers = {}
for runner in ZephyrBinaryRunner.get_runners():
    can = runner.capabilities()
    answers[runner.name()] = {"flash": "flash" in can.commands, "dev_id": can.dev_id}
print(json.dumps(answers))
"""
# Runners that choose their probe by another option than --dev-id. LinkServer's takes --dev-id and ignores it, so that
# all images would go to the probe that was plugged in first.
_OPTIONS = {
    "blackmagicprobe": "--gdb-serial={}",
    "bossac": "--bossac-port={}",
    "esp32": "--esp-device={}",
    "gd32isp": "--port={}",
    "linkserver": "--probe={}",
    "openocd": "--cmd-pre-init=adapter serial {}",
    "stm32cubeprogrammer": "--conn-modifiers=sn={}",
    "stm32flash": "--device={}",
}
# Further arguments of a runner when a probe is named: pyOCD would wait forever for one that is not connected.
_FURTHER = {"pyocd": ("--tool-opt=--no-wait",)}


@dataclass(frozen=True)
class Runner:
    """The capabilities of a runner."""

    flashes: bool
    takes_dev_id: bool


@dataclass(frozen=True)
class ImageRunners:
    """The runners that an image was configured with."""

    # None for a board that west cannot flash.
    default: str | None
    names: tuple[str, ...]


def zephyr_runners(workspace: Workspace) -> dict[str, Runner]:
    """All runners that the workspace's Zephyr has, by name."""
    folder = workspace.zephyr_base / "scripts" / "west_commands"
    command = [sys.executable, "-c", _ASK, str(folder)]
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    if result.returncode != 0:
        reason = (result.stderr.strip().splitlines() or [f"exit status {result.returncode}"])[-1]
        raise LfError(
            f"Zephyr's runners in {folder} cannot be asked what they can do: {reason}",
            f"Install what they need: pip install -r {workspace.zephyr_base}/scripts/requirements-base.txt",
        )
    answers = json.loads(result.stdout.splitlines()[-1])
    return {name: Runner(bool(item["flash"]), bool(item["dev_id"])) for name, item in answers.items()}


def image_runners(folder: Path) -> ImageRunners:
    """Read `runners.yaml` in a build folder."""
    file = folder / "zephyr" / "runners.yaml"
    try:
        content: Any = yaml.safe_load(file.read_text(encoding="utf-8"))
        names = content["runners"] or []
        default = content.get("flash-runner")
        return ImageRunners(default and str(default), tuple(str(name) for name in names))
    except OSError:
        return ImageRunners(None, ())
    except (yaml.YAMLError, AttributeError, KeyError, TypeError) as error:
        raise LfError(
            f"{file} cannot be read: {error}.",
            'Make the build folder anew: -w "-p always"',
        ) from error


def is_emulated(folder: Path) -> bool:
    """Return whether the image in a build folder is for a program that plays a board."""
    try:
        lines = (folder / "zephyr" / ".config").read_text(encoding="utf-8").splitlines()
    except OSError:
        return False
    return not {"CONFIG_QEMU_TARGET=y", "CONFIG_ARCH_POSIX=y"}.isdisjoint(lines)


def takes_probe(name: str, runner: Runner) -> bool:
    """Return whether a runner can be told which probe to use."""
    return name in _OPTIONS or runner.takes_dev_id


def probe_arguments(name: str, probe: str) -> list[str]:
    """The arguments by which a runner flashes the board at this probe and no other."""
    choice = [_OPTIONS[name].format(probe)] if name in _OPTIONS else [f"--dev-id={probe}"]
    return [*choice, *_FURTHER.get(name, ())]
