# SPDX-License-Identifier: Apache-2.0
"""Finding and running the LF compiler, `lfz`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from lf_west import description
from lf_west.description import Description
from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY


@dataclass(frozen=True)
class Compiler:
    """An `lfz` that can be run."""

    path: Path
    environment: Mapping[str, str]

    def build(
        self,
        file: Path,
        out: Path,
        *,
        deployment: Path | None = None,
        board: str | None = None,
        federates: Sequence[str] = (),
        host_only: bool = False,
    ) -> Description:
        """Generate all crates and compile those for this computer; `board` takes all federates for Zephyr, and
        `host_only` leaves out those on boards.

        The compiler says itself what is wrong with a program, on the standard error.
        """
        arguments = [str(self.path), "build", str(file), "--json", "--release", "--out", str(out)]
        if deployment is not None:
            arguments += ["--deployment", str(deployment)]
        elif board is not None:
            arguments += ["--platform", "zephyr", "--board", board]
        if host_only:
            arguments += ["--platform", "host"]
        if federates:
            arguments += ["--federate", *federates]
        result = _run(arguments, self.environment)
        if result.returncode != 0:
            raise LfError(
                f"lfz could not build {file}.",
                "Correct what is reported above.",
                f"Look at the program alone: {self.path} check {file}",
                status=_status(result.returncode),
            )
        return description.parse_text(result.stdout, f"the output of {self.path}")

    def planned_board(self, file: Path) -> str | None:
        """The board that the program itself names: `platform: {board: …}`."""
        result = _run([str(self.path), "plan", str(file), "--json"], self.environment)
        if result.returncode != 0:
            raise LfError(
                f"lfz could not read {file}.", "Correct what is reported above.", status=_status(result.returncode)
            )
        board = json.loads(result.stdout)["target"]["board"]
        return None if board is None else str(board)

    def explain(self, messages: Sequence[Path]) -> str:
        """Convert cargo's messages in these files to messages about the LF program."""
        result = _run([str(self.path), "explain-errors", *map(str, messages)], self.environment)
        if result.returncode != 0:
            raise LfError(
                f"{self.path} cannot say where in the LF program this is.",
                "Use an lfz and west commands of the same version.",
                status=_status(result.returncode),
            )
        return result.stdout

    def nanoseconds(self, text: str, option: str) -> int:
        """Convert the time of an option; lfz itself reports an invalid one."""
        result = _run([str(self.path), "nanoseconds", "--", text], self.environment)
        if result.returncode != 0:
            raise LfError(f"{option}: {text!r} is no time.", "Write it like 30, 30s or 1.5min.", status=2)
        return int(result.stdout)

    def supervise(self, federation: dict[str, Any]) -> NoReturn:
        """Become the program that runs these processes: then no process outlives it, whatever happens to it."""
        with tempfile.TemporaryFile("w+", encoding="utf-8") as file:
            json.dump(federation, file, indent=2)
            file.seek(0)
            os.dup2(file.fileno(), 0)
            sys.stdout.flush()
            sys.stderr.flush()
            try:
                os.execve(self.path, [str(self.path), "supervise", "-"], dict(self.environment))
            except OSError as error:
                raise _not_run(str(self.path), error) from error


def find(option: str | None, environment: Mapping[str, str], say: Callable[[str], None] = lambda _: None) -> Compiler:
    """The compiler that --lfc or LFZ names; else this repository's, built if need be; else the one in PATH."""
    for origin, text in (("--lfc", option), ("LFZ", environment.get("LFZ"))):
        if text:
            return Compiler(_named(origin, text), environment)
    cargo = _cargo(environment)
    if cargo is not None:
        return Compiler(_built(cargo, environment, say), environment)
    in_path = shutil.which("lfz", path=environment.get("PATH"))
    if in_path is not None:
        return Compiler(Path(in_path), environment)
    raise LfError(
        "there is no lfz, and no cargo to build it with.",
        "Install Rust from https://rustup.rs, then run the command again.",
        "Name a compiler that is built already: --lfc PATH, or LFZ=PATH in the environment.",
    )


def _named(origin: str, text: str) -> Path:
    path = Path(text).absolute()
    if not (path.is_file() and os.access(path, os.X_OK)):
        what = "cannot be executed" if path.is_file() else "does not exist"
        raise LfError(
            f"{origin} names {text}, which {what}.",
            "Name the program `lfz` itself, with its folder.",
            "Leave it out, so that the compiler of this repository is built and used.",
        )
    return path


def _cargo(environment: Mapping[str, str]) -> str | None:
    return shutil.which(environment.get("CARGO") or "cargo", path=environment.get("PATH"))


def _built(cargo: str, environment: Mapping[str, str], say: Callable[[str], None]) -> Path:
    """Cargo knows best whether something has changed, so it is asked each time; it also says where the result is."""
    say("building the LF compiler, if it has changed")
    arguments = [cargo, "build", "--quiet", "--release", "--package", "lfz", "--bin", "lfz"]
    arguments += ["--manifest-path", str(REPOSITORY / "Cargo.toml"), "--message-format", "json-render-diagnostics"]
    result = _run(arguments, environment, folder=REPOSITORY)
    if result.returncode != 0:
        raise LfError(
            f"cargo could not build lfz in {REPOSITORY}.",
            "Correct what cargo reports above.",
            "Name a compiler that is built already: --lfc PATH, or LFZ=PATH in the environment.",
            status=_status(result.returncode),
        )
    for line in result.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message.get("target", {}).get("name") == "lfz":
            return Path(message["executable"])
    raise LfError(
        "cargo has not said where it put lfz.",
        "Name the compiler: --lfc PATH, or LFZ=PATH in the environment.",
    )


def _run(
    arguments: Sequence[str], environment: Mapping[str, str], folder: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a program whose standard output is read and whose standard error is the user's."""
    try:
        return subprocess.run(
            arguments,
            cwd=folder,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            check=False,
        )
    except OSError as error:
        raise _not_run(arguments[0], error) from error


def _not_run(program: str, error: OSError) -> LfError:
    return LfError(
        f"{program} cannot be run: {error.strerror}.",
        "Name another compiler: --lfc PATH, or LFZ=PATH in the environment.",
    )


def _status(returncode: int) -> int:
    """The status to exit with when a program has ended like this, as a shell gives it."""
    return returncode if returncode > 0 else 128 - returncode
