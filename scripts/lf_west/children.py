# SPDX-License-Identifier: Apache-2.0
"""Child processes that are watched by one loop and of which none is left behind.

Each child leads a process group of its own, so that what it starts ends with it, and a ^C reaches it through here only.
A child is reaped only here, and signalled only before that, so a signal never reaches another process of that id.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import signal
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType, TracebackType
from typing import IO

from lf_west.errors import LfError

# A line without an end is passed on in pieces of this size, in bytes, so that it does not pile up here.
_LINE_LENGTH_MAX = 64 * 1024
_READ_SIZE = 64 * 1024
# More than a pipe can hold: somebody else goes on writing then.
_LAST_READS_MAX = 64
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass(frozen=True)
class Line:
    """A line of output, without its end."""

    child: Child
    is_error: bool
    text: str


@dataclass(frozen=True)
class Ended:
    """A child has ended, and its output has been read."""

    child: Child
    # As a shell gives it: 128 + n for signal n.
    status: int
    # For people, after its name: `ended with exit status 3`.
    how: str


@dataclass(frozen=True)
class Signalled:
    """This program has been told to stop."""

    number: int


Event = Line | Ended | Signalled


@dataclass(eq=False)
class Child:
    """A process that has been started."""

    name: str
    process: subprocess.Popen[bytes]
    end: int
    streams: dict[IO[bytes], bool] = field(default_factory=dict)
    partial: dict[IO[bytes], bytes] = field(default_factory=dict)
    running: bool = True
    # For a simulator, which goes on when the program in it has ended: the status that a line of its output tells. It
    # counts as ended then, but it is left until the others have ended too, as a board would be: it may still have to
    # tell its peers that it closes its connections.
    status_in: Callable[[str], int | None] | None = None
    told: int | None = None

    def send(self, number: signal.Signals) -> None:
        """Signal the whole process group, if it still runs."""
        if self.running:
            # The group can be gone although its leader has not been reaped yet.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, number)


class Children:
    """The loop. As a context manager it ends whatever still runs, however the block is left."""

    def __init__(self) -> None:
        """Watch nothing yet."""
        self._all: list[Child] = []
        self._selector = selectors.DefaultSelector()
        self._signals, self._signal_writer = os.pipe()
        self._handlers: dict[signal.Signals, object] = {}
        self._old_wakeup = -1

    def __enter__(self) -> Children:
        """Take over the signals that tell this program to stop."""
        for descriptor in (self._signals, self._signal_writer):
            os.set_blocking(descriptor, False)
        self._selector.register(self._signals, selectors.EVENT_READ)
        self._old_wakeup = signal.set_wakeup_fd(self._signal_writer, warn_on_full_buffer=False)
        for number in _SIGNALS:
            handler = signal.getsignal(number)
            # nohup and the like mean what they say.
            if handler is not signal.SIG_IGN:
                self._handlers[number] = handler
                signal.signal(number, _ignore)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave no process behind, and give the signals back."""
        for child in self._all:
            if child.running:
                self._reap(child)
        signal.set_wakeup_fd(self._old_wakeup)
        for number, handler in self._handlers.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
        self._selector.close()
        os.close(self._signals)
        os.close(self._signal_writer)

    def start(
        self,
        name: str,
        command: Sequence[str],
        *,
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
        status_in: Callable[[str], int | None] | None = None,
    ) -> Child:
        """Start a process without input. With `status_in` it is a simulator: it counts as ended when a line of its
        standard output tells the status of the program in it, which then counts as its own."""
        try:
            process = subprocess.Popen(
                command,
                cwd=folder,
                env=None if environment is None else dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
        except OSError as error:
            raise LfError(
                f"{name} cannot be started: {command[0]}: {error.strerror}.",
                "Check that the file exists and can be executed; building anew makes it.",
            ) from error
        try:
            end = os.pidfd_open(process.pid)
        except OSError as error:
            process.kill()
            process.communicate()
            raise LfError(f"{name} cannot be watched: {error.strerror}.", "Start fewer federates at once.") from error
        child = Child(name, process, end, status_in=status_in)
        self._all.append(child)
        self._selector.register(child.end, selectors.EVENT_READ, (child, None))
        for stream, is_error in ((process.stdout, False), (process.stderr, True)):
            if stream is not None:
                os.set_blocking(stream.fileno(), False)
                child.streams[stream] = is_error
                child.partial[stream] = b""
                self._selector.register(stream, selectors.EVENT_READ, (child, stream))
        return child

    def running(self) -> list[Child]:
        """The children that have not ended."""
        return [child for child in self._all if child.running and child.told is None]

    def wait(self, timeout_s: float | None) -> Iterator[Event]:
        """Wait for something to happen, at most this long, and give what has happened."""
        ended: list[Child] = []
        for key, _ in self._selector.select(timeout_s):
            if key.fileobj == self._signals:
                yield from (Signalled(number) for number in os.read(self._signals, 1024))
                continue
            child, stream = key.data
            if stream is None:
                ended.append(child)
            elif child.running:
                yield from self._read(child, stream)
        for child in ended:
            yield from self._finish(child)

    def _read(self, child: Child, stream: IO[bytes]) -> Iterator[Line | Ended]:
        """Read once, so that a child which never stops writing does not keep the others from being heard."""
        try:
            data = os.read(stream.fileno(), _READ_SIZE)
        except BlockingIOError:
            return
        if not data:
            yield from self._close(child, stream)
            return
        *lines, rest = (child.partial[stream] + data).split(b"\n")
        if len(rest) > _LINE_LENGTH_MAX:
            lines, rest = [*lines, rest], b""
        child.partial[stream] = rest
        for data in lines:
            line = _line(child, child.streams[stream], data)
            yield line
            yield from self._listen(child, line)

    def _listen(self, child: Child, line: Line) -> Iterator[Ended]:
        """Notice the end of the program in a simulator."""
        if child.status_in is not None and child.told is None and not line.is_error:
            child.told = child.status_in(line.text)
            if child.told is not None:
                yield Ended(child, *_ending(child.told))

    def _close(self, child: Child, stream: IO[bytes]) -> Iterator[Line]:
        """Stop reading a stream; a last line without an end counts, too."""
        rest = child.partial.pop(stream)
        is_error = child.streams.pop(stream)
        self._selector.unregister(stream)
        stream.close()
        if rest:
            yield _line(child, is_error, rest)

    def _finish(self, child: Child) -> Iterator[Event]:
        """Read what the child has written, and reap it. A descendant that keeps a stream open is not waited for."""
        # Until it is reaped the process keeps its id, so that the group is its own.
        child.send(signal.SIGKILL)
        for stream in list(child.streams):
            for _ in range(_LAST_READS_MAX):
                if stream not in child.streams or not _can_read(stream):
                    break
                yield from self._read(child, stream)
            if stream in child.streams:
                yield from self._close(child, stream)
        status = self._reap(child)
        if child.told is not None:
            return
        if child.status_in is not None and status == 0:
            yield Ended(child, 1, "ended before the program in it")
        else:
            yield Ended(child, *_ending(status))

    def _reap(self, child: Child) -> int:
        """Wait for a child that has ended or been killed; what is left of its group ends with it."""
        child.send(signal.SIGKILL)
        status = child.process.wait()
        child.running = False
        self._selector.unregister(child.end)
        os.close(child.end)
        for stream in list(child.streams):
            for _ in self._close(child, stream):
                pass
        return status


def _can_read(stream: IO[bytes]) -> bool:
    """Whether a stream can be read at once: there is data, or it has ended."""
    with selectors.DefaultSelector() as selector:
        selector.register(stream, selectors.EVENT_READ)
        return bool(selector.select(0))


def _line(child: Child, is_error: bool, data: bytes) -> Line:
    return Line(child, is_error, data.removesuffix(b"\r").decode("utf-8", errors="replace"))


def _ending(returncode: int) -> tuple[int, str]:
    if returncode >= 0:
        return returncode, f"ended with exit status {returncode}"
    number = -returncode
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = "unnamed"
    return 128 + number, f"was ended by signal {number} ({name})"


def _ignore(_number: int, _frame: FrameType | None) -> None:
    """The wake-up descriptor tells the loop; a handler only has to be there for that."""
