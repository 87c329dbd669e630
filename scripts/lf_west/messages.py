# SPDX-License-Identifier: Apache-2.0
"""Rustc's messages about the crates of images, at the lines of the LF program."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from lf_west.compiler import Compiler
from lf_west.errors import LfError
from lf_west.image import Image


def report(planned: Sequence[Image], find_compiler: Callable[[], Compiler]) -> None:
    """Show what there is to say about the images' crates on the standard error; nothing when all is well."""
    files = [image.messages for image in planned if any(_is_diagnostic(item) for item in _messages(image.messages))]
    if not files:
        return
    try:
        text = find_compiler().explain(files)
    except LfError as error:
        # The places are not those of the LF program, but better than none.
        text = "\n".join([*_as_rustc_prints(files), str(error), ""])
    sys.stderr.write(text)
    sys.stderr.flush()


def has_rust_errors(image: Image) -> bool:
    """Return whether rustc has said why the image could not be built."""
    return any(_is_diagnostic(item) and _is_error(item) for item in _messages(image.messages))


def _messages(file: Path) -> list[dict[str, Any]]:
    """Cargo's messages; a build that has not come as far as to cargo has none."""
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    return [item for item in map(_parsed, lines) if isinstance(item, dict)]


def _parsed(line: str) -> Any:
    try:
        return json.loads(line)
    except ValueError:
        # The end of a message is missing when cargo was killed.
        return None


def _is_diagnostic(item: dict[str, Any]) -> bool:
    return item.get("reason") == "compiler-message" and isinstance(item.get("message"), dict)


def _is_error(item: dict[str, Any]) -> bool:
    return str(item["message"].get("level")).startswith("error")


def _as_rustc_prints(files: Sequence[Path]) -> list[str]:
    items = [item for file in files for item in _messages(file) if _is_diagnostic(item) and _is_error(item)]
    return [str(item["message"].get("rendered") or item["message"].get("message")) for item in items]
