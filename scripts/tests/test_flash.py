# SPDX-License-Identifier: Apache-2.0
"""lf-fed-flash: which image goes to which probe, and what is refused."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from conftest import World

from lf_west import probes
from lf_west.main import main
from lf_west.probes import Target

BOARD = "plank/soc/cm7"
# Stand-ins for Zephyr's runners: as real ones, `linkserver` takes --dev-id, and `mdb` names no probe.
RUNNERS = """
class Runner:
    def __init__(self, name, flashes, dev_id):
        self.name, self._can = (lambda: name), type("", (), {"commands": {"flash"} if flashes else {"debug"}})
        self._can.dev_id = dev_id
    def capabilities(self):
        return self._can
class ZephyrBinaryRunner:
    @staticmethod
    def get_runners():
        yield from (Runner(name, True, True) for name in ("jlink", "linkserver", "pyocd"))
        yield from (Runner("mdb", True, False), Runner("debugs", False, True), Runner("openocd", True, False))
"""


@pytest.fixture
def boards(world: World) -> World:
    """Two federates on boards and one on this computer."""
    runners = world.zephyr / "scripts/west_commands/runners"
    runners.mkdir(parents=True)
    (runners / "__init__.py").write_text(RUNNERS)
    world.set("STAND_IN_RUNNER", "pyocd")
    world.monkeypatch.setattr(probes, "USB_DEVICES", world.top / "usb")
    world.touch("deployment.yaml")
    deploy(world)
    return world


def deploy(world: World, **changes: dict[str, Any]) -> None:
    """Let `a` be a program of this computer and `b` and `c` be on boards, with these changes of b, c or others."""
    world.describe(a="host", b=BOARD, c=BOARD)
    described = json.loads(world.description.read_text())
    for item, probe in zip(described["participants"], (None, "0244B1", "0244B2"), strict=True):
        item |= {"runner": None, "probe": probe, "network": None, "spare": None} | changes.get(item["name"], {})
    world.write(described)


def connect(world: World, *serials: str) -> None:
    """Let these devices be connected by USB, beside a controller and a device without a serial number."""
    (world.top / "usb/usb1").mkdir(parents=True)
    (world.top / "usb/usb1/serial").write_text("0000:00:14.0\n")
    (world.top / "usb/1-1:1.0").mkdir()
    for index, serial in enumerate(serials):
        folder = world.top / f"usb/1-{index}"
        folder.mkdir()
        (folder / "serial").write_text(f"{serial}\n")


def flashed(world: World) -> list[list[str]]:
    """The arguments with which west was to flash."""
    return [call[1:] for call in world.calls("west") if call[0] == "flash"]


def flash_fails(world: World, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    """Return the error of a command that refuses before it flashes any board."""
    with pytest.raises(SystemExit) as raised:
        main(["lf-fed-flash", world.file, *options])
    assert raised.value.code == 1
    assert flashed(world) == []
    return capsys.readouterr().err


def arguments(world: World, name: str, runner: str, *choice: str) -> list[str]:
    folder = world.build / "zephyr/Grid" / name
    return ["--no-rebuild", "--build-dir", str(folder), "--runner", runner, *choice]


def test_each_image_is_built_and_goes_to_its_own_probe(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lf-fed-flash", boards.file, "-j", "1"]) == 0
    assert [call[0] for call in boards.calls("west")] == ["build", "build", "flash", "flash"]
    wait = "--tool-opt=--no-wait"
    assert flashed(boards) == [
        arguments(boards, "b", "pyocd", "--dev-id=0244B1", wait),
        arguments(boards, "c", "pyocd", "--dev-id=0244B2", wait),
    ]
    output = capsys.readouterr().out
    assert "b: flashing with pyocd by the probe 0244B1" in output
    assert "flashed: b, c" in output
    assert f"start a, the RTI: west lf-fed-run {boards.file} -f a --no-build" in output


@pytest.mark.parametrize(
    ("runner", "choice"),
    [
        ("jlink", "--dev-id=0244B1"),
        # It would take --dev-id and flash the first board.
        ("linkserver", "--probe=0244B1"),
        ("openocd", "--cmd-pre-init=adapter serial 0244B1"),
        # A runner of another module, of which nothing is known here.
        ("ghost", "--dev-id=0244B1"),
    ],
)
def test_every_runner_is_told_the_probe_in_its_own_way(runner: str, choice: str, boards: World) -> None:
    boards.set("STAND_IN_RUNNER", runner)
    assert main(["lf-fed-flash", boards.file, "-f", "b"]) == 0
    assert flashed(boards) == [arguments(boards, "b", runner, choice)]


def test_the_deployed_runner_comes_before_the_boards(boards: World) -> None:
    deploy(boards, c={"runner": "jlink"})
    assert main(["lf-fed-flash", boards.file]) == 0
    assert [call[call.index("--runner") + 1] for call in flashed(boards)] == ["pyocd", "jlink"]


def test_a_dry_run_prints_the_commands_for_a_shell(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    connect(boards)
    assert main(["lf-fed-flash", boards.file, "--dry-run", "--flash-arguments", "--erase -v"]) == 0
    assert flashed(boards) == []
    lines = [shlex.split(line) for line in capsys.readouterr().out.splitlines() if line.startswith("west flash ")]
    extra = ["--tool-opt=--no-wait", "--erase", "-v"]
    assert lines == [
        ["west", "flash", *arguments(boards, "b", "pyocd", "--dev-id=0244B1", *extra)],
        ["west", "flash", *arguments(boards, "c", "pyocd", "--dev-id=0244B2", *extra)],
    ]


def test_built_images_are_flashed_without_building(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nothing has been generated yet" in flash_fails(boards, capsys, "--no-build")
    assert main(["lf-fed-build", boards.file]) == 0
    boards.forget_calls()
    assert main(["lf-fed-flash", boards.file, "--no-build", "--no-lfc"]) == 0
    assert boards.calls("lfz") == []
    assert [call[0] for call in boards.calls("west")] == ["flash", "flash"]
    assert "without effect beside --no-build: --no-lfc" in capsys.readouterr().err


def test_an_image_that_is_not_there_is_not_flashed(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lf-fed-build", boards.file]) == 0
    (boards.build / "zephyr/Grid/c/zephyr/.config").unlink()
    assert "c is not built" in flash_fails(boards, capsys, "--no-build")


def test_federates_are_chosen_by_name_or_number(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    def names() -> list[str]:
        chosen = [Path(call[call.index("--build-dir") + 1]).name for call in flashed(boards)]
        boards.forget_calls()
        return chosen

    assert main(["lf-fed-flash", boards.file, "-f", "c"]) == 0
    assert names() == ["c"]
    # The programs of this computer are still known.
    assert "start a, the RTI" not in capsys.readouterr().out
    assert main(["lf-fed-flash", boards.file, "-n", "1"]) == 0
    assert names() == ["b"]
    error = flash_fails(boards, capsys, "-n", "3")
    assert "-n asks for 3 boards, but only 2 of the program are on boards: b, c." in error


def spare(probe: str | None) -> dict[str, Any]:
    """A second board of a federate that comes and goes."""
    network = {"ip": "10.0.0.12", "prefix": 24, "gateway": None, "mac": None}
    return {"transient": True, "spare": {"kconfig": "/s", "overlay": "/s", "network": network, "probe": probe}}


def test_a_spare_board_is_flashed_by_its_own_probe(boards: World) -> None:
    deploy(boards, b=spare("0244B3"))
    assert main(["lf-fed-flash", boards.file]) == 0
    wait = "--tool-opt=--no-wait"
    assert flashed(boards) == [
        arguments(boards, "b", "pyocd", "--dev-id=0244B1", wait),
        arguments(boards, "b-spare", "pyocd", "--dev-id=0244B3", wait),
        arguments(boards, "c", "pyocd", "--dev-id=0244B2", wait),
    ]
    boards.forget_calls()
    # The other board goes on with the program that it has.
    assert main(["lf-fed-flash", boards.file, "-f", "b-spare"]) == 0
    assert flashed(boards) == [arguments(boards, "b-spare", "pyocd", "--dev-id=0244B3", wait)]


def test_a_spare_board_without_a_probe_is_left_out(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    deploy(boards, b=spare(None))
    assert main(["lf-fed-flash", boards.file]) == 0
    assert [Path(call[2]).name for call in flashed(boards)] == ["b", "c"]
    assert "not flashed: b-spare, for which `spare` names no probe" in capsys.readouterr().out
    boards.forget_calls()
    assert "no probe is known for b-spare" in flash_fails(boards, capsys, "-f", "b-spare")
    assert "has no federate a-spare." in flash_fails(boards, capsys, "-f", "a-spare")


def test_the_rti_is_flashed_before_the_federates(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    deploy(boards, c={"role": "rti"})
    assert main(["lf-fed-flash", boards.file]) == 0
    assert [Path(call[2]).name for call in flashed(boards)] == ["c", "b"]
    assert "start a: west lf-fed-run" in capsys.readouterr().out


def test_without_programs_of_this_computer_the_rti_is_what_is_missing(
    boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    deploy(boards, a={"platform": "zephyr", "board": BOARD, "kconfig": "/k", "overlay": "/o", "probe": "0244B0"})
    assert main(["lf-fed-flash", boards.file]) == 0
    rti = "lfz rti --id Grid --port 15045 --number_of_federates 3 --clock_sync off"
    assert f"start the RTI: {rti}" in capsys.readouterr().out
    place = {"platform": "zephyr", "board": BOARD, "kconfig": "/k", "overlay": "/o", "probe": "0244B0"}
    deploy(boards, a={**place, "joint_rti": True})
    assert main(["lf-fed-flash", boards.file]) == 0
    assert "the boards start by themselves" in capsys.readouterr().out


def test_boards_without_a_probe_are_refused_before_anything_is_built(
    boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    deploy(boards, b={"probe": None}, c={"probe": ""})
    connect(boards, "0244B1", "0244B2")
    error = flash_fails(boards, capsys)
    assert "no probe is known for b, c" in error
    assert "b: { platform: BOARD, …, runner: pyocd, probe: SERIAL_NUMBER }" in error
    assert "These serial numbers are connected by USB: 0244B1, 0244B2" in error
    assert boards.calls("west") == []


@pytest.mark.parametrize(
    ("probe", "words"),
    [
        ("0244B1", "b and c have the same probe 0244B1"),
        ("244b1", "the probe 0244B1 of b may be taken for 244b1 of c."),
        ("0244*", "the probe 0244* of c may be any of several probes."),
        ("#1", "the probe #1 of c may be any of several probes."),
    ],
)
def test_probes_that_are_not_surely_different_are_refused(
    probe: str, words: str, boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    deploy(boards, c={"probe": probe})
    assert words in flash_fails(boards, capsys)
    assert boards.calls("west") == []


def test_a_part_of_a_probes_name_fits_only_where_the_runner_takes_parts(
    boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    deploy(boards, c={"probe": "44b"})
    assert "the probe 44b of c may be taken for 0244B1 of b." in flash_fails(boards, capsys)
    places = [Target("b", "esp32", "/dev/ttyUSB1"), Target("c", "esp32", "/dev/ttyUSB10")]
    probes.check(places)
    probes.check([Target("b", "jlink", "10.0.0.1"), Target("c", "jlink", "10.0.0.10")])


def test_probes_are_looked_for_before_the_first_board_is_flashed(
    boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    connect(boards, "0244B1", "0244c1")
    error = flash_fails(boards, capsys)
    assert "the probe 0244B2 of c is not connected to this computer" in error
    assert "Flash it by hand, if you know better: west flash --no-rebuild" in error
    deploy(boards, c={"probe": "44C"})
    assert main(["lf-fed-flash", boards.file]) == 0
    boards.forget_calls()
    (boards.top / "usb/1-7").mkdir()
    (boards.top / "usb/1-7/serial").write_text("0244C2")
    error = flash_fails(boards, capsys)
    assert "the probe 44C of c may be any of 2 USB devices: 0244c1, 0244C2" in error
    # The exact name is that of one device, whatever else it is a part of.
    assert Target("c", "pyocd", "0244c1").fits(["0244C1", "0244C10"]) == ["0244C1"]
    assert Target("c", "jlink", "683001").fits(["000683001000", "000683001"]) == ["000683001"]
    assert Target("c", "jlink", "10.0.0.1").fits([]) is None


def test_programs_for_this_computer_are_not_flashed(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    error = flash_fails(boards, capsys, "-f", "a", "b")
    assert "nothing is flashed for a (host): this is run on this computer." in error
    boards.describe(a="native_sim/native/64", b="qemu_cortex_m3")
    error = flash_fails(boards, capsys)
    assert "nothing is flashed for a (native_sim/native/64), b (qemu_cortex_m3)" in error
    assert f"Run it with its RTI: west lf-fed-run {boards.file} -f a b" in error
    assert boards.calls("west") == []


def test_a_board_that_only_its_image_shows_to_be_played_is_not_flashed(
    boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    boards.set("STAND_IN_RUNNER", "")
    boards.set("STAND_IN_CONFIG", "CONFIG_QEMU_TARGET=y")
    assert f"nothing is flashed for b ({BOARD}), c ({BOARD})" in flash_fails(boards, capsys)
    boards.set("STAND_IN_CONFIG", "")
    assert f"west cannot flash {BOARD}, the board of b" in flash_fails(boards, capsys, "-w", "-p always")


@pytest.mark.parametrize(
    ("runner", "words"),
    [
        ("dfu", f"{BOARD}, the board of b, cannot be flashed by the runner dfu."),
        ("mdb", "the runner mdb of b cannot be told which probe to use."),
        ("debugs", "the runner debugs of b flashes no boards."),
    ],
)
def test_runners_that_do_not_fit_are_refused_with_those_that_do(
    runner: str, words: str, boards: World, capsys: pytest.CaptureFixture[str]
) -> None:
    deploy(boards, b={"runner": runner})
    error = flash_fails(boards, capsys)
    assert words in error
    assert "Name one of the board's runners in the deployment file: pyocd, jlink" in error


def test_the_first_failure_ends_it_and_says_what_is_missing(boards: World, capfd: pytest.CaptureFixture[str]) -> None:
    boards.set("STAND_IN_FLASH_FAILS", "c")
    with pytest.raises(SystemExit) as raised:
        main(["lf-fed-flash", boards.file])
    assert raised.value.code == 4
    output = capfd.readouterr()
    assert "c could not be flashed; b done." in output.err
    assert "Flash what is missing: -f c" in output.err
    assert "flashing b" in output.out
    boards.set("STAND_IN_FLASH_FAILS", "b c")
    boards.forget_calls()
    with pytest.raises(SystemExit):
        main(["lf-fed-flash", boards.file])
    assert len(flashed(boards)) == 1


def test_runners_that_cannot_be_asked_are_an_error(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    (boards.zephyr / "scripts/west_commands/runners/__init__.py").write_text("import nothing_of_this_name")
    error = flash_fails(boards, capsys)
    assert "cannot be asked what they can do: ModuleNotFoundError: No module named 'nothing_of_this_name'" in error


def test_wrong_arguments_and_files_are_named(boards: World, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--flash-arguments: No closing quotation" in flash_fails(boards, capsys, "--flash-arguments", "'")
    assert main(["lf-fed-build", boards.file]) == 0
    (boards.build / "zephyr/Grid/b/zephyr/runners.yaml").write_text("a: [")
    assert "runners.yaml cannot be read" in flash_fails(boards, capsys, "--no-build")


def test_the_usb_devices_of_another_system_are_unknown(world: World) -> None:
    assert probes.connected(world.top / "none") is None
