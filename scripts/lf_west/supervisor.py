# SPDX-License-Identifier: Apache-2.0
"""Runs a federation's participants together and ends them together.

The first cause to end decides the exit status. Who has to stop is given time, then asked (SIGTERM), then killed; the
times and the statuses are those of `lfz run`.
"""

from __future__ import annotations

import enum
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from lf_west.children import Child, Children, Ended, Line, Signalled
from lf_west.output import Output

# As of timeout(1).
STATUS_TIMED_OUT = 124
# As of a program that SIGPIPE ends.
STATUS_OUTPUT_CLOSED = 141


@dataclass(frozen=True)
class Limits:
    """How long a run may take, and how long its parts may take to end, all in seconds."""

    # The whole run; None for as long as it likes.
    run_s: float | None = None
    # For the others to end by themselves after the first failure, and after the end of the federation.
    grace_s: float = 5.0
    # After SIGTERM, before SIGKILL.
    terminate_s: float = 3.0


class _Stage(enum.Enum):
    RUNNING = enum.auto()
    # The others may end by themselves until then.
    WAITING = enum.auto()
    TERMINATING = enum.auto()
    KILLING = enum.auto()


class Supervisor:
    """One run. Start the participants inside of a `with` block over its children, then `finish`."""

    def __init__(self, children: Children, output: Output, limits: Limits) -> None:
        """The time limit counts from now."""
        self._children = children
        self._output = output
        self._limits = limits
        self._rti: Child | None = None
        self._stage = _Stage.RUNNING
        self._status = 0
        self._deadline = None if limits.run_s is None else time.monotonic() + limits.run_s
        # When the next stage begins.
        self._until: float | None = None

    def start_rti(
        self,
        name: str,
        command: Sequence[str],
        wanted: Callable[[str], int | None],
        environment: Mapping[str, str] | None = None,
        status_in: Callable[[str], int | None] | None = None,
    ) -> int | None:
        """Start the RTI and wait for the line of its standard output that `wanted` answers, which is not shown.

        None when the run has to end before that line comes.
        """
        self._rti = self._children.start(name, command, environment=environment, status_in=status_in)
        found: list[int] = []

        def look(line: Line) -> bool:
            answer = None if found or line.is_error else wanted(line.text)
            if answer is not None:
                found.append(answer)
            return answer is not None

        while not found and self._rti in self._children.running() and self._stage is _Stage.RUNNING:
            self._turn(look)
        return found[0] if found and self._stage is _Stage.RUNNING else None

    def start(
        self,
        name: str,
        command: Sequence[str],
        environment: Mapping[str, str] | None = None,
        status_in: Callable[[str], int | None] | None = None,
    ) -> None:
        """Start a federate; one on a simulator tells its status with a line that `status_in` understands."""
        self._children.start(name, command, environment=environment, status_in=status_in)

    def finish(self) -> int:
        """Run until all have ended; the exit status of the whole."""
        while self._children.running():
            self._turn(lambda _: False)
        return self._status

    def _turn(self, swallow: Callable[[Line], bool]) -> None:
        """Wait once, and deal with what has happened."""
        for event in self._children.wait(self._timeout()):
            if isinstance(event, Line):
                if not swallow(event):
                    self._output.line(event.child.name, event.is_error, event.text)
            elif isinstance(event, Ended):
                self._ended(event)
            else:
                self._signalled(event)
        if self._output.is_closed and self._stage is _Stage.RUNNING:
            self._cause(STATUS_OUTPUT_CLOSED)
            self._terminate()
        self._when_due()

    def _timeout(self) -> float | None:
        times = [moment for moment in (self._until, self._deadline) if moment is not None]
        return max(0.0, min(times) - time.monotonic()) if times else None

    def _ended(self, event: Ended) -> None:
        others = self._children.running()
        if event.status != 0:
            # Who was told to stop may end as it likes; who ends by itself says something about the program.
            if self._stage in (_Stage.RUNNING, _Stage.WAITING):
                rest = "; waiting for the others to end" if others else ""
                self._output.note(f"{event.child.name} {event.how}{rest}")
            self._fail(event.status)
        elif others and self._stage is _Stage.RUNNING and (event.child is self._rti or others == [self._rti]):
            # The RTI and the last federates end at the same time, in any order; who stays much longer hangs.
            self._until = time.monotonic() + self._limits.grace_s

    def _fail(self, status: int) -> None:
        self._cause(status)
        if self._stage is _Stage.RUNNING:
            self._stage = _Stage.WAITING
            self._until = time.monotonic() + self._limits.grace_s

    def _signalled(self, event: Signalled) -> None:
        if self._stage in (_Stage.RUNNING, _Stage.WAITING):
            self._output.note("interrupted; stopping all participants")
            self._cause(128 + event.number)
            self._terminate()
        else:
            self._kill()

    def _when_due(self) -> None:
        """Go on to the next stage when it is time."""
        now = time.monotonic()
        if self._deadline is not None and now >= self._deadline and self._children.running():
            if self._stage is _Stage.RUNNING:
                self._output.note(f"the time limit of {self._limits.run_s:g} s is reached; stopping all participants")
                self._cause(STATUS_TIMED_OUT)
            self._deadline = None
            if self._stage in (_Stage.RUNNING, _Stage.WAITING):
                self._terminate()
        if self._until is None or now < self._until:
            return
        names = ", ".join(child.name for child in self._children.running())
        if self._stage is _Stage.RUNNING:
            self._output.note(f"{names} did not end with the federation; stopping")
            self._cause(1)
            self._terminate()
        elif self._stage is _Stage.WAITING:
            self._output.note(f"stopping {names}")
            self._terminate()
        elif self._stage is _Stage.TERMINATING:
            self._output.note(f"killing {names}, which did not stop when asked to")
            self._kill()

    def _cause(self, status: int) -> None:
        """Only the first cause counts."""
        self._status = self._status or status

    def _terminate(self) -> None:
        self._stage = _Stage.TERMINATING
        self._deadline = None
        self._until = time.monotonic() + self._limits.terminate_s
        for child in self._children.running():
            child.send(signal.SIGTERM)

    def _kill(self) -> None:
        self._stage = _Stage.KILLING
        self._deadline = self._until = None
        for child in self._children.running():
            child.send(signal.SIGKILL)
