# SPDX-License-Identifier: Apache-2.0
"""The table of exit statuses in the guide is true of native_sim images: each way in which an image or one beside it can
end is tried."""

from __future__ import annotations

import signal
import subprocess
from concurrent.futures import ThreadPoolExecutor
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
    """How each row begins, the statuses of the image, the program and the RTI, and what the image says."""
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
# What the program in LF knows.
WAYS = {"nothing more to do", "`request_stop`", "a full queue", "a panic"}


def build(name: str) -> tuple[Path, Path]:
    """The program and the image of a federation."""
    lf("lf-fed-build", PROGRAMS / f"{name}.lf", *COMPUTER_AND_BOARD)
    made = BUILD / "zephyr" / name
    program = description.load(made / "federation.json").select(["computer"])[0].program
    assert program is not None
    return program, made / "board/zephyr/zephyr.exe"


def read_until(process: Process, text: str) -> str:
    """What a process prints up to the line with this text."""
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


def tried(program: Path, image: Path, way: str, alone: bool) -> tuple[tuple[int | None, ...], str]:
    """The statuses with which all end in some way, and what the image prints."""
    ends = way.strip("`") if way in WAYS else ""
    federation_id = "another" if way == "another federation id than the RTI's" else "ends"
    with rti("-n", "2", "-i", "ends") as (one, port):
        options = IMAGE_OPTIONS.get(way, [])
        with board(image, federation_id, port, *options) as image_process:
            if alone:
                status, said = end_of(image_process)
                return (status, None, None), said
            command = [str(program), "--rti", f"127.0.0.1:{port}", "--id", "ends"]
            with started(command, ENDS=ends) as other:
                said = ""
                if way in SIGNALS:
                    whom, number = SIGNALS[way]
                    said = read_until(image_process, "the board runs")
                    read_until(other, "the computer runs")
                    {"image": image_process, "program": other, "rti": one}[whom].send_signal(number)
                status, rest = end_of(image_process)
                return (status, end_of(other)[0], end_of(one)[0]), said + rest


@pytest.mark.parametrize("coordination", ["centralized", "decentralized"])
def test_images_end_with_the_statuses_of_the_guide(coordination: str) -> None:
    program, image = build("EndsOnBoard" if coordination == "centralized" else "EndsOnBoardDecentralized")
    rows = table()
    known = WAYS | SIGNALS.keys() | IMAGE_OPTIONS.keys() | {"another federation id than the RTI's"}
    assert {way for way, _, _ in rows} == known, "no row is without a test, and no way without a row"
    if coordination == "decentralized":
        # Either federate may still hear of the other, as they send to each other, and no RTI knows better.
        rows = [row for row in rows if row[0] != "nothing more to do"]
    with ThreadPoolExecutor(AT_A_TIME) as pool:
        results = list(pool.map(lambda row: tried(program, image, row[0], row[1][1] is None), rows))
    wrong = [
        f"{way}: {found} instead of {statuses}, and the image says:\n{said}"
        for (way, statuses, says), (found, said) in zip(rows, results, strict=True)
        if found != statuses or says.strip("`") not in said
    ]
    assert not wrong, "\n".join(wrong)
