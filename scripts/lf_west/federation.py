# SPDX-License-Identifier: Apache-2.0
"""The command lines of a federation: its RTI, its programs, its native_sim images."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west.application import Application
from lf_west.description import Description, Participant, Rti
from lf_west.errors import LfError
from lf_west.image import is_native_sim

# Everything that is run here runs on this computer.
_ADDRESS = "127.0.0.1"
# What stands before the port in the line with which `lfz rti` says that it listens.
_LISTENING = "listening on TCP port "
# In characters; with what is added to it, a federation id has to fit into 255 bytes.
_NAME_LENGTH_MAX = 40


@dataclass(frozen=True)
class Federation:
    """What is to be run."""

    lfz: Path
    rti: Rti
    federation_id: str
    # 0 for any free one.
    port: int
    participants: tuple[Participant, ...]
    application: Application

    @property
    def rti_image(self) -> Participant | None:
        """The image with the RTI in it: one of its own or that of a federate. None where `lfz rti` is to run."""
        return next((item for item in self.participants if item.has_rti), None)

    def names(self) -> list[str]:
        """The participants' names, the RTI's first."""
        rti = [] if self.rti_image is not None else ["RTI"]
        return [*rti, *(participant.name for participant in self.participants)]

    def rti_command(self) -> list[str]:
        """The RTI, with the options that the program asks for."""
        return self._guarded(rti_words(self.rti, str(self.lfz), self.federation_id, self.port))

    def command(self, participant: Participant, port: int) -> list[str]:
        """A federate that joins this federation, whatever it was built for."""
        if participant.program is not None:
            return self._guarded([str(participant.program), "--rti", f"{_ADDRESS}:{port}", "--id", self.federation_id])
        image = image_file(self.application, participant)
        options = {"federation-id": self.federation_id, "rti-address": _ADDRESS, "rti-port": port}
        return self._guarded([str(image), *(f"-lf-{name}={value}" for name, value in options.items())])

    def _guarded(self, words: list[str]) -> list[str]:
        """Lets the kernel end the program when this one is killed, which no code here could do."""
        return [str(self.lfz), "guard", "--parent", str(os.getpid()), "--", *words]


def rti_words(rti: Rti, lfz: str, federation_id: str, port: int) -> list[str]:
    """The command line of an RTI on this computer, with the options that the program asks for."""
    words = [lfz, "rti", "--id", federation_id, "--port", str(port)]
    words += ["--number_of_federates", str(rti.federates)]
    if not rti.dnet:
        words.append("--dnet_disabled")
    if rti.auth:
        words.append("--auth")
    words += ["--clock_sync", rti.clock_sync]
    if rti.clock_sync == "on":
        words += ["period", str(rti.clock_sync_period_ns)]
    if rti.clock_sync != "off":
        words += ["exchanges-per-interval", str(rti.clock_sync_trials)]
    return words


def listening_port(line: str) -> int | None:
    """The port in the line that says where the RTI listens."""
    text = line.removeprefix(_LISTENING)
    return int(text) if text != line and text.isdigit() else None


def image_file(application: Application, participant: Participant) -> Path:
    """The native_sim image of a federate."""
    return application.image_folder(participant.name) / "zephyr" / "zephyr.exe"


def plan_federation(
    application: Application,
    described: Description,
    *,
    lfz: Path,
    federates: Sequence[str],
    port: int | None,
) -> Federation:
    """Work out who is run and how; what cannot be run on this computer is refused by name."""
    rti = described.rti
    if rti is None:
        raise LfError(
            f"{described.program} is not federated.",
            "Run its image: west build -t run -d BUILD_FOLDER",
            f"Run it as a program of this computer: lfz run {application.file}",
        )
    participants = described.select(list(federates))
    elsewhere = [item.name for item in described.participants if item.has_rti]
    if elsewhere and elsewhere[0] not in [item.name for item in participants]:
        raise LfError(
            f"the RTI is part of the image {elsewhere[0]}, which is left out.",
            f"Run it, too: -f {' '.join([*elsewhere, *federates])}",
        )
    boards = [item for item in participants if item.board is not None and not is_native_sim(item.board)]
    if boards:
        names = ", ".join(f"{item.name} ({item.board})" for item in boards)
        others = [item.name for item in participants if item not in boards]
        raise LfError(
            f"these federates do not run on this computer: {names}.",
            *([f"Run the others here, and start those by hand: -f {' '.join(others)}"] if others else []),
            'Build them for this computer, without --no-build: -w "-b native_sim/native/64"',
        )
    for item in participants:
        file = item.program or image_file(application, item)
        if not file.is_file():
            raise LfError(
                f"{item.name} is not built: there is no {file}.",
                "Build it: leave --no-build out.",
                "Check that --build-dir is that of the build.",
            )
    here = [item.name for item in participants if not item.is_rti]
    is_complete = len(here) == rti.federates
    if not federates and not is_complete:
        raise LfError(
            f"{described.program} has {rti.federates} federates, but {len(here)} are built: {', '.join(here)}.",
            "Build all: leave --no-build out.",
            f"Run those that are built, and start the others by hand: -f {' '.join(described.names())}",
        )
    # Federates that are started elsewhere know only the id and the port that they were built with.
    return Federation(
        lfz=lfz,
        rti=rti,
        federation_id=_unique_id(rti.federation_id) if is_complete else rti.federation_id,
        port=port if port is not None else (0 if is_complete else rti.port),
        participants=tuple(participants),
        application=application,
    )


def _unique_id(name: str) -> str:
    """An id that no other run has, so that a federate which outlives its federation cannot join another one."""
    return f"{name[:_NAME_LENGTH_MAX]} {os.getpid()}-{time.time_ns():x}"
