# SPDX-License-Identifier: Apache-2.0
"""The folders and files of an LF application: its source, its deployment, its settings, its build folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY

# The endings of files of LF and micro LF.
ENDINGS = (".lf", ".ulf")


@dataclass(frozen=True)
class Application:
    """An LF program with its surroundings."""

    file: Path
    # The folder with the settings: the one around `src`, or that of the file when it is not in a `src` folder.
    folder: Path
    # Everything that is built.
    build: Path
    # The build folders of images that lie elsewhere, by their names.
    elsewhere: Mapping[str, Path] = field(default_factory=dict)

    @property
    def program(self) -> str:
        """The program's name, which is that of its file."""
        return self.file.stem

    @property
    def generated(self) -> Path:
        """The folder of the generated crates."""
        return self.build / "lfz" / self.program / "west"

    @property
    def images(self) -> Path:
        """The folder with one build folder per image."""
        return self.build / "zephyr" / self.program

    @property
    def description(self) -> Path:
        """The file with the compiler's description of the program."""
        return self.images / "federation.json"

    def image_folder(self, name: str) -> Path:
        """The build folder of one image."""
        return self.elsewhere.get(name, self.images / name)

    def log(self, name: str) -> Path:
        """Return the log of one image's build."""
        return self.images / f"{name}.log"

    def messages(self, name: str) -> Path:
        """Return the file with cargo's messages about the crate of one image, in JSON."""
        return self.images / f"{name}.cargo.json"

    def deployment(self, option: str | None) -> Path | None:
        """The deployment file: the one that is named, else deployment.yaml of the application if there is one."""
        if option is None:
            default = self.folder / "deployment.yaml"
            return default if default.is_file() else None
        found = _first_file(Path(option), (Path.cwd(), self.folder))
        if found is None:
            raise LfError(
                f"there is no deployment file {option}, neither here nor in {self.folder}.",
                *(f"Name it: --deployment {place}" for place in self.deployments()),
                'Leave --deployment out and name a board for all federates: -w "-b BOARD"',
            )
        return found

    def deployments(self) -> list[Path]:
        """The deployment files that the application offers."""
        return sorted((self.folder / "deployment").glob("*.y*ml"))

    def conf_overlays(self, options: list[str]) -> list[Path]:
        """The files of -c, from here, from the application's folder or from this repository."""
        places = (Path.cwd(), self.folder, REPOSITORY)
        found = []
        for option in options:
            file = _first_file(Path(option), places)
            if file is None:
                raise LfError(
                    f"-c, --conf-overlays: there is no file {option} in any of {', '.join(map(str, places))}.",
                    "Write the file's path from the current folder or from the application's folder.",
                )
            found.append(file)
        return found


def open_application(file: str, build: str | None) -> Application:
    """The application of an LF file; `build` is another place for its build folder."""
    path = _tidy(Path(file))
    if not path.is_file():
        raise LfError(
            f"there is no LF file {file}.",
            "Write its path from the current folder: src/Example.lf",
            *_alike(path),
        )
    if path.suffix not in ENDINGS:
        raise LfError(f"{file} is no LF file: its name does not end in .lf or .ulf.", *_alike(path))
    folder = path.parent.parent if path.parent.name == "src" else path.parent
    return Application(path, folder, _tidy(Path(build)) if build else folder / "build")


def user_files(application: Application, board: str, federate: str | None) -> tuple[list[Path], list[Path]]:
    """The user's configuration files and overlays for an image, those that exist, the most special last.

    Every image of the application gets prj.conf and boards/BOARD.*; a federate also gets prj_FEDERATE.conf and
    boards/BOARD_FEDERATE.*.
    """
    confs, overlays = [application.folder / "prj.conf"], []
    owners = [""] if federate is None else ["", f"_{federate}"]
    for owner in owners:
        if owner:
            confs.append(application.folder / f"prj{owner}.conf")
        for name in board_file_names(board):
            confs.append(application.folder / "boards" / f"{name}{owner}.conf")
            overlays.append(application.folder / "boards" / f"{name}{owner}.overlay")
    # The repository's own prj.conf is part of every image already.
    confs = [conf for conf in confs if conf.is_file() and conf.parent != REPOSITORY]
    return confs, [overlay for overlay in overlays if overlay.is_file()]


def user_settings(application: Application) -> list[str]:
    """Return CMake's arguments for the application's own Kconfig options and device bindings, if it has any.

    Where the folder is that of the repository, Zephyr finds them by itself.
    """
    folder = application.folder
    if folder == REPOSITORY:
        return []
    kconfig = [f"-DKCONFIG_ROOT={folder / 'Kconfig'}"] if (folder / "Kconfig").is_file() else []
    return [*kconfig, *([f"-DDTS_ROOT={folder}"] if (folder / "dts").is_dir() else [])]


def board_file_names(board: str) -> list[str]:
    """The names that files for a board have, as in Zephyr: `/` becomes `_`; with a revision there are two names.

    `a@B/c/d` has the files a_c_d.* and a_c_d_B.*. A board with nothing but its SoC after the name, as in `a/c`, also
    has a.*, for most such boards have only one.
    """
    name, _, revision_and_qualifiers = board.partition("@")
    revision, slash, qualifiers = revision_and_qualifiers.partition("/")
    if not slash:
        name, slash, qualifiers = name.partition("/")
    plain = (name + slash + qualifiers).replace("/", "_")
    names = [plain] if not qualifiers or "/" in qualifiers else [name, plain]
    return [*names, f"{plain}_{revision.replace('.', '_')}"] if revision else names


def _first_file(path: Path, folders: tuple[Path, ...]) -> Path | None:
    candidates = (_tidy(folder / path) for folder in folders)
    return next((file for file in candidates if file.is_file()), None)


def _tidy(path: Path) -> Path:
    """The absolute path without `..`; links are not followed."""
    return Path(os.path.normpath(path.absolute()))


def _alike(path: Path) -> list[str]:
    """Advice to take an LF file nearby."""
    folder = path.parent if path.parent.is_dir() else path.parent.parent
    nearby = sorted({path for ending in ENDINGS for place in ("", "src/") for path in folder.glob(f"{place}*{ending}")})
    return [f"Take one of the LF files there: {', '.join(str(file) for file in nearby[:5])}"] if nearby else []
