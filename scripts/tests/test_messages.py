# SPDX-License-Identifier: Apache-2.0
"""The output of rustc's errors and warnings about the crates of images."""

from __future__ import annotations

import json

import pytest
from conftest import World

from lf_west.main import main

BOARD = "native_sim/native/64"
EXPLANATION = "Grid.lf:4:21: error[E0308]: mismatched types"


def message(level: str) -> str:
    """A line of cargo's."""
    text = {"level": level, "message": "mismatched types", "rendered": f"{level} as rustc prints it"}
    return json.dumps({"reason": "compiler-message", "manifest_path": "/c/Cargo.toml", "message": text})


def finished(success: bool) -> str:
    return json.dumps({"reason": "build-finished", "success": success})


@pytest.fixture
def said(world: World) -> World:
    """A federation of two images about which rustc has something to say, which the compiler then explains."""
    world.describe(b=BOARD, c=BOARD)
    world.touch("deployment.yaml")
    world.set("STAND_IN_EXPLANATION", EXPLANATION)
    return world


def fails(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit):
        main(arguments)
    return capfd.readouterr().err


def test_errors_are_shown_instead_of_the_log_with_the_logs_path(said: World, capfd: pytest.CaptureFixture[str]) -> None:
    said.set("STAND_IN_MESSAGES", f"{message('error')}\n{finished(False)}\n")
    said.set("STAND_IN_WEST_FAILS", "b")
    error = fails(["lf-fed-build", said.file, "-j", "1"], capfd)
    assert error.startswith(EXPLANATION)
    assert "b could not be built" in error
    assert "Correct what rustc reports above." in error
    assert f"Read the whole log: {said.build}/zephyr/Grid/b.log" in error
    assert "---- end of" not in error
    assert said.calls("lfz")[-1] == ["explain-errors", str(said.build / "zephyr/Grid/b.cargo.json")]


def test_all_images_are_explained_at_once(said: World, capfd: pytest.CaptureFixture[str]) -> None:
    said.set("STAND_IN_MESSAGES", f"{message('warning')}\n{finished(True)}\n")
    assert main(["lf-fed-build", said.file]) == 0
    assert capfd.readouterr().err.count(EXPLANATION) == 1
    files = [str(said.build / f"zephyr/Grid/{name}.cargo.json") for name in ("b", "c")]
    assert said.calls("lfz")[-1] == ["explain-errors", *files]


def test_a_failure_for_another_reason_shows_warnings_and_the_log(
    said: World, capfd: pytest.CaptureFixture[str]
) -> None:
    said.set("STAND_IN_MESSAGES", f"{message('warning')}\n{finished(True)}\n")
    said.set("STAND_IN_WEST_FAILS", "b")
    error = fails(["lf-fed-build", said.file], capfd)
    assert EXPLANATION in error
    assert f"---- end of {said.build}/zephyr/Grid/b.log" in error
    assert "Correct what rustc reports above." not in error


def test_nothing_is_asked_where_nothing_was_said(said: World, capfd: pytest.CaptureFixture[str]) -> None:
    said.set("STAND_IN_MESSAGES", f"{finished(True)}\n")
    assert main(["lf-fed-build", said.file]) == 0
    assert [call[0] for call in said.calls("lfz")] == ["build"]
    assert capfd.readouterr().err == ""


def test_messages_of_an_earlier_build_are_forgotten(said: World, capfd: pytest.CaptureFixture[str]) -> None:
    said.set("STAND_IN_MESSAGES", message("error"))
    said.set("STAND_IN_WEST_FAILS", "b c")
    assert EXPLANATION in fails(["lf-fed-build", said.file], capfd)
    # The next build does not come as far as to cargo.
    said.monkeypatch.delenv("STAND_IN_MESSAGES")
    error = fails(["lf-fed-build", said.file], capfd)
    assert EXPLANATION not in error
    assert "---- end of" in error


def test_where_the_compiler_cannot_explain_rustc_speaks_for_itself(
    said: World, capfd: pytest.CaptureFixture[str]
) -> None:
    # The last message is what is left when cargo is killed.
    said.set("STAND_IN_MESSAGES", f'{message("warning")}\n{message("error")}\n{{"reason":')
    said.set("STAND_IN_WEST_FAILS", "b")
    said.set("STAND_IN_EXPLAIN_STATUS", "2")
    error = fails(["lf-fed-build", said.file], capfd)
    assert "error as rustc prints it" in error
    assert "warning as rustc prints it" not in error
    assert "Use an lfz and west commands of the same version." in error


def test_a_program_without_federates_is_explained_too(world: World, capfd: pytest.CaptureFixture[str]) -> None:
    world.describe_unfederated()
    world.set("STAND_IN_EXPLANATION", EXPLANATION)
    world.set("STAND_IN_MESSAGES", message("error"))
    world.set("STAND_IN_WEST_FAILS", "main")
    error = fails(["lf-build", world.file, "-w", f"-b {BOARD}"], capfd)
    assert EXPLANATION in error
    assert "Correct what rustc reports above." in error
