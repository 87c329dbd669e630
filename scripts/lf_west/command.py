# SPDX-License-Identifier: Apache-2.0
"""The common base of the commands: their failures, and the arguments that are not options."""

from __future__ import annotations

import argparse
from abc import abstractmethod

from west.commands import WestCommand

from lf_west.errors import LfError


class LfCommand(WestCommand):
    """A west command that works on an LF file and reports its failures as `LfError`."""

    def __init__(self, name: str, help_text: str, description: str) -> None:
        """Arguments as for a west command; a west workspace is looked for later, and not only around here."""
        super().__init__(name, help_text, description, accepts_unknown_args=True, requires_workspace=False)

    def do_add_parser(
        self, parser_adder: argparse._SubParsersAction[argparse.ArgumentParser]
    ) -> argparse.ArgumentParser:
        """A parser with this command's texts and options.

        The file is no argument of the parser, because argparse lets a positional argument swallow the `--` behind it.
        """
        parser = parser_adder.add_parser(
            self.name,
            help=self.help,
            usage="%(prog)s [-h] FILE.lf [option ...] [-- CMAKE_ARGUMENT ...]",
            description=self.description,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            # Abbreviated options would be mistaken for arguments of others.
            allow_abbrev=False,
        )
        parser.add_argument_group("argument", "FILE.lf: the main LF file, such as src/Example.lf")
        self.add_options(parser)
        return parser

    def do_run(self, args: argparse.Namespace, unknown: list[str]) -> None:
        """Run, and turn a failure into west's way to die."""
        file, cmake_arguments = self._split(unknown)
        try:
            self.execute(file, args, cmake_arguments)
        except LfError as error:
            self.die(str(error), exit_code=error.status)

    def _split(self, unknown: list[str]) -> tuple[str, list[str]]:
        """The LF file, and what follows `--`; anything else is a mistake."""
        separator = unknown.index("--") if "--" in unknown else len(unknown)
        words, cmake_arguments = unknown[:separator], unknown[separator + 1 :]
        options = [word for word in words if word.startswith("-")]
        if options:
            self.parser.error(f"unknown option: {' '.join(options)}; arguments for CMake come after --")
        if len(words) != 1:
            found = f"these are {len(words)}: {' '.join(words)}" if words else "it is missing"
            self.parser.error(f"one LF file is needed, and {found}")
        return words[0], cmake_arguments

    @abstractmethod
    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add this command's options."""

    @abstractmethod
    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Do what the command is for; an `LfError` ends it."""
