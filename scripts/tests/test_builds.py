# SPDX-License-Identifier: Apache-2.0
"""lf-build and lf-fed-build: what is asked of lfz and of west, and what comes back."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import WEST, World

from lf_west.errors import LfError
from lf_west.main import main
from lf_west.workspace import REPOSITORY

BOARD = "native_sim/native/64"


def options(call: list[str]) -> dict[str, str]:
    """The variables that a call of west gives to CMake."""
    definitions = (word[2:].split("=", 1) for word in call[call.index("--") + 1 :] if word.startswith("-D"))
    return dict(definition for definition in definitions if len(definition) == 2)


def fails(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int | str | None, str]:
    """The exit status and the error output of a command that has to fail."""
    with pytest.raises(SystemExit) as raised:
        main(arguments)
    return raised.value.code, capsys.readouterr().err


def test_every_image_is_built_by_west_in_a_folder_of_its_own(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    world.describe(a="host", b=BOARD, c="qemu_cortex_m3")
    deployment = world.touch("deployment.yaml")
    assert main(["lf-fed-build", world.file, "-j", "1"]) == 0
    (lfz,) = world.calls("lfz")
    out = str(world.build / "lfz/Grid/west")
    assert lfz == ["build", world.file, "--json", "--release", "--out", out, "--deployment", str(deployment)]
    b, c = world.calls("west")
    crate, folder = world.top / "crates/b", world.build / "zephyr/Grid/b"
    assert b[: b.index("--") + 1] == (
        ["build", "--build-dir", str(folder), "--pristine", "auto", "--board", BOARD, str(REPOSITORY), "--"]
    )
    assert options(b) == {
        "LF_FEDERATE_CRATE": str(crate),
        "EXTRA_CONF_FILE": str(crate / "b.conf"),
        "EXTRA_DTC_OVERLAY_FILE": str(crate / "b.overlay"),
        "LF_CARGO_TARGET_DIR": str(REPOSITORY / "target/lf-zephyr"),
        "LF_CARGO_MESSAGES": str(world.build / "zephyr/Grid/b.cargo.json"),
    }
    assert c[c.index("--board") + 1] == "qemu_cortex_m3"
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"b: building; log: {world.build}/zephyr/Grid/b.log"
    summary = [line.split() for line in lines[-4:]]
    assert summary[1] == ["a", "host", "–", "–", str(world.bin / "grid-a")]
    assert summary[2] == ["b", BOARD, "–", "–", str(folder / "zephyr/zephyr.exe")]


def test_the_users_settings_come_after_the_generated_ones(world: World) -> None:
    prj, special, debug = world.touch("prj.conf"), world.touch("prj_b.conf"), world.touch("debug.conf")
    overlay = world.touch("boards/native_sim_native_64_b.overlay")
    west = "-b native_sim/native/64 --extra-conf w.conf -S snippet -- -DA=1"
    arguments = ["lf-fed-build", world.file, "-w", west, "-c", "debug.conf", "--", "-DEXTRA_CONF_FILE=x;y", "-DB=2"]
    world.monkeypatch.chdir(world.application)
    assert main(arguments) == 0
    (call,) = world.calls("west")
    definitions = options(call)
    crate = world.top / "crates/b"
    confs = [crate / "b.conf", prj, special, debug, "w.conf", "x", "y"]
    assert definitions["EXTRA_CONF_FILE"] == ";".join(map(str, confs))
    assert definitions["EXTRA_DTC_OVERLAY_FILE"] == f"{crate}/b.overlay;{overlay}"
    assert call[-2:] == ["-DA=1", "-DB=2"]
    assert call[call.index("-S") + 1] == "snippet"


def test_a_board_on_the_command_line_overrides_the_deployments(world: World) -> None:
    world.touch("deployment.yaml")
    world.set("BOARD", "from_the_environment")
    assert main(["lf-fed-build", world.file]) == 0
    assert main(["lf-fed-build", world.file, "-w", "-b qemu_cortex_m3"]) == 0
    boards = [call[call.index("--board") + 1] for call in world.calls("west")]
    assert boards == [BOARD, "qemu_cortex_m3"]


def test_without_a_deployment_all_federates_are_for_the_chosen_board(world: World) -> None:
    world.describe(a="plank")
    world.set("BOARD", "plank")
    assert main(["lf-fed-build", world.file]) == 0
    (call,) = world.calls("lfz")
    assert call[-4:] == ["--platform", "zephyr", "--board", "plank"]


def test_without_any_board_the_deployments_are_offered(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    offered = world.touch("deployment/two.yaml")
    status, error = fails(["lf-fed-build", world.file], capsys)
    assert status == 1
    assert "there is no board to build Grid for" in error
    assert f"--deployment {offered}" in error
    assert [call[0] for call in world.calls("lfz")] == ["plan"]


def test_the_board_that_the_program_names_is_taken_when_nothing_else_names_one(world: World) -> None:
    world.describe(a="plank")
    world.set("STAND_IN_BOARD", "plank")
    assert main(["lf-fed-build", world.file]) == 0
    assert world.calls("lfz")[-1][-4:] == ["--platform", "zephyr", "--board", "plank"]


def test_chosen_federates_are_built_and_the_others_stay_known(world: World) -> None:
    world.describe(a="host", b=BOARD, c=BOARD)
    world.touch("deployment.yaml")
    assert main(["lf-fed-build", world.file]) == 0
    world.forget_calls()
    assert main(["lf-fed-build", world.file, "-f", "c", "b"]) == 0
    (call,) = world.calls("lfz")
    assert call[-3:] == ["--federate", "c", "b"]
    assert len(world.calls("west")) == 2
    kept = json.loads((world.build / "zephyr/Grid/federation.json").read_text())
    assert [item["name"] for item in kept["participants"]] == ["a", "b", "c"]


def test_builds_of_another_version_are_out_of_date(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    world.describe(a="host", b=BOARD)
    world.touch("deployment.yaml")
    file = world.build / "zephyr/Grid/federation.json"
    file.parent.mkdir(parents=True)
    file.write_text('{"program": "Grid"}')
    assert main(["lf-fed-build", world.file, "-f", "b"]) == 0
    assert f"{file} is out of date: build the other federates, too" in capsys.readouterr().out
    assert [item["name"] for item in json.loads(file.read_text())["participants"]] == ["b"]
    # Without the compiler there is nothing else to go by.
    file.write_text("{}")
    error = fails(["lf-fed-build", world.file, "-n"], capsys)[1]
    assert f"{file} is no description of a program" in error
    assert "Build again without --no-lfc and --no-build." in error


def test_without_the_compiler_what_it_made_before_is_built(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    world.touch("deployment.yaml")
    status, error = fails(["lf-fed-build", world.file, "-n"], capsys)
    assert (status, "nothing has been generated yet" in error) == (1, True)
    assert main(["lf-fed-build", world.file]) == 0
    world.forget_calls()
    assert main(["lf-fed-build", world.file, "--no-lfc", "-f", "b"]) == 0
    assert world.calls("lfz") == []
    assert len(world.calls("west")) == 1
    assert "Grid has no federate z" in fails(["lf-fed-build", world.file, "-n", "-f", "z"], capsys)[1]


def test_a_folder_is_configured_again_only_when_its_settings_change(world: World) -> None:
    arguments = ["lf-fed-build", world.file, "-w", f"-b {BOARD}"]
    for _ in range(2):
        assert main(arguments) == 0
    world.touch("prj_b.conf")
    assert main(arguments) == 0
    assert ["--" in call for call in world.calls("west")] == [True, False, True]
    world.forget_calls()
    always = ["lf-fed-build", world.file, "-w", f"-b {BOARD} -p always"]
    for _ in range(2):
        assert main(always) == 0
    assert all("--" in call and "auto" not in call for call in world.calls("west"))


def test_a_failed_build_shows_the_end_of_its_log(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    world.describe(a="host", b=BOARD, c=BOARD)
    world.touch("deployment.yaml")
    world.set("STAND_IN_WEST_FAILS", "b")
    status, error = fails(["lf-fed-build", world.file, "-j", "1"], capsys)
    log = world.build / "zephyr/Grid/b.log"
    assert status == 3
    assert f"---- end of {log}" in error
    assert "main.c:1: error: no such thing" in error
    assert "b could not be built" in error
    assert sorted(log.read_text().splitlines()) == ["[1/2] compiling", "main.c:1: error: no such thing"]
    # With one job at a time, the next is not begun after a failure.
    assert len(world.calls("west")) == 1
    # The folder is configured anew after a failure.
    world.set("STAND_IN_WEST_FAILS", "")
    assert main(["lf-fed-build", world.file]) == 0
    assert all("--" in call for call in world.calls("west"))


def test_a_wrong_program_ends_with_the_compilers_status(world: World, capfd: pytest.CaptureFixture[str]) -> None:
    world.set("STAND_IN_LFZ_STATUS", "7")
    with pytest.raises(SystemExit) as raised:
        main(["lf-fed-build", world.file, "-w", f"-b {BOARD}"])
    assert raised.value.code == 7
    error = capfd.readouterr().err
    assert "Grid.lf:1:1: error: wrong" in error
    assert f"lfz could not build {world.file}" in error
    assert world.calls("west") == []


def test_an_unfederated_program_is_one_image(world: World, capfd: pytest.CaptureFixture[str]) -> None:
    world.describe_unfederated()
    assert main(["lf-build", world.file, "-w", f"-b {BOARD}", "-d", "elsewhere", "--", "-DX=1"]) == 0
    (call,) = world.calls("west")
    assert call[2] == str(world.top / "elsewhere/zephyr/Grid/main")
    assert call[-1] == "-DX=1"
    # West's own output is shown as it is.
    assert "[2/2] linking" in capfd.readouterr().out
    world.set("STAND_IN_WEST_FAILS", "main")
    with pytest.raises(SystemExit) as raised:
        main(["lf-build", world.file, "-w", f"-b {BOARD}"])
    assert raised.value.code == 3


def test_each_command_refuses_the_others_programs(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    board = ["-w", f"-b {BOARD}"]
    assert "Grid is federated" in fails(["lf-build", world.file, *board], capsys)[1]
    world.describe_unfederated()
    assert "Grid is not federated" in fails(["lf-fed-build", world.file, *board], capsys)[1]
    assert world.calls("west") == []


def test_a_path_that_zephyr_cannot_take_is_refused(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    conf = world.touch("my settings.conf")
    status, error = fails(["lf-fed-build", world.file, "-w", f"-b {BOARD}", "-c", str(conf)], capsys)
    assert status == 1
    assert f"Zephyr cannot build with the path {conf}" in error


def test_cargos_results_are_shared_where_the_environment_says(world: World) -> None:
    world.set("CARGO_TARGET_DIR", "shared")
    assert main(["lf-fed-build", world.file, "-w", f"-b {BOARD}"]) == 0
    (call,) = world.calls("west")
    assert options(call)["LF_CARGO_TARGET_DIR"] == str(world.top / "shared/lf-zephyr")


@pytest.mark.parametrize("command", ["lf-build", "lf-fed-build"])
@pytest.mark.parametrize("users", [None, "/home"])
def test_common_crates_of_images_are_compiled_once(world: World, users: str | None, command: str) -> None:
    if command == "lf-build":
        world.describe_unfederated()
    world.monkeypatch.delenv("CCACHE_BASEDIR", raising=False)
    if users is not None:
        world.set("CCACHE_BASEDIR", users)
    world.program("west", f"{WEST}\nopen({str(world.top / 'seen')!r}, 'w').write(os.environ['CCACHE_BASEDIR'])")
    assert main([command, world.file, "-w", f"-b {BOARD}"]) == 0
    assert (world.top / "seen").read_text() == (users or str(world.build / "zephyr/Grid"))


def test_a_host_program_is_no_image(world: World) -> None:
    from lf_west import description, west_arguments
    from lf_west.application import open_application
    from lf_west.image import plan_image

    with pytest.raises(LfError, match="a is a program of this computer"):
        plan_image(
            open_application(world.file, None),
            description.load(world.description).participants[0],
            federated=True,
            west=west_arguments.parse(None),
            conf_overlays=[],
            cmake_arguments=[],
            cargo_folder=Path("/x"),
        )
