# SPDX-License-Identifier: Apache-2.0
"""lf-fed-run: which processes it starts with which arguments, and how it ends."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import LF, SAY, World, is_gone

from lf_west import description
from lf_west.application import open_application
from lf_west.description import with_spares
from lf_west.errors import LfError
from lf_west.federation import Federation, image_file, plan_federation
from lf_west.main import main

BOARD = "native_sim/native/64"


def planned(
    world: World,
    *,
    build: bool = True,
    federates: tuple[str, ...] = (),
    port: int | None = None,
    without: tuple[str, ...] = (),
) -> Federation:
    application = open_application(world.file, None)
    described = description.load(world.description)
    for item in with_spares(described.participants):
        if build and item.is_image:
            image = image_file(application, item)
            image.parent.mkdir(parents=True, exist_ok=True)
            image.write_text("")
    return plan_federation(application, described, lfz=Path("/lfz"), federates=federates, port=port, without=without)


def test_a_federation_is_built_and_run(grid: World) -> None:
    result = grid.run("--timeout", "10min")
    assert result.returncode == 0, result.stderr
    (rti,) = [call for call in grid.calls("lfz") if call[0] == "rti"]
    federation_id = rti[rti.index("--id") + 1]
    assert federation_id.startswith("Grid-")
    options = ["--number_of_federates", "2", "--clock_sync", "off"]
    assert rti == ["rti", "--id", federation_id, "--port", "0", *options]
    assert f"a    | --rti 127.0.0.1:4242 --id {federation_id}\n" in result.stdout
    options = [f"-lf-federation-id={federation_id}", "-lf-rti-address=127.0.0.1", "-lf-rti-port=4242"]
    assert f"b    | {' '.join(options)}\n" in result.stdout
    assert "listening" not in result.stdout


@pytest.mark.parametrize("text", ["soon", "-5 s", "5 parsec", "9999999 weeks"])
def test_a_time_limit_that_is_no_time_is_refused_before_anything_is_built(text: str, grid: World) -> None:
    result = grid.run(f"--timeout={text}")
    assert result.returncode == 2
    assert f"--timeout: {text!r} is no time" in result.stderr
    assert [call[0] for call in grid.calls("lfz")] == ["nanoseconds"]


@pytest.mark.parametrize("rti", ["rti", "b"])
def test_the_image_with_the_rti_is_started_first_and_says_the_port(rti: str, grid: World) -> None:
    grid.describe(rti=rti, a="host", b=BOARD, c=BOARD)
    grid.set("STAND_IN_IMAGE", f"import sys\n{SAY}\nif sys.argv[-1][-2:] == '=0': print('listening on TCP port 4711')")
    result = grid.run("--timeout", "10min")
    assert result.returncode == 0, result.stderr
    assert not any(call[0] == "rti" for call in grid.calls("lfz"))
    lines = result.stdout.split("\n")
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
    assert [item.name for item in planned(grid, federates=("rti", "a")).participants] == ["rti", "a"]


def test_built_programs_are_run_without_building(grid: World) -> None:
    assert main(["lf-fed-build", grid.file]) == 0
    grid.forget_calls()
    assert grid.run("--no-build").returncode == 0
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


def test_images_that_were_built_apart_are_run_together(grid: World) -> None:
    grid.describe(a=BOARD, b=BOARD)
    folders = [image_folder(grid, "b"), image_folder(grid, "a")]
    result = grid.run("--images", *folders)
    assert result.returncode == 0, result.stderr
    output = result.stdout
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


def test_options_for_a_build_that_is_not_made_are_warned_of(grid: World) -> None:
    assert main(["lf-fed-build", grid.file]) == 0
    result = grid.run("--no-build", "--deployment", "x.yaml", "-w", "-b y")
    assert result.returncode == 0
    assert "without effect beside --no-build: --west-commands, --deployment" in result.stderr


def test_a_failing_federate_decides_the_status(grid: World) -> None:
    grid.set("STAND_IN_IMAGE", "import sys; print('lost it', file=sys.stderr); sys.exit(5)")
    result = grid.run()
    assert result.returncode == 5
    assert "b    | lost it" in result.stderr
    assert "west | b ended with exit status 5" in result.stderr


def test_an_rti_that_cannot_listen_ends_the_run(grid: World) -> None:
    assert main(["lf-fed-build", grid.file]) == 0
    supervise = "if words[0] == 'supervise': os.execv(os.environ['LFZ_ITSELF'], ['lfz', *words])\n"
    grid.program("lfz", f"{supervise}sys.exit('the port 15045 is in use')")
    result = grid.run("--no-build", "--rti-port", "15045")
    assert result.returncode == 1
    assert "RTI  | the port 15045 is in use" in result.stderr
    assert "a    |" not in result.stdout


def test_the_time_limit_ends_the_run(grid: World) -> None:
    grid.program("grid-a", "while True: signal.pause()")
    assert grid.run("--timeout", "0").returncode == 124


def test_a_chosen_port_is_the_rtis(world: World) -> None:
    world.program("grid-a", "")
    assert planned(world).port == 0
    assert planned(world, port=20000).port == 20000


def test_federates_that_run_elsewhere_find_the_rti_as_they_were_built(world: World) -> None:
    world.describe(a="host", b="qemu_cortex_m3")
    world.program("grid-a", "")
    federation = planned(world, federates=("a",))
    described = federation.description(None)
    assert described["id"] == {"exactly": "Grid"}
    (a,) = described["federates"]
    assert (a["name"], a["words"][1:]) == ("a", ["--rti", "127.0.0.1:15045", "--id", "Grid"])
    assert described["rti"]["words"][2:8] == ["--id", "Grid", "--port", "15045", "--number_of_federates", "2"]


def test_boards_are_refused_by_name(world: World) -> None:
    world.describe(a="host", b="frdm_k64f", c=BOARD, d="qemu_cortex_m0")
    with pytest.raises(LfError) as raised:
        planned(world)
    message = "these federates do not run on this computer: b (frdm_k64f), d (qemu_cortex_m0)."
    assert message in str(raised.value)
    assert "-f a c" in str(raised.value)


def test_images_that_are_not_built_are_named(world: World) -> None:
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


def test_a_program_without_federates_is_refused(world: World) -> None:
    world.describe_unfederated()
    with pytest.raises(LfError, match="Grid is not federated"):
        planned(world)
    result = world.run("-w", f"-b {BOARD}")
    assert result.returncode == 1
    assert "west lf-build" in result.stderr


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
