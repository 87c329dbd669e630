# SPDX-License-Identifier: Apache-2.0
"""The paths of this repository and of a Zephyr workspace to build in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from lf_west.errors import LfError

# The top folder of this repository is the Zephyr application that hosts every federate.
REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Workspace:
    """A west workspace that has Zephyr in it."""

    zephyr_base: Path
    topdir: Path

    def environment(self, environment: Mapping[str, str]) -> dict[str, str]:
        """The variables for a west that runs in this workspace."""
        return {**environment, "ZEPHYR_BASE": str(self.zephyr_base)}


def find_workspace(environment: Mapping[str, str], topdir: str | None = None) -> Workspace:
    """Look where Zephyr's own tools look: ZEPHYR_BASE, then a west workspace (`topdir`, which is west's own when west
    runs, or around the current folder, or around this repository), then CMake's registry of packages."""
    starts = (*((Path(topdir),) if topdir else ()), Path.cwd(), REPOSITORY)
    base_text = environment.get("ZEPHYR_BASE", "")
    if base_text:
        base = Path(base_text)
        around = (place for place in map(topdir_around, (base, *starts)) if place is not None)
        topdir_found = next(around, None)
        if is_zephyr(base) and topdir_found is not None:
            return Workspace(base, topdir_found)
        what = "lies in no west workspace" if is_zephyr(base) else "is no Zephyr repository"
        raise LfError(
            f"ZEPHYR_BASE is {base_text}, which {what}.",
            "Set ZEPHYR_BASE to the folder `zephyr` of a west workspace.",
            "Unset ZEPHYR_BASE, so that the workspace is looked for.",
        )
    for base in _candidates(environment, starts):
        found = topdir_around(base)
        if is_zephyr(base) and found is not None:
            return Workspace(base, found)
    raise LfError(
        "no west workspace with Zephyr was found.",
        "Set ZEPHYR_BASE to the folder `zephyr` of a west workspace.",
        "Run this command inside a west workspace.",
        "Run `west zephyr-export` in a west workspace, so that it is found from everywhere.",
        f"Make a workspace: west init -m {REPOSITORY} WORKSPACE && cd WORKSPACE && west update",
    )


def is_zephyr(folder: Path) -> bool:
    """Return whether a folder is Zephyr's repository."""
    return (folder / "VERSION").is_file() and (folder / "Kconfig.zephyr").is_file()


def topdir_around(folder: Path) -> Path | None:
    """The west workspace that a folder lies in. Links are not followed, because a workspace may consist of them."""
    absolute = folder.absolute()
    return next((place for place in (absolute, *absolute.parents) if (place / ".west").is_dir()), None)


def _candidates(environment: Mapping[str, str], starts: tuple[Path, ...]) -> Iterator[Path]:
    for start in starts:
        topdir = topdir_around(start)
        if topdir is not None:
            yield topdir / "zephyr"
    yield from _registered(environment)


def _registered(environment: Mapping[str, str]) -> Iterator[Path]:
    """CMake's registry has a file per package, whose text is the folder of the package's CMake files."""
    home = environment.get("HOME")
    if not home:
        return
    try:
        entries = sorted((Path(home) / ".cmake/packages/Zephyr").iterdir())
    except OSError:
        return
    for entry in entries:
        try:
            folder = Path(entry.read_text(encoding="utf-8").strip())
        except (OSError, UnicodeDecodeError):
            continue
        # The folder is ZEPHYR_BASE/share/zephyr-package/cmake.
        if len(folder.parents) > 2:
            yield folder.parents[2]
