# SPDX-License-Identifier: Apache-2.0
"""LF's own compiler and runtimes, measured beside ours if a person names them."""

from __future__ import annotations

import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from lf_evaluate.setting import Setting, execute
from lf_west.errors import LfError

# The runtimes of its target languages.
RUNTIMES = {"C": "LF's C runtime", "Rust": "reactor-rs"}

# The target property of programs without threads, which their runtimes have otherwise.
SINGLE_THREADED = "single-threaded: true"

# The limit of a finding without them.
WITHOUT = "LF's own runtimes are measured beside ours if --lfc names LF's compiler."
# It takes minutes for programs with a million connections.
BUILD_LIMIT = "5m"


@dataclass(frozen=True)
class Lfc:
    """LF's compiler, with the runtimes that its programs are compiled with."""

    program: Path
    # LF's Rust runtime; without it, programs in Rust are not compiled.
    reactor_rs: Path | None
    # LF's RTI, instead of the one that the compiler makes for each federation without optimizations.
    rti: Path | None

    @classmethod
    def of(cls, setting: Setting) -> Lfc | None:
        """Return the compiler that the command line names."""
        return None if setting.lfc is None else cls(setting.lfc, setting.reactor_rs, setting.stock_rti)

    def targets(self) -> tuple[str, ...]:
        """Return the target languages that can be measured."""
        return ("C",) if self.reactor_rs is None else ("C", "Rust")

    def properties(self, target: str) -> str:
        """Return the target properties of optimized programs; what names the runtime is obeyed only there."""
        runtime = f', external-runtime-path: "{self.reactor_rs}"' if target == "Rust" else ""
        return f"build-type: Release{runtime}"

    def build(self, file: Path) -> Path:
        """Compile a program in `PROJECT/src`, and return the one executable file in `PROJECT/bin`."""
        made = project_of(file) / "bin"
        for old in made.glob("*"):
            old.unlink()
        execute(["timeout", BUILD_LIMIT, self.program, file], errors=True)
        programs = [it for it in made.glob("*") if it.is_file() and os.access(it, os.X_OK)]
        if len(programs) != 1:
            raise LfError(f"{self.program} made {len(programs)} programs in {made}, and should have made one")
        if self.rti is not None:
            for made_rti in project_of(file).glob("fed-gen/*/bin/RTI"):
                shutil.copy2(self.rti, made_rti)
        return programs[0]


def project_of(file: Path) -> Path:
    """Return the folder that has the innermost `src` with this file."""
    return next(folder.parent for folder in file.parents if folder.name == "src")


def of_target(text: str, target: str, properties: str) -> str:
    """Return a program with these target properties instead of its own."""
    return re.sub(r"^target \w+[^\n]*$", f"target {target} {{ {properties} }}", text, count=1, flags=re.MULTILINE)
