# SPDX-License-Identifier: Apache-2.0
"""The command lines of a federation: its RTI, its programs, its images on native_sim and QEMU."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from ipaddress import ip_address
from pathlib import Path
from typing import Any

from lf_west import qemu
from lf_west.application import Application
from lf_west.description import Description, Participant, Rti, with_spares
from lf_west.errors import LfError
from lf_west.image import image_in, is_native_sim
from lf_west.private_network import PrivateNetwork, plan_network

# The address of the RTI for programs in this computer's network.
_ADDRESS, _ADDRESS_V6 = "127.0.0.1", "::1"
# The time that virtual boards have to end with the others. The message that a connection has ended may be lost where
# the computer is busy, and TCP repeats it after pauses that become longer.
_BOARDS_GRACE_NS = 30_000_000_000

# A word of a command line: a text, or one and behind it what `lfz supervise` knows when it starts the process.
Word = str | dict[str, str]


@dataclass(frozen=True)
class Bench:
    """The environment of the boards in a run: an oscilloscope, moved inputs, and clock drifts."""

    # Where what all pins do is written down, if it is.
    vcd: Path | None = None
    # The script that moves inputs, as for `lfz run --devices`.
    devices: Path | None = None
    # The drift of the clock of a native_sim image, as a fraction, by the federate's name.
    drifts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Federation:
    """The federation to run."""

    lfz: Path
    rti: Rti
    # Whether this run has a federation id of its own, and not the one that federates elsewhere were built with.
    is_own: bool
    # 0 for any free one.
    port: int
    participants: tuple[Participant, ...]
    application: Application
    # The names of those that run only when `lfz ctl start` starts them.
    without: Sequence[str] = ()
    # Where virtual boards are attached, if there are any.
    network: PrivateNetwork | None = None
    bench: Bench = field(default_factory=Bench)

    @property
    def rti_image(self) -> Participant | None:
        """The image with the RTI in it: one of its own or that of a federate. None where `lfz rti` is to run."""
        return next((item for item in self.participants if item.has_rti), None)

    def rti_command(self) -> list[Word]:
        """The RTI, with the options that the program asks for."""
        return [str(self.lfz), "rti", "--id", self._id(), "--port", str(self.port), *self.rti.options]

    def command(self, participant: Participant) -> list[Word]:
        """A federate that joins this federation, or the image with its RTI, whatever it was built for."""
        address = self._rti_address()
        if participant.program is not None:
            host = f"[{address}]" if ":" in address else address
            words: list[Word] = [str(participant.program), "--rti", self._port(f"{host}:", participant)]
            words += ["--id", self._id(), *participant.options]
            return [*words, *self._bench_words(participant, "--vcd", "--devices")]
        image, board = image_file(self.application, participant), participant.board or ""
        interface = None if self.network is None else self.network.interfaces.get(participant.name)
        if not is_native_sim(board):
            if self.bench.devices is not None:
                # Lines that no participant reads are refused.
                self._moves(participant)
            # All that it has to know is in the image.
            mac = None if participant.network is None else participant.network.mac
            is_recorded = self.bench.vcd is not None and qemu.has_pins(board)
            trace = self._recording(participant) if is_recorded else None
            return [*qemu.command(board, image, interface or "", mac, trace)]
        words = [str(image), self._id("-lf-federation-id="), f"-lf-rti-address={address}"]
        words.append(self._port("-lf-rti-port=", participant))
        words += self._bench_words(participant, "-lf-vcd=", "-lf-devices=")
        return words if interface is None else [*words, f"-eth-if={interface}"]

    def _rti_address(self) -> str:
        """Return its address on this computer, of the same family as the one that the program names."""
        if self.network is not None:
            return self.rti.host
        return _ADDRESS_V6 if ":" in self.rti.host else _ADDRESS

    def description(self, timeout_ns: int | None, user: int | None = None) -> dict[str, Any]:
        """Return the description for `lfz supervise`; the RTI itself prints its address.

        `lfz ctl` of this user controls the run.
        """
        image = self.rti_image
        federates = [item for item in self.participants if item is not image]
        return {
            "version": 1,
            "speaker": "west",
            "id": {"begins_with" if self.is_own else "exactly": self.rti.federation_id},
            "user": user,
            "timeout_ns": timeout_ns,
            "grace_ns": None if self.network is None else _BOARDS_GRACE_NS,
            "rti": self._rti_process() if image is None else self._process(image),
            "federates": [self._process(item) for item in federates if item.name not in self.without],
            "left_out": [self._process(item) for item in federates if item.name in self.without],
            "oscilloscope": self._oscilloscope(),
        }

    def _has_pins(self, participant: Participant) -> bool:
        """Return whether its pins can be recorded: a program, or an image that has the options for it."""
        if participant.program is not None:
            return True
        configuration = self.application.image_folder(participant.name) / "zephyr" / ".config"
        return "CONFIG_LF_OSCILLOSCOPE=y" in configuration.read_text(encoding="utf-8").splitlines()

    def _recording(self, participant: Participant) -> Path:
        return self.application.image_folder(participant.name).with_suffix(".vcd")

    def _oscilloscope(self) -> dict[str, Any] | None:
        if self.bench.vcd is None:
            return None
        parts = []
        for item in with_spares(self.participants):
            is_trace = item.board is not None and qemu.has_pins(item.board)
            if is_trace or self._has_pins(item):
                parts.append({"name": item.name, "file": str(self._recording(item)), "is_trace": is_trace})
        return {"file": str(self.bench.vcd), "parts": parts}

    def _bench_words(self, participant: Participant, vcd: str, devices: str) -> list[Word]:
        """The options of a program, which has their values as words of their own, or of an image on native_sim."""
        options = []
        if self.bench.vcd is not None and self._has_pins(participant):
            options.append((vcd, str(self._recording(participant))))
        if self.bench.devices is not None and participant.program is not None:
            options.append((devices, str(self.bench.devices)))
        elif self.bench.devices is not None and not participant.is_rti:
            # Lines that no participant reads are refused in any case.
            moves = self._moves(participant)
            if self._has_pins(participant):
                options.append((devices, str(moves)))
        drift = self.bench.drifts.get(participant.federate)
        if drift is not None:
            options.append(("-rt-drift=", repr(drift)))
        return [word for option in options for word in ([option[0] + option[1]] if "=" in option[0] else option)]

    def _takes(self, participant: Participant) -> str:
        """Return the part of a script for devices that a participant reads."""
        if participant.program is not None:
            return "all"
        return "pins" if self._has_pins(participant) else "nothing"

    def _moves(self, participant: Participant) -> Path:
        """Return the moves of the script for an image, which does not read the script itself."""
        readers = ",".join(f"{item.name}={self._takes(item)}" for item in self.participants if not item.is_rti)
        command = [str(self.lfz), "moves", str(self.bench.devices), participant.federate, "--readers", readers]
        result = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        if result.returncode != 0:
            raise LfError(f"the script {self.bench.devices} for --devices cannot be used.")
        file = self._recording(participant).with_suffix(".moves")
        file.write_text(result.stdout, encoding="utf-8")
        return file

    def _rti_process(self) -> dict[str, Any]:
        # It takes commands where it is the only one that can tell a federate to leave.
        takes_commands = any(item.transient and item.is_image for item in self.participants)
        words = [*self.rti_command(), *(["--commands"] if takes_commands else [])]
        return {"name": "RTI", "words": words, "streams": "commands" if takes_commands else "lines"}

    def _instances(self, participant: Participant) -> str | dict[str, list[Word]]:
        """Return how many instances can run at the same time: one for each network interface."""
        if self.network is None or participant.name not in self.network.interfaces:
            return "any"
        spare = participant.on_spare()
        return "one" if spare is None else {"spare": self.command(spare)}

    def _process(self, participant: Participant) -> dict[str, Any]:
        is_played = participant.board is not None and qemu.is_played(participant.board)
        status_line = qemu.STATUS_LINE if is_played else None
        return {
            "name": participant.name,
            "words": self.command(participant),
            # Programs of this computer say themselves where in the LF program they are.
            "crate": None if participant.program is not None else str(participant.crate),
            "status_line": status_line,
            "transient": participant.transient,
            "restarts": participant.restarts,
            "image_id": participant.id if participant.is_image and participant.transient else None,
            "instances": self._instances(participant),
        }

    def _id(self, before: str = "") -> Word:
        return {"before": before, "known": "federation_id"} if self.is_own else before + self.rti.federation_id

    def _port(self, before: str, participant: Participant) -> Word:
        is_known = self.port != 0 or participant.has_rti
        return f"{before}{self.port}" if is_known else {"before": before, "known": "rti_port"}


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
    bench: Bench | None = None,
    without: Sequence[str] = (),
) -> Federation:
    """Determine the processes to run; refuse by name participants that cannot run on this computer."""
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
    _refuse_other_drifts(participants, bench or Bench())
    _refuse_left_out(described, participants, without)
    for item in with_spares(participants):
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
        is_own=is_own,
        port=port if port is not None else (0 if is_own else rti.port),
        participants=tuple(participants),
        application=application,
        without=without,
        network=network,
        bench=bench or Bench(),
    )


def _refuse_left_out(described: Description, participants: Sequence[Participant], without: Sequence[str]) -> None:
    """Only a federate of this run that does not have the RTI can be started later."""
    here = [item.name for item in participants]
    for item in described.select(list(without)) if without else []:
        if item.has_rti or item.name not in here:
            reason = "has the RTI, which the others need" if item.has_rti else "is not among those of -f"
            raise LfError(f"--without: {item.name} {reason}.", f"Leave it out: --without is for {', '.join(here)}")


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
            qemu.ADVICE,
        )


def _refuse_other_drifts(participants: Sequence[Participant], bench: Bench) -> None:
    """Only native_sim has a clock that is told how fast it is."""
    images = [item.name for item in participants if item.board is not None and is_native_sim(item.board)]
    for name in bench.drifts:
        if name not in images:
            there_are = f"there are {', '.join(images)}" if images else "there is none"
            raise LfError(f"--drift: {name} is no image on native_sim; {there_are}.")


def _network(participants: Sequence[Participant], rti: Rti) -> PrivateNetwork | None:
    """The network of the participants that have an interface of their own."""
    places = [place for item in participants for place in (item, item.on_spare()) if place is not None]
    boards = {place.name: place.network for place in places if place.network is not None}
    if not boards:
        return None
    try:
        address = ip_address(rti.host)
    except ValueError as error:
        raise LfError(
            f"the RTI has no address in the network of virtual boards, but the name {rti.host}.",
            "Say it in the deployment file: rti: { ip: ADDRESS }",
        ) from error
    return plan_network(boards, address)
