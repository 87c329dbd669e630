# SPDX-License-Identifier: Apache-2.0
"""lf-fed-run: which processes it starts with which arguments, and how it ends."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import World, is_gone

from lf_west import description
from lf_west.application import open_application
from lf_west.errors import LfError
from lf_west.federation import Federation, image_file, listening_port, plan_federation
from lf_west.main import main

BOARD = "native_sim/native/64"
SAY = "print(*sys.argv[1:], flush=True)"
LF = Path(__file__).resolve().parents[1] / "lf"


@pytest.fixture
def grid(world: World) -> World:
    """A federation of a program and an image that print their arguments."""
    world.touch("deployment.yaml")
    world.program("grid-a", SAY)
    world.set("STAND_IN_IMAGE", f"import sys\n{SAY}")
    return world


def planned(
    world: World, *, build: bool = True, federates: tuple[str, ...] = (), port: int | None = None
) -> Federation:
    application = open_application(world.file, None)
    described = description.load(world.description)
    for item in described.participants:
        if build and item.is_image:
            image = image_file(application, item)
            image.parent.mkdir(parents=True, exist_ok=True)
            image.write_text("")
    return plan_federation(application, described, lfz=Path("/lfz"), federates=federates, port=port)


def status_of(arguments: list[str]) -> int | str | None:
    """The exit status of a command that ends the program."""
    with pytest.raises(SystemExit) as raised:
        main(arguments)
    return raised.value.code


def test_a_federation_is_built_and_run(grid: World, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["lf-fed-run", grid.file, "--timeout", "10min"]) == 0
    output = capfd.readouterr().out
    guard, rti = [call for call in grid.calls("lfz") if call[0] in ("guard", "rti") and "rti" in call[:6]]
    assert guard[:4] == ["guard", "--parent", str(os.getpid()), "--"]
    federation_id = rti[rti.index("--id") + 1]
    assert federation_id.startswith("Grid ")
    clock_sync = ["--clock_sync", "init", "exchanges-per-interval", "10"]
    assert rti == ["rti", "--id", federation_id, "--port", "0", "--number_of_federates", "2", *clock_sync]
    assert f"a    | --rti 127.0.0.1:4242 --id {federation_id}\n" in output
    options = f"-lf-federation-id={federation_id} -lf-rti-address=127.0.0.1 -lf-rti-port=4242"
    assert f"b    | {options}\n" in output
    assert "listening" not in output


@pytest.mark.parametrize("rti", ["rti", "b"])
def test_the_image_with_the_rti_is_started_first_and_says_the_port(
    rti: str, grid: World, capfd: pytest.CaptureFixture[str]
) -> None:
    grid.describe(rti=rti, a="host", b=BOARD, c=BOARD)
    grid.set("STAND_IN_IMAGE", f"import sys\n{SAY}\nif sys.argv[-1][-2:] == '=0': print('listening on TCP port 4711')")
    assert main(["lf-fed-run", grid.file, "--timeout", "10min"]) == 0
    assert not any(call[0] == "rti" or "rti" in call[4:6] for call in grid.calls("lfz"))
    lines = capfd.readouterr().out.split("\n")
    runs = [line for line in lines if "-lf-rti-port=" in line or "--rti " in line]
    assert runs[0].split()[0] == rti
    assert runs[0].endswith("-lf-rti-port=0")
    assert len(runs) == (4 if rti == "rti" else 3)
    assert all(run.endswith("-lf-rti-port=4711") or "--rti 127.0.0.1:4711 " in run for run in runs[1:])
    assert not any("listening" in line for line in lines)


def test_the_image_with_the_rti_cannot_be_left_out(grid: World) -> None:
    grid.describe(rti="b", a="host", b=BOARD)
    with pytest.raises(LfError, match="the RTI is part of the image b, which is left out") as raised:
        planned(grid, federates=("a",))
    assert "-f b a" in str(raised.value)
    grid.describe(rti="rti", a="host", b=BOARD)
    assert planned(grid, federates=("rti", "a")).names() == ["rti", "a"]


def test_what_was_built_is_run_without_building(grid: World) -> None:
    assert main(["lf-fed-build", grid.file]) == 0
    grid.forget_calls()
    assert main(["lf-fed-run", grid.file, "--no-build"]) == 0
    assert grid.calls("west") == []
    assert not any(call[0] == "build" for call in grid.calls("lfz"))


def image_folder(world: World, name: str, place: str | None = None) -> str:
    """A folder in which `west build` has built the image of one federate."""
    described = json.loads(world.description.read_text())
    described["participants"] = [item for item in described["participants"] if item["name"] == name]
    folder = world.top / (place or name)
    (folder / "lf").mkdir(parents=True)
    (folder / "lf/federation.json").write_text(json.dumps(described))
    (folder / "zephyr").mkdir()
    image = folder / "zephyr/zephyr.exe"
    image.write_text(f"#!{sys.executable}\nimport sys\n{SAY}")
    image.chmod(0o755)
    return str(folder)


def test_images_that_were_built_apart_are_run_together(grid: World, capfd: pytest.CaptureFixture[str]) -> None:
    grid.describe(a=BOARD, b=BOARD)
    folders = [image_folder(grid, "b"), image_folder(grid, "a")]
    assert main(["lf-fed-run", grid.file, "--images", *folders]) == 0
    output = capfd.readouterr().out
    assert re.search(r"^a    \| -lf-federation-id=.* -lf-rti-port=4242$", output, re.MULTILINE)
    assert re.search(r"^b    \| -lf-federation-id=.* -lf-rti-port=4242$", output, re.MULTILINE)
    assert grid.calls("west") == []
    assert [call for call in grid.calls("lfz") if call[0] == "build"] == []


def test_images_of_different_builds_are_not_run_together(grid: World) -> None:
    grid.describe(a=BOARD, b=BOARD)
    folders = [Path(image_folder(grid, "a")), Path(image_folder(grid, "a", "again"))]
    with pytest.raises(LfError, match=r"a is built in .*/a and in .*/again") as caught:
        description.in_image_folders(folders)
    assert caught.value.tries
    grid.describe(rti="b", a=BOARD, b=BOARD, c=BOARD)
    folders[1] = Path(image_folder(grid, "b"))
    with pytest.raises(LfError, match=r"/b is no part of the federation Grid in .*/a\."):
        description.in_image_folders(folders)
    with pytest.raises(LfError, match="nothing has been generated yet"):
        description.in_image_folders([grid.top])


def test_options_for_a_build_that_is_not_made_are_warned_of(grid: World, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lf-fed-build", grid.file]) == 0
    assert main(["lf-fed-run", grid.file, "--no-build", "--deployment", "x.yaml", "-w", "-b y"]) == 0
    assert "without effect beside --no-build: --west-commands, --deployment" in capsys.readouterr().err


def test_a_failing_federate_decides_the_status(grid: World, capfd: pytest.CaptureFixture[str]) -> None:
    grid.set("STAND_IN_IMAGE", "import sys; sys.exit('lost it')")
    assert status_of(["lf-fed-run", grid.file]) == 1
    error = capfd.readouterr().err
    assert "b    | lost it" in error
    assert "west | b ended with exit status 1" in error


def test_an_rti_that_cannot_listen_ends_the_run(grid: World, capfd: pytest.CaptureFixture[str]) -> None:
    body = "if words[0] == 'guard': os.execv(words[4], words[4:])\n"
    assert main(["lf-fed-build", grid.file]) == 0
    grid.program("lfz", body + "sys.exit('the port 15045 is in use')")
    assert status_of(["lf-fed-run", grid.file, "--no-build", "--rti-port", "15045"]) == 1
    captured = capfd.readouterr()
    assert "RTI  | the port 15045 is in use" in captured.err
    assert "a    |" not in captured.out


def test_the_time_limit_ends_the_run(grid: World) -> None:
    grid.program("grid-a", "while True: signal.pause()")
    assert status_of(["lf-fed-run", grid.file, "--timeout", "0"]) == 124


def test_a_chosen_port_is_the_rtis(world: World) -> None:
    world.program("grid-a", "")
    assert planned(world).port == 0
    assert planned(world, port=20000).port == 20000


def test_federates_that_run_elsewhere_find_the_rti_as_they_were_built(world: World) -> None:
    world.describe(a="host", b="qemu_cortex_m3")
    world.program("grid-a", "")
    federation = planned(world, federates=("a",))
    assert (federation.port, federation.federation_id) == (15045, "Grid")
    assert [item.name for item in federation.participants] == ["a"]
    assert federation.rti_command()[federation.rti_command().index("--number_of_federates") + 1] == "2"


def test_boards_are_refused_by_name(world: World) -> None:
    world.describe(a="host", b="frdm_k64f", c=BOARD, d="qemu_cortex_m0")
    with pytest.raises(LfError) as raised:
        planned(world)
    message = "these federates do not run on this computer: b (frdm_k64f), d (qemu_cortex_m0)."
    assert message in str(raised.value)
    assert "-f a c" in str(raised.value)


def test_what_is_not_built_is_named(world: World) -> None:
    with pytest.raises(LfError, match="a is not built: there is no"):
        planned(world, build=False)
    world.program("grid-a", "")
    with pytest.raises(LfError, match="b is not built: there is no"):
        planned(world, build=False)


def test_a_federation_that_is_not_complete_is_refused(world: World) -> None:
    world.program("grid-a", "")
    older = description.load(world.description)
    world.write({**older.source, "participants": older.source["participants"][:1]})
    with pytest.raises(LfError, match="Grid has 2 federates, but 1 are built: a"):
        planned(world)


def test_a_program_without_federates_is_refused(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    world.describe_unfederated()
    with pytest.raises(LfError, match="Grid is not federated"):
        planned(world)
    assert status_of(["lf-fed-run", world.file, "-w", f"-b {BOARD}"]) == 1
    assert "west lf-build" in capsys.readouterr().err


def test_clock_sync_can_be_off(world: World) -> None:
    world.program("grid-a", "")
    source = description.load(world.description).source
    world.write({**source, "rti": {**source["rti"], "clock_sync": "off"}})
    assert planned(world).rti_command()[-2:] == ["--clock_sync", "off"]


def test_clock_sync_can_go_on(world: World) -> None:
    """The RTI is told the period that the program asks for."""
    world.program("grid-a", "")
    source = description.load(world.description).source
    world.write({**source, "rti": {**source["rti"], "clock_sync": "on", "clock_sync_period_ns": 7_000_000}})
    words = ["--clock_sync", "on", "period", "7000000", "exchanges-per-interval", "10"]
    assert planned(world).rti_command()[-6:] == words


def test_waits_are_logged_where_the_program_asks_for_it(world: World) -> None:
    world.program("grid-a", "")
    source = description.load(world.description).source
    assert "--log-waits" not in planned(world).rti_command()
    world.write({**source, "rti": {**source["rti"], "log_waits_ns": 500_000_000}})
    words = planned(world).rti_command()
    assert words[words.index("--log-waits") + 1] == "500000000 ns"


def test_dnet_can_be_off(world: World) -> None:
    world.program("grid-a", "")
    source = description.load(world.description).source
    world.write({**source, "rti": {**source["rti"], "dnet": False}})
    assert "--dnet_disabled" in planned(world).rti_command()


def test_the_rti_authenticates_the_federates_that_authenticate(world: World) -> None:
    world.program("grid-a", "")
    source = description.load(world.description).source
    world.write({**source, "rti": {**source["rti"], "auth": True}})
    assert "--auth" in planned(world).rti_command()


def test_federation_ids_differ_and_fit_on_the_wire(world: World) -> None:
    world.program("grid-a", "")
    source = description.load(world.description).source
    world.write({**source, "rti": {**source["rti"], "federation_id": "é" * 300}})
    first, second = planned(world).federation_id, planned(world).federation_id
    assert first != second
    assert len(first.encode()) <= 255


@pytest.mark.parametrize(
    ("line", "port"),
    [("listening on TCP port 15045", 15045), ("listening on TCP port x", None), ("15045", None), ("", None)],
)
def test_the_rtis_port_is_read_from_its_line(line: str, port: int | None) -> None:
    assert listening_port(line) == port


@pytest.fixture
def running(grid: World) -> Iterator[subprocess.Popen[str]]:
    """A run whose federates do not end by themselves, once all of them are there; they print their process ids."""
    wait = "import os, signal\nprint('pid', os.getpid(), flush=True)\nwhile True: signal.pause()"
    grid.program("grid-a", wait)
    grid.set("STAND_IN_IMAGE", wait)
    grid.set("STAND_IN_RTI", wait)
    command = [sys.executable, str(LF), "lf-fed-run", grid.file]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def process_ids(process: subprocess.Popen[str]) -> dict[str, int]:
    """The processes of the federation, by name, when all three have said theirs."""
    found: dict[str, int] = {}
    assert process.stdout is not None
    while len(found) < 3:
        line = process.stdout.readline()
        assert line, "the run has ended"
        name, _, text = line.partition("|")
        if text.startswith(" pid "):
            found[name.strip()] = int(text.split()[1])
    return found


def test_an_interrupted_run_leaves_nothing_behind(running: subprocess.Popen[str]) -> None:
    participants = process_ids(running)
    assert set(participants) == {"RTI", "a", "b"}
    running.send_signal(signal.SIGINT)
    output, _ = running.communicate()
    assert running.returncode == 130
    assert "interrupted; stopping all participants" in output
    assert all(is_gone(pid) for pid in participants.values())
