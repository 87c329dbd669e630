# SPDX-License-Identifier: Apache-2.0
"""The arguments for `west build` that -w, --west-commands gives as one text."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn

from lf_west.errors import LfError


@dataclass(frozen=True)
class WestArguments:
    """The parsed arguments."""

    # None when it names no board.
    board: str | None
    # Whether it says itself when a build folder is made anew.
    has_pristine: bool
    # All but the board, for `west build`.
    rest: tuple[str, ...]
    # The arguments behind `--`, for CMake.
    cmake: tuple[str, ...]
    # The files of --extra-conf and --extra-dtc-overlay, which west would let replace the generated ones.
    extra_confs: tuple[str, ...] = ()
    extra_overlays: tuple[str, ...] = ()


class _Parser(argparse.ArgumentParser):
    """Reports mistakes instead of ending the program."""

    def error(self, message: str) -> NoReturn:
        """Raise what is wrong."""
        raise LfError(f"-w, --west-commands: {message}.", *_TRIES)


_TRIES = (
    'Give all arguments for `west build` as one text: -w "-b BOARD -p always"',
    "Give a text of one word with an equals sign: --west-commands=-v",
    "See `west build --help` for what it may contain.",
)


def parse(text: str | None) -> WestArguments:
    """Take the text apart as a shell would, and find the board in it."""
    try:
        words = shlex.split(text or "")
    except ValueError as error:
        raise LfError(f"-w, --west-commands: {error} in {text!r}.", *_TRIES) from error
    cmake: list[str] = []
    if "--" in words:
        separator = words.index("--")
        words, cmake = words[:separator], words[separator + 1 :]
    parser = _Parser(add_help=False, allow_abbrev=False)
    parser.add_argument("-b", "--board")
    parser.add_argument("-d", "--build-dir")
    parser.add_argument("-s", "--source-dir")
    parser.add_argument("-p", "--pristine", nargs="?", const="always")
    parser.add_argument("--extra-conf", action="append", default=[])
    parser.add_argument("--extra-dtc-overlay", action="append", default=[])
    known, rest = parser.parse_known_args(words)
    for option, value in (("-d, --build-dir", known.build_dir), ("-s, --source-dir", known.source_dir)):
        if value is not None:
            raise LfError(
                f"-w, --west-commands: {option} cannot be chosen there, because every federate has its own.",
                "Choose where all build folders go with the command's own option: --build-dir DIR",
            )
    if known.pristine is not None:
        rest = ["--pristine", known.pristine, *rest]
    return WestArguments(
        board=known.board,
        has_pristine=known.pristine is not None,
        rest=tuple(rest),
        cmake=tuple(cmake),
        extra_confs=tuple(known.extra_conf),
        extra_overlays=tuple(known.extra_dtc_overlay),
    )


def chosen_board(arguments: WestArguments, environment: Mapping[str, str], configured: str | None) -> str | None:
    """The board in the order in which `west build` looks: its arguments, BOARD, west's configuration build.board."""
    return arguments.board or environment.get("BOARD") or configured or None
