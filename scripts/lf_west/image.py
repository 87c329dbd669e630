# SPDX-License-Identifier: Apache-2.0
"""One Zephyr image: the command that builds it, and what comes out."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west.application import Application, user_files, user_settings
from lf_west.description import Participant
from lf_west.errors import LfError
from lf_west.west_arguments import WestArguments
from lf_west.workspace import REPOSITORY


@dataclass(frozen=True)
class Image:
    """A participant that is built for a board."""

    name: str
    board: str
    # The build folder.
    folder: Path
    # Where cargo's messages go, in JSON.
    messages: Path
    # For `west build`, without the program's name.
    west: tuple[str, ...]
    # For CMake, after `--`.
    cmake: tuple[str, ...]

    @property
    def _record(self) -> Path:
        """The command that configured the build folder."""
        return self.folder / "lf_west_build.json"

    def command(self) -> list[str]:
        """The command that builds the image.

        With arguments for CMake, west configures the folder anew each time, which takes longer than building an image
        in which little has changed. So they are left out when the folder was configured with the same ones.
        """
        words = [*west_program(), "build", "--build-dir", str(self.folder), *self.west]
        if self._is_configured():
            return words
        return [*words, "--board", self.board, str(REPOSITORY), "--", *self.cmake]

    def _is_configured(self) -> bool:
        try:
            recorded = json.loads(self._record.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return False
        remakes = any(word == "--pristine" for word in self.west) and "always" in self.west
        return recorded == self._identity() and (self.folder / "build.ninja").is_file() and not remakes

    def _identity(self) -> list[str]:
        return [self.board, str(REPOSITORY), *self.west, "--", *self.cmake]

    def forget(self) -> None:
        """Let the next build configure the folder anew, and say what cargo says then."""
        self._record.unlink(missing_ok=True)
        # The folder around the build folder is where the file goes; cargo's redirection does not make it.
        self.messages.parent.mkdir(parents=True, exist_ok=True)
        self.messages.unlink(missing_ok=True)

    def remember(self) -> None:
        """Let the next build rely on the folder's configuration."""
        self._record.write_text(json.dumps(self._identity()) + "\n", encoding="utf-8")

    def executable(self) -> Path:
        """The image: a program of this computer for native_sim, else for the board."""
        return image_in(self.folder, self.board)


def image_in(folder: Path, board: str) -> Path:
    """The image in a build folder: a program of this computer for native_sim, else for the board."""
    return folder / "zephyr" / ("zephyr.exe" if is_native_sim(board) else "zephyr.elf")


def is_native_sim(board: str) -> bool:
    """Return whether a board is a program of this computer."""
    return board.replace("@", "/").split("/")[0] == "native_sim"


def plan_image(
    application: Application,
    participant: Participant,
    *,
    federated: bool,
    west: WestArguments,
    conf_overlays: Sequence[Path],
    cmake_arguments: Sequence[str],
    cargo_folder: Path,
) -> Image:
    """Work out how a participant is built: the generated files first, then the user's, then those of -c."""
    board, kconfig, overlay = participant.board, participant.kconfig, participant.overlay
    if board is None or kconfig is None or overlay is None:
        raise LfError(f"{participant.name} is a program of this computer, so no image can be built of it.")
    confs, overlays = user_files(application, board, participant.federate if federated else None)
    user_cmake = [*west.cmake, *cmake_arguments]
    more_confs, user_cmake = _taken_out("EXTRA_CONF_FILE", user_cmake)
    more_overlays, user_cmake = _taken_out("EXTRA_DTC_OVERLAY_FILE", user_cmake)
    all_confs: list[Path | str] = [kconfig, *confs, *conf_overlays, *west.extra_confs, *more_confs]
    all_overlays: list[Path | str] = [overlay, *overlays, *west.extra_overlays, *more_overlays]
    messages = application.messages(participant.name)
    cmake = [
        f"-DLF_FEDERATE_CRATE={participant.crate}",
        f"-DEXTRA_CONF_FILE={_joined(all_confs)}",
        f"-DEXTRA_DTC_OVERLAY_FILE={_joined(all_overlays)}",
        f"-DLF_CARGO_TARGET_DIR={cargo_folder}",
        f"-DLF_CARGO_MESSAGES={messages}",
        *user_settings(application),
        # The user's arguments come last, so that they count.
        *user_cmake,
    ]
    # A build folder that was made for another board is made anew.
    pristine = () if west.has_pristine else ("--pristine", "auto")
    folder = application.image_folder(participant.name)
    return Image(participant.name, board, folder, messages, (*pristine, *west.rest), tuple(cmake))


def west_program() -> list[str]:
    """Return the command of west: the one in PATH, else the one that this Python has."""
    in_path = shutil.which("west")
    return [in_path] if in_path else [sys.executable, "-m", "west"]


def _taken_out(variable: str, arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """The files that the user gives CMake in a variable of ours, and the arguments without it.

    CMake would let the user's list replace ours, but the files are meant to be added.
    """
    files: list[str] = []
    rest: list[str] = []
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if equals and name.split(":")[0] == f"-D{variable}":
            files += [file for file in value.split(";") if file]
        else:
            rest.append(argument)
    return files, rest


def _joined(files: Sequence[Path | str]) -> str:
    for file in files:
        if ";" in str(file) or " " in str(file):
            raise LfError(
                f"Zephyr cannot build with the path {file}, because it has a space or a semicolon in it.",
                "Move the application, or put its build folder elsewhere with --build-dir DIR",
            )
    return ";".join(str(file) for file in files)
