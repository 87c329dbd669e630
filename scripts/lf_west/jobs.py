# SPDX-License-Identifier: Apache-2.0
"""Building several images at once: each prints into a log of its own, and the terminal shows how far they are."""

from __future__ import annotations

import collections
import re
import signal
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TextIO

from lf_west.children import Child, Children, Ended, Line, Signalled

# How much of the log of a failed build is shown, in lines.
TAIL_LINES = 40
# How ninja counts: [17/203] Building C object …
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
        self._logs: dict[Child, IO[str]] = {}
        self._jobs: dict[Child, Job] = {}
        self._started: dict[Child, float] = {}

    def run(self, jobs: Iterable[Job]) -> int:
        """Run all; 0, or the status of the first that failed, or 128 + n after signal n."""
        waiting = collections.deque(jobs)
        status = 0
        with Children() as children:
            try:
                while waiting or self._jobs:
                    while waiting and len(self._jobs) < self._parallel:
                        self._begin(children, waiting.popleft())
                    for event in children.wait(None):
                        ending = self._react(event)
                        if ending is not None and status == 0:
                            status = ending
                        if isinstance(event, Signalled):
                            return 128 + event.number
                    if status != 0:
                        waiting.clear()
                    self._screen.show(self._jobs.values())
            finally:
                for child in children.running():
                    # West and ninja pass it on, and end without leaving half a file behind.
                    child.send(signal.SIGTERM)
                for log in self._logs.values():
                    log.close()
                self._screen.clear()
        return status

    def _begin(self, children: Children, job: Job) -> None:
        job.log.parent.mkdir(parents=True, exist_ok=True)
        child = children.start(job.name, job.command, environment=self._environment, folder=job.folder)
        self._logs[child] = job.log.open("w", encoding="utf-8")
        self._jobs[child] = job
        self._started[child] = time.monotonic()
        self._screen.say(f"{job.name}: building; log: {job.log}")

    def _react(self, event: Line | Ended | Signalled) -> int | None:
        """Deal with an event; the status of a job that has failed."""
        if isinstance(event, Line):
            job = self._jobs[event.child]
            self._logs[event.child].write(event.text + "\n")
            job.tail.append(event.text)
            step = _STEP.match(event.text)
            if step:
                job.step = f"{step[1]}/{step[2]}"
        elif isinstance(event, Ended):
            job = self._jobs.pop(event.child)
            self._logs.pop(event.child).close()
            job.status = event.status
            job.seconds = time.monotonic() - self._started.pop(event.child)
            if event.status != 0:
                self._screen.say(f"{job.name}: failed after {job.seconds:.0f} s: the build {event.how}")
                return event.status
            self._screen.say(f"{job.name}: built in {job.seconds:.0f} s")
        return None


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
