# SPDX-License-Identifier: Apache-2.0
"""The behavior of a federation on virtual boards when a network cable is taken out, or the RTI ends.

A network like that of `west lf-fed-run`, whose cables the test can take out: an interface that belongs to no bridge any
more still takes what the board sends, as a cable does that leads nowhere, and the board is told nothing.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from conftest import BUILD, listening_port
from test_private_networks import _allowed
from test_virtual_boards import _qemu
from test_zephyr import BOARDS, PROGRAMS, _arm, lf, started

from lf_west import compiler, description, qemu
from lf_west.application import Application, open_application
from lf_west.federation import Federation, Word, plan_federation
from lf_west.workspace import REPOSITORY

__all__ = ["_allowed", "_arm", "_qemu"]

pytestmark = [pytest.mark.zephyr, pytest.mark.usefixtures("_allowed", "_arm", "_qemu")]

PROGRAM = "message_test/src/MessageTest.lf"
DECENTRALIZED = "message_test/src/MessageTestDecentralized.lf"
ALL_CAME = "received 3000 of 3000 messages in order, "
RTI_LOST = re.compile("the connection to the RTI ended [a-z ]+: check the network cables and that the RTI is running")
# Packets that a cable which is out has swallowed, when it has been out for long enough to matter.
SWALLOWED = 3
# The same of a board that looks for others over IPv6: three groups that it joins, three times the question for a
# router, a second between two of them, and the question for the RTI.
SWALLOWED_AT_FIRST = 7
# Makes the network in a namespace, and keeps it until it is told to end.
KEEPER = """
import signal, sys
from lf_west.private_network import PrivateNetwork
from ipaddress import ip_interface
interfaces = {name: name for name in sys.argv[2:]}
PrivateNetwork(interfaces, (ip_interface(sys.argv[1]),), False).enter()
print("ready", flush=True)
signal.pause()
"""

Process = subprocess.Popen[str]


class Cables:
    """The message test, one participant after the other, in a network whose cables can be taken out."""

    def __init__(self, stack: ExitStack, federation: Federation) -> None:
        """Make the network."""
        assert federation.network is not None
        self.federation = federation
        self._stack = stack
        self._interfaces = federation.network.interfaces
        address = str(federation.network.addresses[0])
        words = [sys.executable, "-c", KEEPER, address, *self._interfaces.values()]
        keeper = stack.enter_context(started(words, PYTHONPATH=str(REPOSITORY / "scripts")))
        read_until(keeper, "ready")
        self._keeper = keeper.pid

    def rti(self) -> Process:
        """Start the RTI, and wait until it listens."""
        process = self._start(self.federation.rti_command())
        lines = iter(process.stdout or ())
        assert any(listening_port(line.strip()) is not None for line in lines)
        return process

    def federate(self, name: str, build: Path | None = None) -> Process:
        """Start a federate; with `build` its image of that folder."""
        federation = self.federation
        if build is not None:
            federation = replace(federation, application=application_in(build, PROGRAM))
        participant = next(item for item in federation.participants if item.name == name)
        return self._start(federation.command(participant))

    def begin(self) -> tuple[Process, Process, Process]:
        """Start the RTI, the sender and the receiver; they have begun, but nothing has been sent yet."""
        rti, sender, receiver = self.rti(), self.federate("sender"), self.federate("receiver")
        read_until(rti, "all federates have joined")
        return rti, sender, receiver

    def take_out(self, name: str) -> None:
        self._ip("link", "set", "dev", self._interfaces[name], "nomaster")

    def put_in(self, name: str) -> None:
        self._ip("link", "set", "dev", self._interfaces[name], "master", "lfbridge")

    def wait_until_missed(self, name: str, swallowed: int = SWALLOWED) -> None:
        """Wait until something is lost for the cable: the board sends it again and again, or this computer does."""
        before = self._sent_in_vain(name)
        while self._sent_in_vain(name) < before + swallowed:
            pass

    def _sent_in_vain(self, name: str) -> int:
        counters = Path(f"/proc/{self._keeper}/net/dev").read_text()
        line = next(line for line in counters.splitlines() if line.strip().startswith(f"{self._interfaces[name]}:"))
        heads, values = (
            line.split()[1:]
            for line in Path(f"/proc/{self._keeper}/net/snmp").read_text().splitlines()
            if line.startswith("Tcp:")
        )
        return int(line.split()[2]) + int(dict(zip(heads, values, strict=True))["RetransSegs"])

    def _ip(self, *words: str) -> None:
        subprocess.run([*self._inside(), "ip", *words], check=True)

    def _inside(self) -> list[str]:
        # Without root the namespace belongs to a user namespace of its own.
        user = [] if os.getuid() == 0 else ["--user", "--preserve-credentials"]
        return ["nsenter", "--target", str(self._keeper), "--net", *user, "--"]

    def _start(self, command: list[Word]) -> Process:
        # In a private network all is known from the beginning, so each word is a text.
        return self._stack.enter_context(started([*self._inside(), *map(str, command)]))


def read_until(process: Process, text: str) -> str:
    """Return the output of a process up to the line with this text."""
    lines = []
    for line in process.stdout or ():
        lines.append(line)
        if text in line:
            return "".join(lines)
    raise AssertionError(f"{text!r} did not come in:\n{''.join(lines)}")


def end_of(process: Process) -> tuple[str, int]:
    """Return the rest of a process's output, and its status; that of a program on a board of QEMU, which continues."""
    lines = []
    for line in process.stdout or ():
        lines.append(line)
        if line.startswith(qemu.STATUS_LINE):
            return "".join(lines), int(line.removeprefix(qemu.STATUS_LINE))
    return "".join(lines), process.wait()


def assert_all_came(rti: Process, sender: Process, receiver: Process) -> None:
    """The federation comes to its end, and nothing is missing."""
    said, status = end_of(receiver)
    assert (status, ALL_CAME in said) == (0, True), said
    for process in (sender, rti):
        said, status = end_of(process)
        assert status == 0, said


def application_in(build: Path, program: str) -> Application:
    return open_application(str(REPOSITORY / "applications" / program), str(build))


def planned(build: Path, program: str) -> Federation:
    """A program as it was built in a folder."""
    application = application_in(build, program)
    lfz = compiler.find(None, os.environ).path
    described = description.load(application.description)
    return plan_federation(application, described, lfz=lfz, federates=(), port=None)


@pytest.fixture(scope="module")
def built() -> Federation:
    """The message test, as other tests build it."""
    deployment = ("--deployment", "deployment/topology2.yaml")
    lf("lf-fed-build", PROGRAM, *deployment, build=BOARDS)
    return planned(BOARDS, PROGRAM)


@pytest.fixture
def cables(built: Federation) -> Iterator[Cables]:
    with ExitStack() as stack:
        yield Cables(stack, built)


@pytest.mark.parametrize("name", ["sender", "receiver"])
def test_a_cable_that_is_out_for_a_moment_costs_no_message(cables: Cables, name: str) -> None:
    rti, sender, receiver = cables.begin()
    cables.take_out(name)
    cables.wait_until_missed(name)
    cables.put_in(name)
    assert_all_came(rti, sender, receiver)


def test_a_cable_that_is_out_at_first_keeps_no_image_from_the_others_over_ipv6() -> None:
    """Decentralized, so that images reach each other by their addresses too, and not only the RTI."""
    deployment = ("--deployment", "deployment/native_sim_bridge_ipv6.yaml")
    lf("lf-fed-build", DECENTRALIZED, *deployment, build=BOARDS)
    with ExitStack() as stack:
        cables = Cables(stack, planned(BOARDS, DECENTRALIZED))
        rti, receiver = cables.rti(), cables.federate("receiver")
        cables.take_out("sender")
        sender = cables.federate("sender")
        cables.wait_until_missed("sender", SWALLOWED_AT_FIRST)
        cables.put_in("sender")
        assert_all_came(rti, sender, receiver)
    # One address was given, the other follows from that of IPv6.
    for name, mac in (("sender", "02:00:00:00:00:0a"), ("receiver", "02:ac:97:7c:b8:9e")):
        config = (BOARDS / "zephyr/MessageTestDecentralized" / name / "zephyr/.config").read_text()
        assert "CONFIG_NET_NATIVE_OFFLOADED_SOCKETS=y" not in config
        assert f'CONFIG_ETH_NATIVE_TAP_MAC_ADDR="{mac}"\n' in config


def test_a_cable_that_stays_out_ends_all_with_an_error(built: Federation) -> None:
    """Each of two federations loses another federate; both at once, because it takes most of a minute to be sure."""
    with ExitStack() as stack:
        begun = {}
        for name in ("sender", "receiver"):
            cables = Cables(stack, built)
            begun[name] = dict(zip(("RTI", "sender", "receiver"), cables.begin(), strict=True))
            cables.take_out(name)
        for lost, processes in begun.items():
            ends = {name: end_of(process) for name, process in processes.items()}
            assert {status for _, status in ends.values()} == {1}, ends
            other = "receiver" if lost == "sender" else "sender"
            number = 0 if lost == "sender" else 1
            assert f"federate {number} is lost: its connection ended without a word" in ends["RTI"][0]
            assert RTI_LOST.search(ends[lost][0]), ends
            assert "the RTI or another federate failed: see its output for the reason" in ends[other][0], ends


def test_federates_end_with_their_rti_and_can_join_another(cables: Cables) -> None:
    rti, *federates = cables.begin()
    rti.send_signal(signal.SIGKILL)
    for federate in federates:
        said, status = end_of(federate)
        assert (status, RTI_LOST.search(said) is not None) == (1, True), said
        federate.kill()
        federate.wait()
    assert_all_came(*cables.begin())


def test_a_board_that_starts_again_joins_the_next_federation(cables: Cables) -> None:
    build = BUILD / "starting-again"
    options = ("-f", "sender", "-c", str(PROGRAMS / "start_again.conf"), "--deployment", "deployment/topology2.yaml")
    lf("lf-fed-build", PROGRAM, *options, build=build)
    rti, receiver, sender = cables.rti(), cables.federate("receiver"), cables.federate("sender", build)
    read_until(rti, "all federates have joined")
    rti.send_signal(signal.SIGKILL)
    assert RTI_LOST.search(read_until(sender, "lf: the system starts again in 0 ms"))
    said, status = end_of(receiver)
    assert status == 1, said
    receiver.kill()
    receiver.wait()
    # The board has had no RTI to join until now.
    assert_all_came(cables.rti(), sender, cables.federate("receiver"))
