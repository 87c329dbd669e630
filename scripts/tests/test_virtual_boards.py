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
from conftest import BUILD
from test_private_networks import _allowed, processes_in
from test_zephyr import LIMIT_S, arm_toolchain, lf, started

from lf_west.workspace import REPOSITORY

__all__ = ["_allowed"]

pytestmark = [pytest.mark.zephyr, pytest.mark.usefixtures("_allowed", "_qemu")]


@pytest.fixture(scope="module")
def _qemu() -> None:
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("there is no qemu-system-arm")


def run(file: str, deployment: str) -> str:
    """Build and run a federation, and give what it printed."""
    arguments = ("--deployment", f"deployment/{deployment}.yaml", "--timeout", str(LIMIT_S))
    return lf("lf-fed-run", file, *arguments, build=BUILD / "boards", **arm_toolchain())


def assert_all_came(output: str) -> None:
    assert re.search(r"^receiver +\| received 3000 of 3000 messages in order, ", output, re.MULTILINE), output


def test_a_board_of_qemu_sends_to_native_sim_with_the_rti_on_this_computer() -> None:
    """Topology 2 of the message test."""
    output = run("message_test/src/MessageTest.lf", "topology2")
    assert_all_came(output)
    assert "sender   | lf: the program ended with status 0\n" in output


def test_a_killed_run_leaves_no_process_and_no_network() -> None:
    run("message_test/src/MessageTest.lf", "topology2")
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-run", "--no-build", "--build-dir"]
    file = str(REPOSITORY / "applications/message_test/src/MessageTest.lf")
    with started([*command, str(BUILD / "boards"), file]) as process:
        assert process.stdout is not None
        said = next(line for line in process.stdout if "sender   | " in line)
        assert said
        namespace = str(Path(f"/proc/{process.pid}/ns/net").readlink())
        ends = [os.pidfd_open(pid) for pid in processes_in(namespace)]
        # This command, the RTI, QEMU and native_sim.
        assert len(ends) == 4
        process.send_signal(signal.SIGKILL)
        for end in ends:
            with selectors.DefaultSelector() as selector:
                selector.register(end, selectors.EVENT_READ)
                assert selector.select(LIMIT_S)
            os.close(end)
    assert processes_in(namespace) == []
    devices = subprocess.run(["ip", "-brief", "link"], stdout=subprocess.PIPE, text=True, check=True).stdout
    assert "lfbridge" not in devices
