# SPDX-License-Identifier: Apache-2.0
"""The search for the Zephyr workspace, the compiler and the user's files."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import World

from lf_west import compiler
from lf_west.application import board_file_names, open_application, user_files, user_settings
from lf_west.errors import LfError
from lf_west.workspace import find_workspace


def make_zephyr(topdir: Path) -> Path:
    zephyr = topdir / "zephyr"
    zephyr.mkdir(parents=True)
    (topdir / ".west").mkdir()
    (zephyr / "VERSION").write_text("")
    (zephyr / "Kconfig.zephyr").write_text("")
    return zephyr


def register(home: Path, text: str) -> None:
    folder = home / ".cmake/packages/Zephyr"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{len(list(folder.iterdir()))}").write_text(text)


def test_zephyr_base_comes_first_then_west_then_the_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    named, around, registered = (make_zephyr(tmp_path / name) for name in ("named", "around", "registered"))
    register(tmp_path / "home", f"{tmp_path}/gone/zephyr/share/zephyr-package/cmake\n")
    register(tmp_path / "home", f"{registered}/share/zephyr-package/cmake\n")
    monkeypatch.chdir(tmp_path / "around")
    home = {"HOME": str(tmp_path / "home")}
    assert find_workspace({**home, "ZEPHYR_BASE": str(named)}).zephyr_base == named
    assert find_workspace(home).zephyr_base == around
    assert find_workspace(home, str(tmp_path / "named")).zephyr_base == named
    monkeypatch.chdir(tmp_path)
    found = find_workspace(home)
    assert (found.zephyr_base, found.topdir) == (registered, tmp_path / "registered")
    assert found.environment({"X": "1"}) == {"X": "1", "ZEPHYR_BASE": str(registered)}


def test_a_zephyr_repository_that_is_a_link_belongs_to_the_workspace_with_the_link(tmp_path: Path) -> None:
    elsewhere = make_zephyr(tmp_path / "elsewhere")
    (tmp_path / "elsewhere/.west").rmdir()
    topdir = tmp_path / "workspace"
    (topdir / ".west").mkdir(parents=True)
    (topdir / "zephyr").symlink_to(elsewhere)
    assert find_workspace({"ZEPHYR_BASE": str(topdir / "zephyr")}).topdir == topdir


def test_a_wrong_zephyr_base_is_not_replaced_in_silence(tmp_path: Path) -> None:
    make_zephyr(tmp_path / "workspace")
    with pytest.raises(LfError, match="which is no Zephyr repository"):
        find_workspace({"ZEPHYR_BASE": str(tmp_path)}, str(tmp_path / "workspace"))


def test_without_a_workspace_the_ways_to_one_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(LfError) as raised:
        find_workspace({"HOME": str(tmp_path)})
    assert "no west workspace with Zephyr was found" in str(raised.value)
    assert "west zephyr-export" in str(raised.value)


def test_the_named_compiler_wins_over_the_environment(world: World) -> None:
    other = world.program("other-lfz", "")
    assert compiler.find(str(other), {"LFZ": str(world.bin / "lfz")}).path == other
    assert compiler.find(None, {"LFZ": str(world.bin / "lfz")}).path == world.bin / "lfz"


@pytest.mark.parametrize("origin", ["--lfc", "LFZ"])
def test_a_compiler_that_is_not_there_is_named(origin: str, world: World) -> None:
    path = str(world.top / "nothing")
    with pytest.raises(LfError, match=f"{origin} names {path}, which does not exist"):
        compiler.find(path if origin == "--lfc" else None, {"LFZ": path})
    Path(path).write_text("")
    with pytest.raises(LfError, match="which cannot be executed"):
        compiler.find(path if origin == "--lfc" else None, {"LFZ": path})


def test_without_a_named_compiler_cargo_builds_it(world: World) -> None:
    message = '{"reason":"compiler-artifact","target":{"name":"lfz"},"executable":"/somewhere/lfz"}'
    world.program("cargo", f"print({message!r})")
    said: list[str] = []
    assert compiler.find(None, {"PATH": str(world.bin)}, said.append).path == Path("/somewhere/lfz")
    assert said == ["building the LF compiler, if it has changed"]
    ((*_, form),) = world.calls("cargo")
    assert form == "json-render-diagnostics"


def test_a_compiler_that_cargo_cannot_build_passes_its_status_on(world: World) -> None:
    world.program("cargo", "sys.exit(101)")
    with pytest.raises(LfError, match="cargo could not build lfz") as raised:
        compiler.find(None, {"PATH": str(world.bin)})
    assert raised.value.status == 101


def test_without_cargo_the_compiler_in_the_path_serves(world: World) -> None:
    assert compiler.find(None, {"PATH": str(world.bin)}).path == world.bin / "lfz"
    with pytest.raises(LfError, match="there is no lfz, and no cargo"):
        compiler.find(None, {"PATH": str(world.top)})


@pytest.mark.parametrize(
    ("board", "names"),
    [
        ("qemu_cortex_m3", ["qemu_cortex_m3"]),
        ("native_sim/native/64", ["native_sim_native_64"]),
        (
            "mimxrt1170_evk@B/mimxrt1176/cm7",
            ["mimxrt1170_evk_mimxrt1176_cm7", "mimxrt1170_evk_mimxrt1176_cm7_B"],
        ),
        ("qemu_cortex_m3/ti_lm3s6965", ["qemu_cortex_m3", "qemu_cortex_m3_ti_lm3s6965"]),
        ("plank@1.2.0/soc", ["plank", "plank_soc", "plank_soc_1_2_0"]),
        ("plank@1.2.0", ["plank", "plank_1_2_0"]),
    ],
)
def test_board_files_are_named_as_in_zephyr(board: str, names: list[str]) -> None:
    assert board_file_names(board) == names


def test_the_users_files_are_taken_when_they_exist_the_most_special_last(world: World) -> None:
    board = "native_sim/native/64"
    application = open_application(world.file, None)
    assert user_files(application, board, "b") == ([], [])
    expected_confs = [
        world.touch("prj.conf"),
        world.touch("boards/native_sim_native_64.conf"),
        world.touch("prj_b.conf"),
        world.touch("boards/native_sim_native_64_b.conf"),
    ]
    expected_overlays = [
        world.touch("boards/native_sim_native_64.overlay"),
        world.touch("boards/native_sim_native_64_b.overlay"),
    ]
    for other in ("prj_a.conf", "boards/native_sim_native_64_a.overlay", "boards/qemu_cortex_m3_b.overlay"):
        world.touch(other)
    assert user_files(application, board, "b") == (expected_confs, expected_overlays)
    assert user_files(application, board, None) == (expected_confs[:2], expected_overlays[:1])


def test_zephyr_is_told_of_the_applications_own_options_and_devices(world: World) -> None:
    application = open_application(world.file, None)
    assert user_settings(application) == []
    kconfig = world.touch("Kconfig")
    world.touch("dts/bindings/a,b.yaml")
    assert user_settings(application) == [f"-DKCONFIG_ROOT={kconfig}", f"-DDTS_ROOT={world.application}"]


def test_files_outside_of_a_source_folder_are_an_application_too(world: World) -> None:
    file = world.touch("Alone.lf")
    application = open_application(str(file), None)
    assert (application.folder, application.build) == (world.application, world.application / "build")
    assert open_application(str(file), "elsewhere").build == world.top / "elsewhere"


def test_configuration_files_are_looked_for_here_then_in_the_application(world: World) -> None:
    application = open_application(world.file, None)
    in_application = world.touch("extra.conf")
    assert application.conf_overlays(["extra.conf"]) == [in_application]
    here = world.top / "extra.conf"
    here.write_text("")
    assert application.conf_overlays(["extra.conf"]) == [here]
    assert application.conf_overlays(["debug.conf"])[0].name == "debug.conf"
    with pytest.raises(LfError, match=r"there is no file nothing\.conf in any of"):
        application.conf_overlays(["nothing.conf"])


def test_the_applications_deployment_is_the_default(world: World) -> None:
    application = open_application(world.file, None)
    assert application.deployment(None) is None
    default = world.touch("deployment.yaml")
    assert application.deployment(None) == default
    other = world.touch("deployment/two.yaml")
    assert application.deployment("deployment/two.yaml") == other
    with pytest.raises(LfError) as raised:
        application.deployment("three.yaml")
    assert f"--deployment {other}" in str(raised.value)
