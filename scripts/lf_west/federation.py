# SPDX-License-Identifier: Apache-2.0
"""The command lines of a federation: its RTI, its programs, its images on native_sim and QEMU."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from ipaddress import AddressValueError, IPv4Address
from pathlib import Path

from lf_west import qemu
from lf_west.application import Application
from lf_west.description import Description, Participant, Rti
from lf_west.errors import LfError
from lf_west.image import image_in, is_native_sim
from lf_west.private_network import PrivateNetwork, plan_network

# Where the RTI is reached by what has this computer's network.
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
    # Where virtual boards are attached, if there are any.
    network: PrivateNetwork | None = None

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
        address = _ADDRESS if self.network is None else self.rti.host
        if participant.program is not None:
            return self._guarded([str(participant.program), "--rti", f"{address}:{port}", "--id", self.federation_id])
        image, board = image_file(self.application, participant), participant.board or ""
        interface = None if self.network is None else self.network.interfaces.get(participant.name)
        if not is_native_sim(board):
            # What it has to know is in the image.
            mac = None if participant.network is None else participant.network.mac
            return self._guarded(qemu.command(board, image, interface or "", mac))
        options = {"lf-federation-id": self.federation_id, "lf-rti-address": address, "lf-rti-port": port}
        if interface is not None:
            options["eth-if"] = interface
        return self._guarded([str(image), *(f"-{name}={value}" for name, value in options.items())])

    def status_in(self, participant: Participant) -> Callable[[str], int | None] | None:
        """How a federate tells its exit status, where it does not end with it."""
        return qemu.status_in if participant.board is not None and qemu.is_played(participant.board) else None

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
    if rti.log_waits_ns is not None:
        words += ["--log-waits", f"{rti.log_waits_ns} ns"]
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
    """The image of a federate."""
    return image_in(application.image_folder(participant.name), participant.board or "")


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
    _refuse_other_boards(participants)
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
    network = _network(participants, rti)
    if network is not None and not is_complete:
        raise LfError(
            "virtual boards are in a network of their own, which federates that are started by hand cannot join.",
            "Run all federates: leave -f out.",
        )
    if network is not None and port not in (None, rti.port):
        raise LfError(
            f"--rti-port: the images of virtual boards know the port {rti.port}, which is free in their own network.",
            "Leave --rti-port out.",
            "Say it in the deployment file: rti: { port: PORT }",
        )
    # Federates that are started elsewhere know only the id and the port that they were built with, and so do images.
    is_own = is_complete and network is None
    return Federation(
        lfz=lfz,
        rti=rti,
        federation_id=_unique_id(rti.federation_id) if is_own else rti.federation_id,
        port=port if port is not None else (0 if is_own else rti.port),
        participants=tuple(participants),
        application=application,
        network=network,
    )


def _refuse_other_boards(participants: Sequence[Participant]) -> None:
    """Only programs of this computer are run: hosts, native_sim, and QEMU where it plays a board with a network."""
    images = [item for item in participants if item.board is not None and not is_native_sim(item.board)]
    others = [item for item in images if not qemu.is_played(item.board or "")]
    if others:
        names = ", ".join(f"{item.name} ({item.board})" for item in others)
        rest = [item.name for item in participants if item not in others]
        raise LfError(
            f"these federates do not run on this computer: {names}.",
            *([f"Run the others here, and start those by hand: -f {' '.join(rest)}"] if rest else []),
            'Build them for this computer, without --no-build: -w "-b native_sim/native/64"',
            f"Put them on boards that QEMU plays, in the deployment file: {', '.join(qemu.boards())}",
        )
    nowhere = [item.name for item in images if item.network is None]
    if nowhere:
        raise LfError(
            f"these federates have no addresses in the network of virtual boards: {', '.join(nowhere)}.",
            "Give each an `ip` in a deployment file, and the RTI another one: --deployment FILE",
        )
    if images and not qemu.is_installed():
        raise LfError(
            f"there is no {qemu.PROGRAM}, which plays the boards of {', '.join(item.name for item in images)}.",
            "Install QEMU for Arm: apt install qemu-system-arm",
        )


def _network(participants: Sequence[Participant], rti: Rti) -> PrivateNetwork | None:
    """The network of the participants that have an interface of their own."""
    boards = {item.name: item.network for item in participants if item.network is not None}
    if not boards:
        return None
    try:
        address = IPv4Address(rti.host)
    except AddressValueError as error:
        raise LfError(
            f"the RTI has no IPv4 address in the network of virtual boards, but the name {rti.host}.",
            "Say it in the deployment file: rti: { ip: ADDRESS }",
        ) from error
    return plan_network(boards, address)


def _unique_id(name: str) -> str:
    """An id that no other run has, so that a federate which outlives its federation cannot join another one."""
    return f"{name[:_NAME_LENGTH_MAX]} {os.getpid()}-{time.time_ns():x}"
