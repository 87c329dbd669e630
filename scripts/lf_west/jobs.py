# SPDX-License-Identifier: Apache-2.0
"""Building several images at once: each prints into a log of its own, and the terminal shows how far they are."""

from __future__ import annotations

import collections
import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import TextIO

from lf_west.errors import LfError

# The number of lines of a failed build's log that are shown.
TAIL_LINES = 40
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# The progress of ninja: [17/203] Building C object …
_STEP = re.compile(r"^\[(\d+)/(\d+)\] ")


@dataclass
class Job:
    """One build."""

    name: str
    command: Sequence[str]
    log: Path
    folder: Path
    # Filled while it runs.
    status: int | None = None
    seconds: float = 0.0
    step: str = ""
    tail: collections.deque[str] = field(default_factory=lambda: collections.deque(maxlen=TAIL_LINES))


class Jobs:
    """Runs jobs; after the first failure no new one is begun, and those that run are finished."""

    def __init__(self, environment: Mapping[str, str], parallel: int, screen: Screen) -> None:
        """At most `parallel` jobs run at once."""
        self._environment = environment
        self._parallel = parallel
        self._screen = screen
        # Around the screen and what is shown there.
        self._lock = threading.Lock()
        self._running: dict[str, Job] = {}
        self._processes: list[subprocess.Popen[str]] = []
        # Of the first that failed, or 128 + n after signal n.
        self._status = 0
        self._is_interrupted = False

    def run(self, jobs: Iterable[Job]) -> int:
        """Run all; 0, or the status of the first that failed, or 128 + n after signal n."""
        heard = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
        before = {number: signal.signal(number, self._interrupt) for number in heard}
        try:
            with ThreadPoolExecutor(self._parallel) as pool:
                for _ in pool.map(self._build, jobs):
                    pass
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            self._screen.clear()
        return self._status

    def _interrupt(self, number: int, _frame: FrameType | None) -> None:
        """End all. West and ninja leave no half files behind when they are asked; the second time they are not."""
        request = signal.SIGKILL if self._is_interrupted else signal.SIGTERM
        self._is_interrupted, self._status = True, self._status or 128 + number
        for process in self._processes:
            _send(process, request)

    def _build(self, job: Job) -> None:
        if self._status != 0:
            return
        job.log.parent.mkdir(parents=True, exist_ok=True)
        begin = time.monotonic()
        with job.log.open("w", encoding="utf-8") as log, self._started(job) as process:
            self._processes.append(process)
            if self._is_interrupted:
                _send(process, signal.SIGTERM)
            with self._lock:
                self._running[job.name] = job
                self._screen.say(f"{job.name}: building; log: {job.log}")
                self._screen.show(self._running.values())
            for line in process.stdout or ():
                log.write(line)
                job.tail.append(line.rstrip("\n"))
                step = _STEP.match(line)
                if step:
                    job.step = f"{step[1]}/{step[2]}"
                    with self._lock:
                        self._screen.show(self._running.values())
        job.seconds = time.monotonic() - begin
        with self._lock:
            del self._running[job.name]
            if not self._is_interrupted:
                self._end(job, process.returncode)

    def _started(self, job: Job) -> subprocess.Popen[str]:
        """Start a job in a process group of its own, so that its descendants can be stopped, too."""
        try:
            return subprocess.Popen(
                job.command,
                cwd=job.folder,
                env=dict(self._environment),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                encoding="utf-8",
                errors="replace",
                start_new_session=True,
            )
        except OSError as error:
            raise LfError(f"{job.name} cannot be built: {job.command[0]}: {error.strerror}.") from error

    def _end(self, job: Job, returncode: int) -> None:
        job.status = returncode if returncode >= 0 else 128 - returncode
        if returncode == 0:
            self._screen.say(f"{job.name}: built in {job.seconds:.0f} s")
        else:
            how = f"ended with exit status {returncode}" if returncode > 0 else f"was ended by signal {-returncode}"
            self._screen.say(f"{job.name}: failed after {job.seconds:.0f} s: the build {how}")
        self._status = self._status or job.status


def _send(process: subprocess.Popen[str], request: signal.Signals) -> None:
    """Signal the whole process group of a build that has not ended."""
    with contextlib.suppress(ProcessLookupError):
        if process.returncode is None:
            os.killpg(process.pid, request)


class Screen:
    """Lines that stay, and on a terminal below them one that shows the progress."""

    def __init__(self, say: Callable[[str], None], terminal: TextIO | None = None) -> None:
        """`say` prints a line that stays."""
        self._say = say
        stream = sys.stdout if terminal is None else terminal
        self._terminal = stream if stream.isatty() else None
        self._shown = ""

    def say(self, text: str) -> None:
        """Print a line that stays."""
        self.clear()
        self._say(text)

    def show(self, jobs: Iterable[Job]) -> None:
        """Show how far the jobs are."""
        text = "  ".join(f"{job.name} {job.step or '…'}" for job in jobs)
        if self._terminal is not None and text != self._shown:
            self._terminal.write(f"\r\x1b[K{text}")
            self._terminal.flush()
            self._shown = text

    def clear(self) -> None:
        """Take the progress away."""
        if self._terminal is not None and self._shown:
            self._terminal.write("\r\x1b[K")
            self._terminal.flush()
            self._shown = ""
