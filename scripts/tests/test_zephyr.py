# SPDX-License-Identifier: Apache-2.0
"""The applications of this repository, built as images for native_sim and run.

Everything is built in one folder, which is kept, so that each image is built once, and only what has changed the next
time.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY, find_workspace

pytestmark = pytest.mark.zephyr

BUILD = REPOSITORY / "target" / "west-tests"
# Where something hangs, the run ends by this, and not the person who waits. In seconds.
LIMIT_S = 300
GRID_RESULT = {"A": "closed", "B": "open", "C": "open", "D": "closed"}


@pytest.fixture(scope="module", autouse=True)
def _workspace() -> None:
    try:
        find_workspace(os.environ)
    except LfError as error:
        pytest.skip(f"no Zephyr workspace: {error.message}")


def lf(name: str, file: str, *arguments: str) -> str:
    """Run a command on an application, and give what it printed."""
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), name, str(REPOSITORY / "applications" / file)]
    result = subprocess.run(
        [*command, "--build-dir", str(BUILD), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout
    return result.stdout


def run(file: str, *arguments: str) -> str:
    return lf("lf-fed-run", file, "--timeout", str(LIMIT_S), *arguments)


def circuits(output: str) -> dict[str, str]:
    """What the units of the smart grid say about themselves."""
    lines = re.findall(r"^(\w) +\| ([A-D]): (open|closed), reaction time [0-9.]+ ms$", output, re.MULTILINE)
    assert all(federate.upper() == unit for federate, unit, _ in lines), output
    return {unit: state for _, unit, state in lines}


def test_hello_world_is_one_image() -> None:
    output = lf("lf-build", "hello_world/src/HelloWorld.lf", "-w", "-b native_sim/native/64")
    image = Path(output.split()[-1])
    assert image.is_relative_to(BUILD)
    result = subprocess.run([image], capture_output=True, text=True, timeout=LIMIT_S, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "Hello, world!" in result.stdout
    assert re.search(r"Goodbye after [34] greetings", result.stdout), result.stdout


def test_all_messages_arrive_in_order() -> None:
    deployment = ("--deployment", "deployment/native_sim.yaml")
    lf("lf-fed-build", "message_test/src/MessageTest.lf", *deployment)
    output = run("message_test/src/MessageTest.lf", "--no-build")
    assert "received 3000 of 3000 messages in order" in output


def test_the_smart_grid_heals_itself_on_native_sim() -> None:
    output = run("smart_grid/src/SmartGrid.lf", "--deployment", "deployment/native_sim.yaml")
    assert circuits(output) == GRID_RESULT, output


def test_the_smart_grid_heals_itself_with_units_on_linux_and_on_native_sim() -> None:
    output = run("smart_grid/src/SmartGrid.lf", "--deployment", "deployment/topology2.yaml")
    assert re.search(r"^a +host ", output, re.MULTILINE), output
    assert re.search(r"^b +native_sim/native/64 ", output, re.MULTILINE), output
    assert circuits(output) == GRID_RESULT, output


def test_a_wrong_setting_ends_the_build_with_its_log(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.conf"
    wrong.write_text("CONFIG_NO_SUCH_SYMBOL=y\n")
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-build"]
    file = str(REPOSITORY / "applications/message_test/src/MessageTest.lf")
    board = ["-w", "-b native_sim/native/64", "-f", "sender", "-c", str(wrong), "-d", str(tmp_path / "build")]
    result = subprocess.run([*command, file, *board], capture_output=True, text=True, check=False)
    assert result.returncode != 0
    assert "NO_SUCH_SYMBOL" in result.stderr
    assert "Read the whole log" in result.stderr
