# SPDX-License-Identifier: Apache-2.0
"""The commands' parsing of their command lines, and the errors for invalid ones."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from conftest import World

from lf_west import west_arguments
from lf_west.errors import LfError
from lf_west.main import all_commands, main

SCRIPTS = Path(__file__).resolve().parents[1]


def test_west_finds_the_commands_with_the_same_help() -> None:
    specification = yaml.safe_load((SCRIPTS / "west-commands.yml").read_text())
    (entry,) = specification["west-commands"]
    assert (SCRIPTS.parent / entry["file"]).is_file()
    listed = {item["name"]: (item["class"], item["help"]) for item in entry["commands"]}
    assert listed == {command.name: (type(command).__name__, command.help) for command in all_commands()}


def test_west_build_arguments_are_taken_apart_as_a_shell_would() -> None:
    parsed = west_arguments.parse("-b 'a board' -p always -S 'my snippet' -- -DX=1")
    assert (parsed.board, parsed.has_pristine) == ("a board", True)
    assert parsed.rest == ("--pristine", "always", "-S", "my snippet")
    assert parsed.cmake == ("-DX=1",)


def test_no_west_build_arguments_are_no_arguments() -> None:
    parsed = west_arguments.parse(None)
    assert (parsed.board, parsed.has_pristine, parsed.rest, parsed.cmake) == (None, False, (), ())


def test_pristine_without_a_value_means_always() -> None:
    assert west_arguments.parse("-b x -p").rest == ("--pristine", "always")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("-b 'x", "No closing quotation"),
        ("-b", "expected one argument"),
        ("-d build", "--build-dir"),
        ("-s .", "--source-dir"),
    ],
)
def test_wrong_west_build_arguments_are_named(text: str, words: str) -> None:
    with pytest.raises(LfError) as raised:
        west_arguments.parse(text)
    assert words in str(raised.value)
    assert "Things to try" in str(raised.value)


def test_the_board_is_looked_for_where_west_build_looks() -> None:
    none, named = west_arguments.parse(None), west_arguments.parse("-b option")
    environment = {"BOARD": "environment"}
    assert west_arguments.chosen_board(named, environment, "configuration") == "option"
    assert west_arguments.chosen_board(none, environment, "configuration") == "environment"
    assert west_arguments.chosen_board(none, {}, "configuration") == "configuration"
    assert west_arguments.chosen_board(none, {}, None) is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["lf-fed-build"], "one LF file is needed, and it is missing"),
        (["lf-fed-build", "a.lf", "b.lf"], "one LF file is needed, and these are 2: a.lf b.lf"),
        (["lf-fed-build", "a.lf", "--bord=x"], "unknown option: --bord=x; arguments for CMake come after --"),
        (["lf-fed-build", "a.lf", "-j", "0"], "'0' is not a number from 1 on"),
        (["lf-fed-build", "-f", "a", "x.lf"], "x.lf looks like the LF file; write it before -f"),
        (["lf-fed-build", "-c", "a.conf", "x.lf"], "x.lf looks like the LF file; write it before -c"),
        (["lf-build", "a.lf", "--federate", "x"], "unknown option: --federate"),
        (["lf-fed-run", "a.lf", "--rti-port", "65536"], "'65536' is not a port"),
        (["lf-fed-flash", "a.lf", "-n"], "-n/--number: expected one argument"),
        (["lf-fed-flash", "a.lf", "-n", "all"], "'all' is not a number from 1 on"),
        (["lf-fed-sing"], "invalid choice"),
    ],
)
def test_wrong_command_lines_are_named(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        main(arguments)
    assert raised.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("name", ["nothing.lf", "src/Grod.lf"])
def test_a_missing_file_is_named_with_those_that_are_there(
    name: str, world: World, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as raised:
        main(["lf-fed-build", str(world.application / name)])
    assert raised.value.code == 1
    error = capsys.readouterr().err
    assert f"there is no LF file {world.application / name}" in error
    assert "Things to try" in error
    assert "Grid.lf" in error


def test_a_file_of_another_kind_is_refused(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["lf-build", str(world.touch("prj.conf"))])
    assert "its name does not end in .lf" in capsys.readouterr().err
