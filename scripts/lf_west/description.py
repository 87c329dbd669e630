# SPDX-License-Identifier: Apache-2.0
"""The compiler's description of a program that it has built: the federates, their places, and their RTI.

`lfz build --json` prints it. It is kept beside the images, so that a program can be run or built again without the
compiler.
"""

from __future__ import annotations

import ipaddress
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lf_west.errors import LfError

# The ending of a federate's image for a spare board.
SPARE = "-spare"


@dataclass(frozen=True)
class Rti:
    """The federates' requirements of their RTI."""

    # The address that they connect to.
    host: str
    port: int
    federation_id: str
    federates: int
    # The program's demands on it, as options of `lfz rti`, without its id and its port.
    options: tuple[str, ...]


@dataclass(frozen=True)
class Network:
    """The addresses of a board, as deployed."""

    ip: ipaddress.IPv4Interface | ipaddress.IPv6Interface
    gateway: ipaddress.IPv4Address | ipaddress.IPv6Address | None
    # None where the board has one of its own.
    mac: str | None


@dataclass(frozen=True)
class Spare:
    """The image for a second board of a federate, with which it is swapped: the same program with other addresses."""

    kconfig: Path
    overlay: Path
    network: Network
    # The settings for flashing the board, as far as the deployment has them.
    probe: str | None


@dataclass(frozen=True)
class Participant:
    """A federate, the main reactor of a program without federates, or an RTI that is an image of its own."""

    name: str
    # The generated crate.
    crate: Path
    # For a Zephyr image, else None.
    board: str | None = None
    kconfig: Path | None = None
    overlay: Path | None = None
    # For a program of this computer, else None.
    program: Path | None = None
    # By which that program finds its keys, if its connections are encrypted.
    options: tuple[str, ...] = ()
    # Whether it is the RTI and no federate.
    is_rti: bool = False
    # Whether the RTI is part of the federate's image.
    joint_rti: bool = False
    # For a board that has a network of its own.
    network: Network | None = None
    # The settings for flashing the board, as far as the deployment has them.
    runner: str | None = None
    probe: str | None = None
    # Whether it may come and go while the federation runs, and whether it is started again when it has failed.
    transient: bool = False
    restarts: bool = False
    # The number of the federate in the federation.
    id: int | None = None
    # The image for a second board, if the deployment has one.
    spare: Spare | None = None
    # For such an image, the federate that it is of.
    spare_of: str | None = None

    @property
    def federate(self) -> str:
        """Return the name in the program, also of an image for a spare board."""
        return self.name if self.spare_of is None else self.spare_of

    def on_spare(self) -> Participant | None:
        """Return the same federate on its spare board, if it has one; no federate has a name with a hyphen."""
        if self.spare is None:
            return None
        spare, name = self.spare, f"{self.name}{SPARE}"
        return replace(
            self,
            name=name,
            kconfig=spare.kconfig,
            overlay=spare.overlay,
            network=spare.network,
            probe=spare.probe,
            spare=None,
            spare_of=self.name,
        )

    @property
    def has_rti(self) -> bool:
        """Return whether the federation's RTI is in its image."""
        return self.is_rti or self.joint_rti

    @property
    def is_image(self) -> bool:
        """Return whether it is a Zephyr image."""
        return self.board is not None


@dataclass(frozen=True)
class Description:
    """A program that was generated."""

    program: str
    rti: Rti | None
    participants: tuple[Participant, ...]
    # The text that it was read from, for `save`.
    source: dict[str, Any]

    @property
    def is_federated(self) -> bool:
        """Return whether there are federates and an RTI."""
        return self.rti is not None

    @property
    def has_rti_image(self) -> bool:
        """Return whether the RTI is an image, or part of one."""
        return any(item.has_rti for item in self.participants)

    def names(self) -> list[str]:
        """The participants' names."""
        return [participant.name for participant in self.participants]

    def select(self, names: list[str], *, spares: bool = False) -> list[Participant]:
        """The participants with these names, in the program's order; all when there are no names.

        With `spares`, the images for spare boards are among them, by their own names.
        """
        places = with_spares(self.participants) if spares else list(self.participants)
        known = [item.name for item in places]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise LfError(
                f"{self.program} has no federate {', '.join(unknown)}.",
                f"Choose among those that are built: {', '.join(known)}",
                "Build the federate first, or check its name with `lfz plan`.",
            )
        return [item for item in places if not names or item.name in names]

    def merged_over(self, older: Description) -> Description:
        """This description of some federates, completed by what was known about the others."""
        names = self.names()
        mine = {item["name"]: item for item in self.source["participants"]}
        others = [item for item in older.source["participants"] if item["name"] not in names]
        items = sorted([*mine.values(), *others], key=lambda item: int(item.get("id", -1)))
        return parse({**self.source, "participants": items}, "the merged description")

    def with_board(self, board: str) -> Description:
        """The same, with one board for all images."""
        moved = (replace(item, board=board) if item.is_image else item for item in self.participants)
        return replace(self, participants=tuple(moved))

    def save(self, file: Path) -> None:
        """Keep it for `load`."""
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(self.source, indent=2) + "\n", encoding="utf-8")


def in_image_folders(folders: Sequence[Path]) -> tuple[Description, dict[str, Path]]:
    """A federation whose images were built apart from each other, and the folder of each, by its name.

    The CMake function lf_program() leaves in each folder what was generated for its image.
    """
    whole: Description | None = None
    found: dict[str, Path] = {}
    for folder in folders:
        described = load(folder / "lf" / "federation.json")
        for name in described.names():
            if name in found:
                raise LfError(f"{name} is built in {found[name]} and in {folder}.", "Name only one of them.")
            found[name] = folder
        if whole is not None and (whole.program, whole.rti) != (described.program, described.rti):
            raise LfError(
                f"{folder} is no part of the federation {whole.program} in {folders[0]}.",
                "Build all federates of one LF file with one deployment: -DLF_DEPLOYMENT=FILE",
            )
        whole = described if whole is None else described.merged_over(whole)
    if whole is None:
        raise LfError("there is no folder to look for images in.")
    return whole, found


def load(file: Path) -> Description:
    """Read what `save` has kept."""
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise LfError(
            f"nothing has been generated yet: {file} cannot be read ({error.strerror}).",
            "Build without --no-lfc and --no-build first.",
            "Check that the LF file and --build-dir are those of the build.",
        ) from error
    return parse_text(text, str(file))


def parse_text(text: str, origin: str) -> Description:
    """Read JSON; `origin` says in error messages where it is from."""
    try:
        source = json.loads(text)
    except json.JSONDecodeError as error:
        raise _unreadable(origin, str(error)) from error
    return parse(source, origin)


def parse(source: Any, origin: str) -> Description:
    """Check what was read and give it types."""
    try:
        rti = source["rti"]
        return Description(
            program=_text(source["program"]),
            rti=None if rti is None else _rti(rti),
            participants=tuple(_participant(item) for item in source["participants"]),
            source=source,
        )
    except KeyError as error:
        raise _unreadable(origin, f"{error} is missing") from error
    except (TypeError, ValueError) as error:
        raise _unreadable(origin, str(error)) from error


def _rti(item: Any) -> Rti:
    return Rti(
        host=_text(item["host"]),
        port=_number(item["port"]),
        federation_id=_text(item["federation_id"]),
        federates=_number(item["federates"]),
        options=tuple(_text(word) for word in item["options"]),
    )


def _participant(item: Any) -> Participant:
    name, crate, platform = _text(item["name"]), Path(_text(item["crate"])), _text(item["platform"])
    is_rti = _text(item["role"]) == "rti"
    joint_rti = not is_rti and _truth(item["joint_rti"])
    number = None if is_rti else _number(item["id"])
    transient = not is_rti and _truth(item["transient"])
    if platform == "host":
        program, restarts = Path(_text(item["program"])), _truth(item["restarts"])
        options = tuple(_text(word) for word in item["options"])
        return Participant(
            name, crate, program=program, options=options, transient=transient, restarts=restarts, id=number
        )
    return Participant(
        name,
        crate,
        board=_text(item["board"]),
        kconfig=Path(_text(item["kconfig"])),
        overlay=Path(_text(item["overlay"])),
        is_rti=is_rti,
        joint_rti=joint_rti,
        network=None if item["network"] is None else _network(item["network"]),
        runner=_optional_text(item["runner"]),
        probe=_optional_text(item["probe"]),
        transient=transient,
        id=number,
        spare=None if item["spare"] is None else _spare(item["spare"]),
    )


def with_spares(participants: Sequence[Participant]) -> list[Participant]:
    """Return the participants, each followed by its image for a spare board, if it has one."""
    both = ((item, item.on_spare()) for item in participants)
    return [item for pair in both for item in pair if item is not None]


def _spare(item: Any) -> Spare:
    return Spare(
        Path(_text(item["kconfig"])),
        Path(_text(item["overlay"])),
        _network(item["network"]),
        _optional_text(item["probe"]),
    )


def _network(item: Any) -> Network:
    gateway = _optional_text(item["gateway"])
    return Network(
        ip=ipaddress.ip_interface((_text(item["ip"]), _number(item["prefix"]))),
        gateway=None if gateway is None else ipaddress.ip_address(gateway),
        mac=_optional_text(item["mac"]),
    )


def _truth(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{value!r} is neither true nor false")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not a text")
    return value


def _optional_text(value: Any) -> str | None:
    return None if value is None else _text(value)


def _number(value: Any) -> int:
    if not isinstance(value, int):
        raise TypeError(f"{value!r} is not a number")
    return value


def _unreadable(origin: str, reason: str) -> LfError:
    return LfError(
        f"{origin} is no description of a program: {reason}.",
        "Use an lfz and west commands of the same version.",
        "Build again without --no-lfc and --no-build.",
    )
