# SPDX-License-Identifier: Apache-2.0
"""An application, a Zephyr workspace and programs that stand in for lfz and west.

The stand-ins are small programs in PATH. They record their arguments, one JSON list per line, and do what a test asks
for in environment variables.
"""

from __future__ import annotations

import ipaddress
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from lf_west import compiler
from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY, find_workspace

LFZ = """
if words[0] in ("supervise", "nanoseconds"):
    os.execv(os.environ["LFZ_ITSELF"], ["lfz", *words])
if words[0] == "rti":
    print("listening on TCP port 4242", flush=True)
    exec(os.environ.get("STAND_IN_RTI", ""))
    sys.exit(0)
if words[0] == "plan":
    print(json.dumps({"target": {"board": os.environ.get("STAND_IN_BOARD")}}))
    sys.exit(0)
if words[0] == "moves":
    print(os.environ["STAND_IN_MOVES"])
    sys.exit(0)
if words[0] == "explain-errors":
    print(os.environ["STAND_IN_EXPLANATION"])
    sys.exit(int(os.environ.get("STAND_IN_EXPLAIN_STATUS", "0")))
status = int(os.environ.get("STAND_IN_LFZ_STATUS", "0"))
if status:
    print("Grid.lf:1:1: error: wrong", file=sys.stderr)
    sys.exit(status)
description = json.loads(open(os.environ["STAND_IN_DESCRIPTION"]).read())
if "--federate" in words:
    wanted = words[words.index("--federate") + 1:]
    description["participants"] = [item for item in description["participants"] if item["name"] in wanted]
print(json.dumps(description))
"""

WEST = """
if words[0] == "flash":
    folder = pathlib.Path(words[words.index("--build-dir") + 1])
    print("flashing", folder.name)
    sys.exit(4 if folder.name in os.environ.get("STAND_IN_FLASH_FAILS", "").split() else 0)
folder = pathlib.Path(words[words.index("--build-dir") + 1])
messages = [word.split("=")[1] for word in words if word.startswith("-DLF_CARGO_MESSAGES=")]
if messages and "STAND_IN_MESSAGES" in os.environ:
    pathlib.Path(messages[0]).write_text(os.environ["STAND_IN_MESSAGES"])
if folder.name in os.environ.get("STAND_IN_WEST_FAILS", "").split():
    print("[1/2] compiling")
    print("main.c:1: error: no such thing", file=sys.stderr)
    sys.exit(3)
(folder / "zephyr").mkdir(parents=True, exist_ok=True)
(folder / "build.ninja").write_text("")
default = os.environ.get("STAND_IN_RUNNER", "")
runners = {"runners": [default or "qemu", "jlink", "mdb", "ghost", "debugs"]}
(folder / "zephyr" / "runners.yaml").write_text(json.dumps(runners | ({"flash-runner": default} if default else {})))
(folder / "zephyr" / ".config").write_text(os.environ.get("STAND_IN_CONFIG", "") + os.linesep)
native = "--board" not in words or words[words.index("--board") + 1].startswith("native_sim")
image = folder / "zephyr" / ("zephyr.exe" if native else "zephyr.elf")
image.write_text("#!" + sys.executable + os.linesep + os.environ.get("STAND_IN_IMAGE", ""))
image.chmod(0o755)
print("[2/2] linking")
"""


LF = REPOSITORY / "scripts" / "lf"
# Where the tests that need Zephyr build. Kept, so that only what has changed is built the next time.
BUILD = REPOSITORY / "target" / "west-tests"
# The code of stand-ins for programs and images.
SAY = "print(*sys.argv[1:], flush=True)"


def is_gone(pid: int) -> bool:
    """Return whether there is no such process; the id of a child that was reaped, or of an orphan that init reaps."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return True
    return stat.rpartition(")")[2].split()[0] in "ZX"


def listening_port(line: str) -> int | None:
    """The port in the line that says where an RTI listens."""
    found = re.fullmatch(r"listening on TCP port ([0-9]+)", line)
    return int(found[1]) if found else None


@pytest.fixture(scope="session")
def lfz_itself() -> Path:
    """The compiler of this repository, for what nothing can stand in for."""
    return compiler.find(None, os.environ).path


@pytest.fixture(scope="module", autouse=True)
def _workspace(request: pytest.FixtureRequest) -> None:
    """Skip the tests that need a Zephyr workspace if there is none."""
    if request.node.get_closest_marker("zephyr") is None:
        return
    try:
        find_workspace(os.environ)
    except LfError as error:
        pytest.skip(f"no Zephyr workspace: {error.message}")


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Tests that take minutes are not begun when the time is over that `cargo xtask test --within` gives them."""
    until = os.environ.get("LF_TESTS_UNTIL")
    if until is not None and time.time() >= float(until) and item.get_closest_marker("zephyr") is not None:
        pytest.skip("no time is left: see `cargo xtask test --within`")


@pytest.fixture(scope="session", autouse=True)
def _interrupts_are_heard() -> None:
    """A background job may ignore these signals, and so would all that the tests start and then interrupt."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


@dataclass
class World:
    """Everything that a command of a test works on."""

    top: Path
    bin: Path
    application: Path
    zephyr: Path
    description: Path
    monkeypatch: pytest.MonkeyPatch

    @property
    def file(self) -> str:
        return str(self.application / "src" / "Grid.lf")

    @property
    def build(self) -> Path:
        return self.application / "build"

    def program(self, name: str, body: str) -> Path:
        """Put a program into PATH that records its arguments and then does what `body` says."""
        path = self.bin / name
        record = f"open({str(self.top / (name + '.calls'))!r}, 'a').write(json.dumps(words) + os.linesep)"
        head = f"#!{sys.executable}\nimport json, os, pathlib, signal, sys\nwords = sys.argv[1:]\n{record}\n"
        path.write_text(head + body)
        path.chmod(0o755)
        return path

    def calls(self, name: str) -> list[list[str]]:
        """Return the arguments of a stand-in's calls."""
        path = self.top / f"{name}.calls"
        return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []

    def forget_calls(self) -> None:
        for path in self.top.glob("*.calls"):
            path.unlink()

    def set(self, name: str, value: str) -> None:
        self.monkeypatch.setenv(name, value)

    def describe(self, *, rti: str | None = None, **platforms: str) -> None:
        """Let the compiler say that the program has these federates, on these boards or on `host`, and its RTI in the
        image of one of them, or, where no federate has that name, as an image of its own."""
        participants = [self.participant(index, *item) for index, item in enumerate(platforms.items())]
        for item in participants:
            item["joint_rti"] = item["name"] == rti
        said = {"host": "localhost", "port": 15045, "federation_id": "Grid", "federates": len(participants)}
        said["options"] = ["--number_of_federates", str(len(participants)), "--clock_sync", "off"]
        if rti is not None and rti not in platforms:
            image = self.participant(0, rti, "native_sim/native/64")
            del image["id"], image["joint_rti"]
            participants.insert(0, {**image, "role": "rti"})
        self.write({"program": "Grid", "rti": said, "participants": participants})

    def describe_unfederated(self, board: str = "native_sim/native/64") -> None:
        item = self.participant(0, "main", board)
        self.write({"program": "Grid", "rti": None, "participants": [item]})

    def write(self, description: dict[str, Any]) -> None:
        self.description.write_text(json.dumps(description))

    def participant(self, index: int, name: str, platform: str) -> dict[str, Any]:
        crate = self.top / "crates" / name
        item: dict[str, Any] = {"id": index, "name": name, "package": f"grid-{name}", "crate": str(crate)}
        item |= {"role": "federate", "joint_rti": False, "transient": False, "restarts": False}
        if platform == "host":
            return {**item, "platform": "host", "program": str(self.bin / f"grid-{name}"), "options": []}
        files = {"kconfig": str(crate / f"{name}.conf"), "overlay": str(crate / f"{name}.overlay")}
        place = {"network": None, "runner": None, "probe": None, "spare": None}
        return {**item, "platform": "zephyr", "board": platform, **files, **place}

    def attach(self, rti: str, **addresses: str) -> None:
        """Let the compiler say that the RTI has this address, and these federates those, with a prefix and perhaps a
        gateway: `10.0.0.2/24`, `10.0.0.2/24 10.0.0.1`."""
        described = json.loads(self.description.read_text())
        described["rti"]["host"] = rti
        for item in described["participants"]:
            if item["name"] in addresses:
                address, _, gateway = addresses[item["name"]].partition(" ")
                ip, prefix = ipaddress.ip_interface(address).with_prefixlen.split("/")
                mac = f"02:00:00:00:00:{item['id']:02x}"
                item["network"] = {"ip": ip, "prefix": int(prefix), "gateway": gateway or None, "mac": mac}
        self.write(described)

    def run(self, *options: str, command: str = "lf-fed-run") -> subprocess.CompletedProcess[str]:
        """Run a command that becomes another program, and give what it printed."""
        words = [sys.executable, str(LF), command, self.file, *options]
        return subprocess.run(words, capture_output=True, text=True, check=False)

    def touch(self, path: str) -> Path:
        """A file of the application."""
        file = self.application / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")
        return file


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lfz_itself: Path) -> Iterator[World]:
    top = tmp_path / "top"
    zephyr = top / "workspace" / "zephyr"
    made = World(top, top / "bin", top / "grid", zephyr, top / "description.json", monkeypatch)
    for folder in (made.bin, zephyr, zephyr.parent / ".west", made.application / "src"):
        folder.mkdir(parents=True)
    (zephyr / "VERSION").write_text("")
    (zephyr / "Kconfig.zephyr").write_text("")
    Path(made.file).write_text("target Rust\n")
    lfz = made.program("lfz", LFZ)
    made.program("west", WEST)
    made.describe(a="host", b="native_sim/native/64")
    for name in ("BOARD", "CARGO_TARGET_DIR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {
        "PATH": f"{made.bin}:{os.environ['PATH']}",
        "ZEPHYR_BASE": str(zephyr),
        "LFZ": str(lfz),
        "LFZ_ITSELF": str(lfz_itself),
        "STAND_IN_DESCRIPTION": str(made.description),
        # West reads no configuration of the person who runs the tests.
        "WEST_CONFIG_SYSTEM": str(top / "no-config"),
        "WEST_CONFIG_GLOBAL": str(top / "no-config"),
        "WEST_CONFIG_LOCAL": str(top / "no-config"),
    }.items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(top)
    yield made


@pytest.fixture
def grid(world: World) -> World:
    """A federation of a program and an image that print their arguments."""
    world.touch("deployment.yaml")
    world.program("grid-a", SAY)
    world.set("STAND_IN_IMAGE", f"import sys\n{SAY}")
    return world
