# SPDX-License-Identifier: Apache-2.0
"""The table of exit statuses in the guide is true of native_sim images: each way in which an image or one beside it can
end is tried."""

from __future__ import annotations

import signal
import socket
import subprocess
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from conftest import BUILD
from test_zephyr import COMPUTER_AND_BOARD, LIMIT_S, PROGRAMS, board, lf, rti, started

from lf_west import description
from lf_west.workspace import REPOSITORY

pytestmark = pytest.mark.zephyr

HEAD = "| how a participant ends | the image | a program | the RTI | the image says |"
# Rows that are tried at a time; participants mostly wait.
AT_A_TIME = 4

Process = subprocess.Popen[str]
Signalled = tuple[str, signal.Signals]


def table() -> list[tuple[str, tuple[int | None, ...], str]]:
    """Return the rows: beginning, statuses of the image, the program and the RTI, and the image's output."""
    lines = (REPOSITORY / "docs/guide/src/errors.md").read_text(encoding="utf-8").splitlines()
    rows = []
    for line in lines[lines.index(HEAD) + 2 :]:
        if not line.startswith("|"):
            break
        way, *statuses, says = (cell.strip() for cell in line.strip("|").split(" | "))
        rows.append((way, tuple(int(status) if status.isdecimal() else None for status in statuses), says))
    return rows


# Whom a row's signal is for.
SIGNALS: dict[str, Signalled] = {
    "SIGTERM to the image": ("image", signal.SIGTERM),
    "SIGKILL to the image": ("image", signal.SIGKILL),
    "SIGKILL to the program": ("program", signal.SIGKILL),
    "SIGTERM to the RTI": ("rti", signal.SIGTERM),
    "SIGKILL to the RTI": ("rti", signal.SIGKILL),
}
IMAGE_OPTIONS = {
    "an unknown option": ["-no-such-option"],
    "no address of the RTI": ["-lf-rti-address=nowhere"],
    "no port of the RTI": ["-lf-rti-port=70000"],
}
# The ways that the program in LF knows.
WAYS = {"nothing more to do", "`request_stop`", "a full queue", "a panic"}
OTHER_ID = "another federation id than the RTI's"
LATE = "it joins when all are there"
NO_MESSAGE = "bytes that are no message"


def build(name: str, *deployment: str) -> tuple[Path, Path]:
    """Build a federation; return the paths of its program and its image."""
    lf("lf-fed-build", PROGRAMS / f"{name}.lf", *deployment)
    made = BUILD / "zephyr" / name
    program = description.load(made / "federation.json").select(["computer"])[0].program
    assert program is not None
    return program, made / "board/zephyr/zephyr.exe"


def read_until(process: Process, text: str) -> str:
    """Return the output of a process up to the line with this text."""
    lines = []
    for line in process.stdout or ():
        lines.append(line)
        if text in line:
            break
    return "".join(lines)


def end_of(process: Process) -> tuple[int, str]:
    """The status as a shell says it, and what was still printed."""
    output = process.communicate(timeout=LIMIT_S)[0]
    return process.returncode if process.returncode >= 0 else 128 - process.returncode, output


def other(program: Path, port: int, way: str) -> list[str]:
    """The command of the program that is beside the image, and the variable that tells it the way."""
    ends = way.strip("`") if way in WAYS else ""
    return ["env", f"ENDS={ends}", str(program), "--rti", f"127.0.0.1:{port}", "--id", "ends"]


def late(program: Path, image: Path) -> tuple[int, str]:
    """Return the end of an image that joins when all are there."""
    with (
        rti("-n", "2", "-i", "ends") as (_, port),
        board(image, "ends", port) as first,
        started(other(program, port, "")),
    ):
        read_until(first, "the board runs")
        with board(image, "ends", port) as second:
            return end_of(second)


@contextmanager
def answering(answer: bytes) -> Iterator[int]:
    """A peer on some port that has the same answer for everybody, and then waits until they end the connection."""

    def answer_all() -> None:
        while True:
            try:
                connection, _ = listener.accept()
            except OSError:
                return
            with connection:
                connection.sendall(answer)
                while connection.recv(1024):
                    pass

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer_all)
        thread.start()
        try:
            yield listener.getsockname()[1]
        finally:
            listener.shutdown(socket.SHUT_RDWR)
            thread.join()


def alone(program: Path, image: Path, way: str) -> tuple[int, str]:
    """Return the end of an image without other participants."""
    if way == LATE:
        return late(program, image)
    if way == NO_MESSAGE:
        with answering(b"HTTP/1.1 400 Bad Request\r\n\r\n") as port, board(image, "ends", port) as process:
            return end_of(process)
    with rti("-n", "2", "-i", "ends") as (_, port):
        federation_id = "another" if way == OTHER_ID else "ends"
        with board(image, federation_id, port, *IMAGE_OPTIONS.get(way, [])) as process:
            return end_of(process)


def together(processes: dict[str, Process], way: str) -> tuple[tuple[int, ...], str]:
    """The statuses with which processes end in some way, and what the image prints."""
    said = ""
    if way in SIGNALS:
        whom, number = SIGNALS[way]
        said = read_until(processes["image"], "the board runs")
        read_until(processes["program"], "the computer runs")
        processes[whom].send_signal(number)
    ends = [end_of(process) for process in processes.values()]
    return tuple(status for status, _ in ends), said + ends[0][1]


def tried(program: Path, image: Path, way: str, is_alone: bool) -> tuple[tuple[int | None, ...], str]:
    """The statuses with which all end in some way, and what the image prints."""
    if is_alone:
        status, said = alone(program, image, way)
        return (status, None, None), said
    with (
        rti("-n", "2", "-i", "ends") as (one, port),
        board(image, "ends", port) as image_process,
        started(other(program, port, way)) as beside,
    ):
        return together({"image": image_process, "program": beside, "rti": one}, way)


def free_port() -> int:
    """Return a port on which no program listens now."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
        return port


def tried_with_the_rti(program: Path, image: Path, way: str) -> tuple[tuple[int, ...], str]:
    """Return the result of `tried`, for an image that contains the RTI."""
    port = free_port()
    with board(image, "ends", port) as image_process, started(other(program, port, way)) as beside:
        return together({"image": image_process, "program": beside}, way)


@pytest.mark.parametrize("coordination", ["centralized", "decentralized"])
def test_images_end_with_the_statuses_of_the_guide(coordination: str) -> None:
    name = "EndsOnBoard" if coordination == "centralized" else "EndsOnBoardDecentralized"
    program, image = build(name, *COMPUTER_AND_BOARD)
    rows = table()
    known = WAYS | SIGNALS.keys() | IMAGE_OPTIONS.keys() | {OTHER_ID, LATE, NO_MESSAGE}
    assert {way for way, _, _ in rows} == known, "no row is without a test, and no way without a row"
    if coordination == "decentralized":
        # Either federate may still hear of the other, as they send to each other, and no RTI knows better. Who joins
        # late learns that from the RTI, before coordination begins, and only after a minute.
        rows = [row for row in rows if row[0] not in ("nothing more to do", LATE)]
    # The longest begins first.
    rows.sort(key=lambda row: row[0] != LATE)
    with ThreadPoolExecutor(AT_A_TIME) as pool:
        results = list(pool.map(lambda row: tried(program, image, row[0], row[1][1] is None), rows))
    assert_as_told(rows, results)


def test_images_with_the_rti_end_with_the_same_statuses() -> None:
    program, image = build("EndsOnBoard", "--deployment", str(PROGRAMS / "computer_and_joint_board.yaml"))
    rows = [
        (way, statuses[:2], says)
        for way, statuses, says in table()
        if statuses[1] is not None and "to the RTI" not in way
    ]
    with ThreadPoolExecutor(AT_A_TIME) as pool:
        results = list(pool.map(lambda row: tried_with_the_rti(program, image, row[0]), rows))
    assert_as_told(rows, results)


def assert_as_told(
    rows: Sequence[tuple[str, tuple[int | None, ...], str]], results: Sequence[tuple[tuple[int | None, ...], str]]
) -> None:
    """All have ended as their rows say."""
    wrong = [
        f"{way}: {found} instead of {statuses}, and the image says:\n{said}"
        for (way, statuses, says), (found, said) in zip(rows, results, strict=True)
        if found != statuses or says.strip("`") not in said
    ]
    assert not wrong, "\n".join(wrong)
