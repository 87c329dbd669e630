# SPDX-License-Identifier: Apache-2.0
"""The boards of the images, and the commands that flash them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west import probes
from lf_west.application import Application
from lf_west.description import Description, Participant
from lf_west.errors import LfError
from lf_west.image import is_native_sim, west_program
from lf_west.probes import Target
from lf_west.runners import Runner, image_runners, is_emulated, probe_arguments, takes_probe


@dataclass(frozen=True)
class Flash:
    """One image and its board."""

    name: str
    runner: str
    probe: str
    # The build folder.
    folder: Path
    # Further arguments for `west flash`.
    further: tuple[str, ...]

    @property
    def target(self) -> Target:
        """The board."""
        return Target(self.name, self.runner, self.probe)

    def command(self) -> list[str]:
        """West flashes what was built; that nothing is out of date has been seen to."""
        words = [*west_program(), "flash", "--no-rebuild", "--build-dir", str(self.folder), "--runner", self.runner]
        return [*words, *probe_arguments(self.runner, self.probe), *self.further]

    def text(self) -> str:
        """The command for a shell, with the program as a user writes it."""
        return shlex.join(["west", *self.command()[len(west_program()) :]])


def is_run_here(participant: Participant) -> bool:
    """Return whether a participant is a program of this computer, or its board's name is that of a simulated one."""
    board = participant.board
    return board is None or is_native_sim(board) or board.startswith("qemu_")


def select(described: Description, federates: Sequence[str], number: int | None, file: Path) -> list[Participant]:
    """Return the images to flash: those of -f, else all on boards, and only the first `number` of them.

    A spare board is flashed if the deployment names its probe, or if it is one of -f.
    """
    left_out = [] if federates else without_probe(described)
    chosen = [item for item in described.select(list(federates), spares=True) if item not in left_out]
    boards = [item for item in chosen if not is_run_here(item)]
    here = [item for item in chosen if is_run_here(item)]
    if here and (federates or not boards):
        raise _not_on_a_board(here, file)
    if number is not None and number > len(boards):
        raise LfError(
            f"-n asks for {number} boards, but only {len(boards)} of the program are on boards: "
            f"{', '.join(item.name for item in boards)}.",
            "Leave -n out to flash all of them.",
            "Give the others a board and a probe in the deployment file.",
        )
    # The RTI first, because federates look for it as soon as they run.
    return sorted(boards[:number], key=lambda item: not item.has_rti)


def without_probe(described: Description) -> list[Participant]:
    """Return the images for spare boards whose probes the deployment does not name."""
    places = described.select([], spares=True)
    return [item for item in places if item.spare_of is not None and item.probe is None and not is_run_here(item)]


def check_early(boards: Sequence[Participant]) -> None:
    """Refuse what is wrong with the probes whatever the runners are, so that nothing is built in vain."""
    probes.check([Target(item.name, item.runner, item.probe) for item in boards])


def plan(
    application: Application, boards: Sequence[Participant], known: dict[str, Runner], further: Sequence[str]
) -> list[Flash]:
    """Return the commands that flash the images; refuse by name those that cannot be flashed."""
    emulated, flashes = [], []
    for item in boards:
        folder = application.image_folder(item.name)
        if not (folder / "zephyr" / ".config").is_file():
            raise LfError(
                f"{item.name} is not built: there is no image in {folder}.",
                "Build it: leave --no-build out.",
                "Check that --build-dir is that of the build.",
            )
        if item.runner is None and image_runners(folder).default is None and is_emulated(folder):
            emulated.append(item)
            continue
        runner = _runner(item, folder, known)
        flashes.append(Flash(item.name, runner, item.probe or "", folder, tuple(further)))
    if emulated:
        raise _not_on_a_board(emulated, application.file)
    probes.check([flash.target for flash in flashes])
    return flashes


def _runner(item: Participant, folder: Path, known: dict[str, Runner]) -> str:
    """The runner of an image: the one that was deployed, else the board's."""
    available = image_runners(folder)
    fit = [name for name in available.names if name in known and known[name].flashes and takes_probe(name, known[name])]
    advice = [f"Name one of the board's runners in the deployment file: {', '.join(fit)}"] if fit else []
    name = item.runner or available.default
    if name is None:
        raise LfError(f"west cannot flash {item.board}, the board of {item.name}: it has no runner for that.", *advice)
    if name not in available.names:
        raise LfError(f"{item.board}, the board of {item.name}, cannot be flashed by the runner {name}.", *advice)
    # Runners of other modules than Zephyr are not known here; they are expected to do as Zephyr's.
    runner = known.get(name, Runner(flashes=True, takes_dev_id=True))
    if not runner.flashes:
        raise LfError(f"the runner {name} of {item.name} flashes no boards.", *advice)
    if not takes_probe(name, runner):
        raise LfError(
            f"the runner {name} of {item.name} cannot be told which probe to use.",
            *advice,
            f"Connect this board alone and flash it by hand: west flash --build-dir {folder} --runner {name}",
        )
    return name


def _not_on_a_board(participants: Sequence[Participant], file: Path) -> LfError:
    names = [f"{item.name} ({item.board or 'host'})" for item in participants]
    return LfError(
        f"nothing is flashed for {', '.join(names)}: this is run on this computer.",
        f"Run it with its RTI: {run_command(participants, file)}",
        "Put it onto a board in the deployment file: platform, ip, runner, probe.",
    )


def run_command(participants: Sequence[Participant], file: Path) -> str:
    """Return the command that runs participants on this computer."""
    return shlex.join(["west", "lf-fed-run", str(file), "-f", *(item.name for item in participants)])
