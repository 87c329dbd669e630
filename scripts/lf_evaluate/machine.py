# SPDX-License-Identifier: Apache-2.0
"""The computer that measurements ran on, and what was measured and built it."""

from __future__ import annotations

import os
import platform
import re
import subprocess
from pathlib import Path
from typing import Any

from lf_evaluate.setting import Setting
from lf_west.workspace import REPOSITORY


def this(setting: Setting) -> dict[str, Any]:
    """This computer, with what is in this repository, and what to compare with."""
    cpuinfo = _text("/proc/cpuinfo")
    model = re.search(r"^model name\s*: (.*)$", cpuinfo, re.MULTILINE)
    memory = re.search(r"^MemTotal:\s*(\d+)", _text("/proc/meminfo"), re.MULTILINE)
    return {
        "processor": model[1] if model else platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "memory_gib": round(int(memory[1]) / 2**20, 1) if memory else 0.0,
        "kernel": platform.release(),
        "governor": _text("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").strip() or None,
        "virtualized_by": _said("systemd-detect-virt", "--vm").replace("none", "") or None,
        "load": os.getloadavg()[0],
        "versions": [{"name": name, "version": version} for name, version in _versions(setting).items() if version],
    }


def _versions(setting: Setting) -> dict[str, str]:
    versions = {"lf-zephyr-rs": _commit(REPOSITORY)}
    clones = {
        "stock RTI": setting.stock_rti and setting.stock_rti.parent,
        "reactor-rs": setting.reactor_rs,
        "LF's benchmarks": setting.benchmarks,
    }
    versions |= {name: _commit(clone) or "version unknown" for name, clone in clones.items() if clone is not None}
    if setting.lfc is not None:
        versions["lfc"] = _said(str(setting.lfc), "--version") or "version unknown"
    programs = ("rustc", "gcc", "arm-none-eabi-gcc", "qemu-system-arm")
    zephyr = re.findall(
        r"^(?:VERSION_M\w+|PATCHLEVEL) = (\d+)$", _text(f"{os.environ.get('ZEPHYR_BASE')}/VERSION"), re.M
    )
    return versions | {program: _said(program, "--version") for program in programs} | {"Zephyr": ".".join(zephyr)}


def _commit(folder: Path) -> str:
    """The commit of the repository that a folder is in, and whether something was changed since."""
    commit = _said("git", "-C", str(folder), "log", "-1", "--format=%h of %cs")
    is_dirty = _said("git", "-C", str(folder), "status", "--porcelain", "--untracked-files=no")
    return commit + ", with changes that are not committed" if commit and is_dirty else commit


def _said(*command: str) -> str:
    """The first line that a program says, if it is there and says anything."""
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.partition("\n")[0].strip() if done.returncode == 0 else ""


def _text(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError:
        return ""
