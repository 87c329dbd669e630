# SPDX-License-Identifier: Apache-2.0
"""Lines of several participants on one terminal, each with the name of who wrote it."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from typing import TextIO

# What the codes begin with that images without texts log.
_CODE = "lf#"

# Of terminals; each participant keeps its own.
_COLOURS = (36, 33, 32, 35, 34, 96, 93, 92, 95, 94)


class Output:
    """Prefixes lines and writes them at once."""

    def __init__(
        self,
        own_name: str,
        names: Iterable[str],
        standard: TextIO | None = None,
        error: TextIO | None = None,
        explain: Callable[[str], str] = lambda text: text,
    ) -> None:
        """Make room for the names; `own_name` is under which the command itself speaks. `explain` puts sentences in
        place of codes."""
        self._explain = explain
        self._own_name = own_name
        names = list(names)
        self._colours = {name: _COLOURS[index % len(_COLOURS)] for index, name in enumerate(names)}
        self._width = max(len(name) for name in (own_name, *names))
        self._standard = sys.stdout if standard is None else standard
        self._error = sys.stderr if error is None else error
        # Set when nobody reads any more, so that there is no point in going on.
        self.is_closed = False

    def line(self, name: str, is_error: bool, text: str) -> None:
        """Show a line of a participant, with sentences in place of codes."""
        if _CODE in text:
            text = self._explain(text)
        self._write(name, self._colours.get(name), self._error if is_error else self._standard, text)

    def note(self, text: str) -> None:
        """Say something in the command's own name."""
        self._write(self._own_name, 1, self._error, text)

    def _write(self, name: str, colour: int | None, stream: TextIO, text: str) -> None:
        prefix = f"{name:{self._width}} |"
        if colour is not None and stream.isatty() and "NO_COLOR" not in os.environ:
            prefix = f"\x1b[{colour}m{prefix}\x1b[0m"
        try:
            stream.write(f"{prefix} {text}\n")
            stream.flush()
        except BrokenPipeError:
            self.is_closed = True
