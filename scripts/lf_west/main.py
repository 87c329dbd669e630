# SPDX-License-Identifier: Apache-2.0
"""The commands without west around them.

West offers the extension commands of a workspace's manifest only. In a workspace with another manifest the same
commands are run by `scripts/lf`, with the same arguments.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from west.commands import CommandError, Verbosity
from west.configuration import Configuration

from lf_west.build_command import LfBuild
from lf_west.command import LfCommand
from lf_west.fed_build_command import LfFedBuild
from lf_west.fed_flash_command import LfFedFlash
from lf_west.fed_run_command import LfFedRun
from lf_west.run_command import LfRun


def all_commands() -> list[LfCommand]:
    """One of each command."""
    return [LfBuild(), LfFedBuild(), LfFedFlash(), LfFedRun(), LfRun()]


def main(arguments: Sequence[str]) -> int:
    """Run one command and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="lf", description="The west commands of lf-zephyr-rs, for any Zephyr workspace.", allow_abbrev=False
    )
    parser.add_argument("-v", "--verbose", action="count", default=0, help="say more; may be given up to three times")
    subparsers = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    commands: dict[str, LfCommand] = {}
    for command in all_commands():
        command.add_parser(subparsers)
        commands[command.name] = command
    args, unknown = parser.parse_known_args(arguments)
    command = commands[args.command]
    command.verbosity = Verbosity(min(Verbosity.INF + args.verbose, Verbosity.DBG_EXTREME))
    try:
        command.run(args, unknown, topdir="", config=Configuration())
    except CommandError as error:
        return int(error.returncode)
    return 0
