# SPDX-License-Identifier: Apache-2.0
"""Transient federates in images: `lfz ctl` starts, stops and swaps them while `lf-fed-run` runs their federation."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from test_virtual_boards import _allowed, _arm, _qemu
from test_zephyr import BOARDS, LIMIT_S, PROGRAMS, lf, started

from lf_west import compiler
from lf_west.workspace import REPOSITORY

__all__ = ["_allowed", "_arm", "_qemu"]

pytestmark = pytest.mark.zephyr

# The display's line about each missing answer.
GAP = re.compile(r"^display +\| answer \d+ came after \d+$", re.MULTILINE)
PAUSE = r"^display +\| (a pause of (\d+) ms in logical and (\d+) ms in physical time, with (\d+) questions for nobody)$"


class Run:
    """A federation that runs."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        """Nothing has been read."""
        self.process = process
        self.output = ""

    def wait_for(self, text: str) -> None:
        """Read until a line has this text."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.output += line
            if text in line:
                return
        raise AssertionError(f"no {text!r}: {self.output}")

    def ctl(self, *words: str) -> str:
        """Ask the run for something, and give its answer."""
        command = [str(compiler.find(None, os.environ).path), "ctl", *words, "--run", str(self.process.pid)]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return result.stdout

    def wait_for_state(self, text: str) -> None:
        """Ask for the state until it has this text, as long as the run lasts."""
        while text not in (answer := self.ctl()):
            assert self.process.poll() is None, f"no {text!r}: {answer}"

    def finish(self) -> str:
        """Read on to the end, and give all that was printed."""
        assert self.process.stdout is not None
        self.output += self.process.stdout.read()
        assert self.process.wait() == 0, self.output
        return self.output


@contextmanager
def running(deployment: str, *options: str) -> Iterator[Run]:
    """The federation of `HotSwap.lf`, built and then started."""
    file = PROGRAMS / "HotSwap.lf"
    lf("lf-fed-build", file, "--deployment", str(PROGRAMS / deployment), build=BOARDS)
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-run", str(file), "--no-build"]
    with started([*command, "--build-dir", str(BOARDS), "--timeout", str(LIMIT_S), *options]) as process:
        yield Run(process)


def assert_nothing_is_lost(output: str, *, is_handed_over: tuple[bool, bool]) -> None:
    """All answers that a meter has sent have come, in each of three lives, and some meters go on with the state."""
    sent = re.findall(r"^meter +\| gone after (\d+) answers$", output, re.MULTILINE)
    came = re.findall(r"^display +\| (\d+) answers came in life \d$", output, re.MULTILINE)
    assert len(sent) == 3, output
    assert came == sent, output
    assert GAP.search(output) is None, output
    all_answers = re.findall(r"^meter +\| (\d+) answers with those of the meters before$", output, re.MULTILINE)
    expected = [int(sent[0])]
    for count, is_next in zip(sent[1:], is_handed_over, strict=True):
        expected.append(int(count) + (expected[-1] if is_next else 0))
    assert [int(count) for count in all_answers] == expected, output


@pytest.mark.usefixtures("_allowed", "_arm", "_qemu")
def test_a_board_is_swapped_for_its_spare_and_back(capsys: pytest.CaptureFixture[str]) -> None:
    """The old image runs, the new board joins, the RTI tells the old one to leave: on two boards and this computer."""
    with running("hot_swap_boards.yaml") as run:
        run.wait_for("25 answers in life 1")
        assert run.ctl().splitlines()[1:] == ["  display: runs", "  meter: runs, transient"]
        assert "takes its place" in run.ctl("swap", "meter")
        run.wait_for("25 answers in life 2")
        assert "meter: runs on its spare board, transient" in run.ctl()
        # The first board is free again.
        assert "takes its place" in run.ctl("swap", "meter")
        output = run.finish()
    assert_nothing_is_lost(output, is_handed_over=(True, True))
    pauses = re.findall(PAUSE, output, re.MULTILINE)
    assert len(pauses) == 2, output
    with capsys.disabled():
        print("\na hot swap of qemu_cortex_m3:", *(text for text, *_ in pauses), sep="\n  ")


def test_an_image_leaves_returns_and_is_swapped() -> None:
    """The RTI tells an image to leave, which understands no signal."""
    with running("hot_swap_native_sim.yaml", "--without", "meter") as run:
        run.wait_for("meter takes part when you start it")
        run.wait_for_state("meter: does not run")
        assert "is started" in run.ctl("start", "meter")
        run.wait_for("25 answers in life 1")
        assert "asked to leave" in run.ctl("stop", "meter")
        run.wait_for("gone after")
        run.wait_for_state("meter: does not run")
        assert "is started" in run.ctl("start", "meter")
        run.wait_for("25 answers in life 2")
        assert "takes its place" in run.ctl("swap", "meter")
        output = run.finish()
    assert_nothing_is_lost(output, is_handed_over=(False, True))
