# SPDX-License-Identifier: Apache-2.0
"""Builds that run at once: their logs, their progress, and how they end."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

from conftest import is_gone

from lf_west.jobs import Job, Jobs, Screen

FOREVER = "import signal\nwhile True: signal.pause()"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def job(name: str, text: str, folder: Path) -> Job:
    return Job(name, [sys.executable, "-c", text], folder / f"{name}.log", folder)


def test_jobs_run_at_once_and_show_their_progress(tmp_path: Path) -> None:
    # Each waits for the other, through a pipe.
    os.mkfifo(tmp_path / "fifo")
    jobs = [
        job("a", "open('fifo', 'w').close(); print('[3/9] x', flush=True)", tmp_path),
        job("b", "open('fifo').close()", tmp_path),
    ]
    said: list[str] = []
    terminal = Terminal()
    assert Jobs(os.environ, 2, Screen(said.append, terminal)).run(jobs) == 0
    assert [item.status for item in jobs] == [0, 0]
    assert "a 3/9" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")
    assert (tmp_path / "a.log").read_text() == "[3/9] x\n"
    assert jobs[0].step == "3/9"
    assert len(said) == 4


def test_an_interrupted_build_says_so(tmp_path: Path) -> None:
    told = f"print(os.getpid(), flush=True)\nos.kill({os.getpid()}, signal.SIGINT)"
    interrupt = f"import os, signal\n{told}\n{FOREVER}"
    jobs = [job("a", interrupt, tmp_path), job("b", "", tmp_path)]
    assert Jobs(os.environ, 1, Screen(lambda _: None, io.StringIO())).run(jobs) == 130
    assert [item.status for item in jobs] == [None, None]
    assert is_gone(int((tmp_path / "a.log").read_text()))


def test_after_a_failure_no_build_is_begun(tmp_path: Path) -> None:
    jobs = [job("a", "import sys; sys.exit('no such file')", tmp_path), job("b", "", tmp_path)]
    said: list[str] = []
    assert Jobs(os.environ, 1, Screen(said.append, io.StringIO())).run(jobs) == 1
    assert [item.status for item in jobs] == [1, None]
    assert list(jobs[0].tail) == ["no such file"]
    assert "the build ended with exit status 1" in said[-1]
