# SPDX-License-Identifier: Apache-2.0
"""Federations on virtual boards with Zephyr's own network stack, built and run for real."""

from __future__ import annotations

import os
import re
import selectors
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from test_private_networks import _allowed, processes_in
from test_zephyr import ALLOCATOR, BOARDS, GRID_RESULT, LIMIT_S, PROGRAMS, _arm, circuits, lf, started, symbols

from lf_west.workspace import REPOSITORY

__all__ = ["_allowed", "_arm"]

pytestmark = [pytest.mark.zephyr, pytest.mark.usefixtures("_allowed", "_arm", "_qemu")]

MESSAGE_TEST = "message_test/src/MessageTest.lf"
SMART_GRID = "smart_grid/src/SmartGrid.lf"


@pytest.fixture(scope="module")
def _qemu() -> None:
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("there is no qemu-system-arm")


def run(file: str, deployment: str, *options: str) -> str:
    """Build and run a federation, and give what it printed."""
    arguments = ("--deployment", f"deployment/{deployment}.yaml", "--timeout", str(LIMIT_S), *options)
    return lf("lf-fed-run", file, *arguments, build=BOARDS)


def assert_all_came(output: str) -> None:
    assert re.search(r"^receiver +\| received 3000 of 3000 messages in order, ", output, re.MULTILINE), output


def assert_all_ended_well(output: str, *boards: str) -> None:
    """Each of these boards has said so."""
    for board in boards:
        assert re.search(rf"^{board} +\| lf: the program ended with status 0$", output, re.MULTILINE), output


def assert_no_image_allocates(program: str, *images: str) -> None:
    """No image of a board has a function that allocates, nor a heap of the kernel's."""
    for image in images:
        linked = symbols(BOARDS / "zephyr" / program / image)
        assert [name for name in linked if ALLOCATOR.fullmatch(name)] == [], image
        # The kernel's own functions refer to its functions for heaps, but there is no heap.
        assert linked["_k_heap_list_start"] == linked["_k_heap_list_end"], image


def assert_debuggers_find(file: Path, program: str, image: str) -> None:
    """The first line of the first body has instructions in an image of a board."""
    line = next(number for number, text in enumerate(file.read_text().splitlines(), 2) if text.endswith("{="))
    elf = BOARDS / "zephyr" / program / image / "zephyr/zephyr.elf"
    command = ["gdb-multiarch", "-q", "-batch", "-nx", "-ex", f"info line {file.name}:{line}", str(elf)]
    output = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=True).stdout
    assert f'of "{file.resolve()}" starts at address' in output, output


def test_a_program_of_this_computer_sends_to_a_board() -> None:
    """Topology 1."""
    output = run(MESSAGE_TEST, "topology1")
    assert re.search(r"^sender +host ", output, re.MULTILINE), output
    assert_all_came(output)
    assert_all_ended_well(output, "receiver")


def test_a_board_sends_to_another_with_the_rti_on_this_computer() -> None:
    """Topology 2."""
    output = run(MESSAGE_TEST, "topology2")
    assert_all_came(output)
    assert_all_ended_well(output, "sender", "receiver")
    assert_debuggers_find(REPOSITORY / "applications" / MESSAGE_TEST, "MessageTest", "sender")


def test_the_smart_grid_heals_itself_with_the_rti_on_a_board_of_its_own() -> None:
    """Topology 4, with a native_sim image among the boards; both have Zephyr's own network stack."""
    output = run(SMART_GRID, "topology4")
    assert not re.search(r"^RTI +\|", output, re.MULTILINE), output
    assert circuits(output) == GRID_RESULT, output
    assert_all_ended_well(output, "rti", "b", "c", "d")
    assert_no_image_allocates("SmartGrid", "rti")


def test_the_smart_grid_heals_itself_on_boards_of_which_one_has_the_rti() -> None:
    """Topology 3, embedded only."""
    output = run(SMART_GRID, "topology3")
    assert not re.search(r"^RTI +\|", output, re.MULTILINE), output
    assert circuits(output) == GRID_RESULT, output
    assert_all_ended_well(output, "a", "b", "c", "d")
    assert_no_image_allocates("SmartGrid", "a", "b", "c", "d")


def test_boards_send_to_each_other_without_any_other_computer() -> None:
    """Topology 4, embedded only."""
    output = run(MESSAGE_TEST, "topology4")
    assert not re.search(r"^RTI +\|", output, re.MULTILINE), output
    assert_all_came(output)
    assert_all_ended_well(output, "rti", "sender", "receiver")
    assert_no_image_allocates("MessageTest", "rti", "sender", "receiver")


def test_no_message_is_lost_between_boards_without_an_rti_between_them() -> None:
    """Decentralized, and faster than the receiver can go on for long; one of the boards is an mps2/an385."""
    output = run("message_test/src/MessageTestDecentralized.lf", "mps2")
    assert re.search(r"^sender +mps2/an385 ", output, re.MULTILINE), output
    assert_all_came(output)
    assert_all_ended_well(output, "sender", "receiver")
    assert_no_image_allocates("MessageTestDecentralized", "sender", "receiver")


def test_native_sim_images_have_addresses_of_their_own_on_one_bridge() -> None:
    """Decentralized, so that they reach each other by their addresses, and not only the RTI.

    The sender has fewer buffers than it fills in a turn.
    """
    options = ("-c", str(PROGRAMS / "few_buffers.conf"))
    output = run("message_test/src/MessageTestDecentralized.lf", "native_sim_bridge", *options)
    assert_all_came(output)
    hint = r"^sender .*\(CONFIG_NET_BUF_TX_COUNT, CONFIG_NET_PKT_TX_COUNT\)$"
    assert re.search(hint, output, re.MULTILINE), output
    for name, mac in (("sender", "02:00:00:00:00:0a"), ("receiver", "02:00:0a:00:00:03")):
        config = (BOARDS / "zephyr/MessageTestDecentralized" / name / "zephyr/.config").read_text()
        assert "CONFIG_NET_NATIVE_OFFLOADED_SOCKETS=y" not in config
        assert f'CONFIG_ETH_NATIVE_TAP_MAC_ADDR="{mac}"\n' in config
    # Only the driver that gives native_sim the host's sockets takes memory from a heap.
    assert_no_image_allocates("MessageTestDecentralized", "sender", "receiver")


def test_boards_reach_the_rti_over_ipv6() -> None:
    """With Zephyr's own network stack on both, and without IPv4."""
    output = run(MESSAGE_TEST, "ipv6")
    assert_all_came(output)
    assert_all_ended_well(output, "receiver")
    for name in ("sender", "receiver"):
        config = (BOARDS / "zephyr/MessageTest" / name / "zephyr/.config").read_text()
        assert "CONFIG_NET_IPV6=y\n" in config
        assert "CONFIG_NET_IPV4=y\n" not in config


def test_a_killed_run_leaves_no_process_and_no_network() -> None:
    run(MESSAGE_TEST, "topology2")
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-run", "--no-build", "--build-dir"]
    with started([*command, str(BOARDS), str(REPOSITORY / "applications" / MESSAGE_TEST)]) as process:
        assert process.stdout is not None
        said = next(line for line in process.stdout if "sender   | " in line)
        assert said
        namespace = str(Path(f"/proc/{process.pid}/ns/net").readlink())
        ends = [os.pidfd_open(pid) for pid in processes_in(namespace)]
        # This command, what ends all others when it is gone, the RTI, and QEMU for each board.
        assert len(ends) == 5
        process.send_signal(signal.SIGKILL)
        for end in ends:
            with selectors.DefaultSelector() as selector:
                selector.register(end, selectors.EVENT_READ)
                assert selector.select(LIMIT_S)
            os.close(end)
    assert processes_in(namespace) == []
    devices = subprocess.run(["ip", "-brief", "link"], stdout=subprocess.PIPE, text=True, check=True).stdout
    assert "lfbridge" not in devices
