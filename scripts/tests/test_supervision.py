# SPDX-License-Identifier: Apache-2.0
"""Real processes under supervision: their output, their ends, and that none is left behind."""

from __future__ import annotations

import io
import os
import signal
import sys
from pathlib import Path

import pytest
from conftest import is_gone

from lf_west.children import Child, Children, Ended, Event, Line, Signalled
from lf_west.errors import LfError
from lf_west.jobs import Job, Jobs, Screen
from lf_west.output import Output
from lf_west.supervisor import Limits, Supervisor

# Long enough that no test reaches it, unless that is what the test is about.
PATIENT = Limits(grace_s=600, terminate_s=600)
FOREVER = "import signal\nwhile True: signal.pause()"
STUBBORN = f"import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\nprint('ready', flush=True)\n{FOREVER}"


def python(text: str) -> list[str]:
    return [sys.executable, "-c", text]


def wait_until_gone(pid: int) -> None:
    """The kernel has been told to kill it, and takes a moment to do so."""
    while not is_gone(pid):
        os.sched_yield()


def supervise(programs: dict[str, str], limits: Limits = PATIENT, rti: str | None = None) -> tuple[int, str, str]:
    """Run programs to their end: the exit status, the output and the error output."""
    standard, error = io.StringIO(), io.StringIO()
    with Children() as children:
        supervisor = Supervisor(children, Output("west", ["RTI", *programs], standard, error), limits)
        port: int | None = 0
        if rti is not None:
            port = supervisor.start_rti("RTI", python(rti), lambda line: 7 if line == "port 7" else None)
        if port is not None:
            for name, text in programs.items():
                supervisor.start(name, python(text))
        status = supervisor.finish()
    return status, standard.getvalue(), error.getvalue()


def test_lines_bear_the_name_of_their_writer() -> None:
    status, standard, error = supervise({"a": "print('one\\ntwo')", "longer": "import sys; sys.stderr.write('three')"})
    assert status == 0
    assert standard == "a      | one\na      | two\n"
    assert error == "longer | three\n"


def test_the_line_that_was_waited_for_is_not_shown() -> None:
    status, standard, _ = supervise({"a": "print('hello')"}, rti="print('before'); print('port 7'); print('after')")
    assert status == 0
    assert sorted(standard.splitlines()) == ["RTI  | after", "RTI  | before", "a    | hello"]


def test_federates_are_not_started_without_their_rti() -> None:
    status, standard, error = supervise({"a": "print('hello')"}, rti="import sys; sys.exit('no port is free')")
    assert status == 1
    assert standard == ""
    assert error == "RTI  | no port is free\nwest | RTI ended with exit status 1\n"


def test_the_first_failure_decides_and_ends_the_others() -> None:
    limits = Limits(grace_s=0, terminate_s=600)
    status, _, error = supervise({"a": "import sys; sys.exit(5)", "b": FOREVER, "c": FOREVER}, limits)
    assert status == 5
    assert "west | a ended with exit status 5; waiting for the others to end\n" in error
    assert "west | stopping b, c\n" in error


def test_others_may_end_by_themselves_after_a_failure(tmp_path: Path) -> None:
    # b runs until the FIFO has no writer any more, which is when a has ended.
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    fail = f"import sys; f = open({str(fifo)!r}, 'w'); sys.exit(5)"
    wait = f"print('read', open({str(fifo)!r}).read())"
    status, standard, error = supervise({"a": fail, "b": wait})
    assert status == 5
    assert standard == "b    | read \n"
    assert "stopping" not in error


def test_a_signal_that_ends_a_participant_is_named() -> None:
    status, _, error = supervise({"a": "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"})
    assert status == 128 + signal.SIGSEGV
    assert "a was ended by signal 11 (SIGSEGV)" in error


def test_the_time_limit_ends_all() -> None:
    status, _, error = supervise({"a": FOREVER}, Limits(run_s=0, terminate_s=600))
    assert status == 124
    assert error == "west | the time limit of 0 s is reached; stopping all participants\n"


def test_who_does_not_stop_is_killed() -> None:
    limits = Limits(grace_s=0, terminate_s=0)
    fail = "import sys; sys.exit(2)"
    status, _, error = supervise({"stubborn": STUBBORN, "a": fail}, limits)
    assert status == 2
    assert "killing stubborn, which did not stop when asked to" in error


def test_an_rti_that_outlives_its_federates_is_a_failure() -> None:
    limits = Limits(grace_s=0, terminate_s=600)
    status, _, error = supervise({"a": ""}, limits, rti=f"print('port 7', flush=True)\n{FOREVER}")
    assert status == 1
    assert "RTI did not end with the federation; stopping" in error


def test_an_interruption_ends_all_with_its_status() -> None:
    standard, error = io.StringIO(), io.StringIO()
    with Children() as children:
        supervisor = Supervisor(children, Output("west", ["a"], standard, error), PATIENT)
        supervisor.start("a", python(FOREVER))
        os.kill(os.getpid(), signal.SIGINT)
        assert supervisor.finish() == 130
    assert error.getvalue() == "west | interrupted; stopping all participants\n"


def test_a_second_interruption_does_not_wait() -> None:
    standard, error = io.StringIO(), io.StringIO()
    with Children() as children:
        supervisor = Supervisor(children, Output("west", ["a"], standard, error), PATIENT)
        port = supervisor.start_rti("a", python(STUBBORN), lambda line: 1 if line == "ready" else None)
        assert port == 1
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGTERM)
        assert supervisor.finish() == 143


def test_a_reader_that_leaves_ends_the_run() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed, Children() as children:
        supervisor = Supervisor(children, Output("west", ["a"], closed, io.StringIO()), PATIENT)
        supervisor.start("a", python(f"print('hello', flush=True)\n{FOREVER}"))
        assert supervisor.finish() == 141
        # What could not be written is still in the buffer, and nobody can take it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), closed.fileno())


def events_until_line(children: Children) -> Line:
    while True:
        for event in children.wait(None):
            if isinstance(event, Line):
                return event


def test_nothing_is_left_when_the_block_is_left() -> None:
    grandchild = f"import subprocess, sys\nc = subprocess.Popen([sys.executable, '-c', {FOREVER!r}])\n"
    with pytest.raises(RuntimeError, match="stop"), Children() as children:
        child = children.start("a", python(f"{grandchild}print(c.pid, flush=True)\nc.wait()"))
        pid = int(events_until_line(children).text)
        raise RuntimeError("stop")
    assert not child.running
    assert child.process.returncode == -signal.SIGKILL
    assert is_gone(child.process.pid)
    wait_until_gone(pid)


def test_what_a_child_leaves_behind_ends_with_it() -> None:
    leave = f"import subprocess, sys\nc = subprocess.Popen([sys.executable, '-c', {FOREVER!r}])\nprint(c.pid)"
    with Children() as children:
        children.start("a", python(leave))
        events: list[Event] = []
        while not any(isinstance(event, Ended) for event in events):
            events += list(children.wait(None))
    lines = [event.text for event in events if isinstance(event, Line)]
    assert [event.status for event in events if isinstance(event, Ended)] == [0]
    wait_until_gone(int(lines[0]))


def test_signals_are_given_back() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    with Children() as children:
        os.kill(os.getpid(), signal.SIGHUP)
        assert list(children.wait(None)) == [Signalled(signal.SIGHUP)]
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_a_program_that_is_not_there_is_named() -> None:
    with Children() as children, pytest.raises(LfError, match="a cannot be started: /nowhere/a: No such file"):
        children.start("a", ["/nowhere/a"])


def test_a_line_without_end_does_not_pile_up() -> None:
    with Children() as children:
        children.start("a", python("import sys; sys.stdout.write('x' * 1_000_000)"))
        texts: list[str] = []
        while children.running():
            texts += [event.text for event in children.wait(None) if isinstance(event, Line)]
    assert sum(map(len, texts)) == 1_000_000
    assert len(texts) > 1


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_colours_are_for_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = Terminal()
    Output("west", ["a"], terminal, terminal).line("a", False, "text")
    assert terminal.getvalue() == "\x1b[36ma    |\x1b[0m text\n"
    monkeypatch.setenv("NO_COLOR", "")
    plain = Terminal()
    Output("west", ["a"], plain, plain).line("a", False, "text")
    assert plain.getvalue() == "a    | text\n"


def job(name: str, text: str, folder: Path) -> Job:
    return Job(name, python(text), folder / f"{name}.log", folder)


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
    interrupt = f"import os, signal\nos.kill({os.getpid()}, signal.SIGINT)\n{FOREVER}"
    jobs = [job("a", interrupt, tmp_path), job("b", "", tmp_path)]
    assert Jobs(os.environ, 1, Screen(lambda _: None, io.StringIO())).run(jobs) == 130
    assert [item.status for item in jobs] == [None, None]


def test_a_child_knows_whether_it_runs() -> None:
    with Children() as children:
        child: Child = children.start("a", python(FOREVER))
        assert children.running() == [child]
        child.send(signal.SIGTERM)
        while children.running():
            list(children.wait(None))
        # A signal after the end goes nowhere, and certainly not to another process of that id.
        child.send(signal.SIGKILL)
