# SPDX-License-Identifier: Apache-2.0
"""The common setting of all parts, and the functions by which they run programs."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_evaluate import measured
from lf_evaluate.measured import Measured
from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY

# Where all that is made lies.
FOLDER = REPOSITORY / "target/evaluate"
PROGRAMS = REPOSITORY / "rust/bench/programs"
# No run takes as long, except one that hangs.
TIME_LIMIT = "5min"
# A word of a command line.
Word = str | int | Path


@dataclass(frozen=True)
class Setting:
    """The options of the command line; see their help."""

    # The folder of lf-bench and lfz.
    built: Path
    stock_rti: Path | None
    # LF's compiler, its Rust runtime, and a clone of its benchmarks.
    lfc: Path | None
    reactor_rs: Path | None
    benchmarks: Path | None
    quick: bool
    recording: Path | None
    has_zephyr: bool
    rounds: int
    exchanges: int
    seconds: int
    large: int
    large_seconds: int
    iterations: int
    after_runs: int
    drift_seconds: int

    @property
    def lfz(self) -> Path:
        """The compiler, which also runs the federations of this computer."""
        return self.built / "lfz"

    def boards(self) -> list[str]:
        """On what applications run: as programs, and as images where there is a Zephyr workspace and time."""
        return ["Linux", "native_sim"] if self.has_zephyr and not self.quick else ["Linux"]

    def bench(self, part: str, *words: Word) -> list[Measured]:
        """Run a part of `lf-bench`."""
        return measured.read(execute([self.built / "lf-bench", part, *words]))

    def rtis(self, part: str, *words: Word) -> list[Measured]:
        """Run a part of `lf-bench` that measures RTIs side by side."""
        stock = [] if self.stock_rti is None else ["--stock-rti", str(self.stock_rti)]
        return self.bench(part, "--lfz", str(self.lfz), "--rounds", self.rounds, *stock, *words)

    def build(self, board: str, file: Path) -> None:
        """Builds all federates of a program."""
        if board == "Linux":
            execute([*self._host("build", file), "--platform", "host"])
        else:
            self.west("lf-fed-build", file, None, "-w", "-b native_sim/native/64")

    def run(self, board: str, file: Path) -> str:
        """Runs all federates of a program that was built, with an RTI; what they print."""
        if board == "Linux":
            return execute([*self._host("run", file), "--timeout", TIME_LIMIT], errors=True)
        return self.west("lf-fed-run", file, None, "--no-build", "--timeout", TIME_LIMIT)

    def _host(self, command: str, file: Path) -> list[Word]:
        folder = FOLDER / file.stem / "host"
        folders: list[Word] = ["--out", folder, "--target-dir", FOLDER / "cargo", "--home", REPOSITORY]
        return [self.lfz, command, file, "--release", *folders]

    def west(self, command: str, file: Path, build: Path | None, *words: Word) -> str:
        """Runs a west command on a program, whose images are built in this folder; what it prints."""
        folders: list[Word] = ["--lfc", self.lfz, "--build-dir", build or build_folder(file)]
        return execute(["python3", REPOSITORY / "scripts/lf", command, file, *folders, *words], errors=True)


def execute(words: Sequence[Word], errors: bool = False, folder: str | None = None) -> str:
    """Run a program, and return its output, with its standard error if requested."""
    command = [str(word) for word in words]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            # Images are not built in the target folder of this repository's own programs.
            env=os.environ | {"CARGO_TARGET_DIR": str(FOLDER / "cargo-zephyr")},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if errors else subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
    except OSError as error:
        raise LfError(f"{command[0]} cannot be started: {error.strerror}") from error
    if done.returncode == 0:
        return done.stdout
    said = (done.stdout if errors else done.stderr).strip()
    raise LfError(f"{' '.join(command)} failed with status {done.returncode}:\n{said}")


def build_folder(file: Path) -> Path:
    """Return the folder in which the images of a program are built."""
    return FOLDER / file.stem / "build"


def application(path: str) -> Path:
    """A file of the applications."""
    return REPOSITORY / "applications" / path


def variant(name: str, text: str) -> Path:
    """Writes a program, such as an application with other numbers in it.

    Programs of one name are built in one folder, so that most of an image need not be compiled again.
    """
    file = FOLDER / name / "src" / f"{name}.lf"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def deployment(name: str, rti: str, federates: dict[str, str]) -> Path:
    """Writes a deployment of an RTI and federates on these platforms."""
    file = FOLDER / name
    places = [
        f"  {federate}: {{ platform: {board}, ip: 10.0.0.{number} }}\n"
        for number, (federate, board) in enumerate(federates.items(), 2)
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"rti: {{ platform: {rti}, ip: 10.0.0.1 }}\nfederates:\n{''.join(places)}", encoding="utf-8")
    return file
