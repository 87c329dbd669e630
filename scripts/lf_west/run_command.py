# SPDX-License-Identifier: Apache-2.0
"""`west lf-run`"""

from __future__ import annotations

import argparse
import os

from lf_west import compiler, qemu
from lf_west.application import open_application
from lf_west.build_command import build_program
from lf_west.command import LfCommand
from lf_west.errors import LfError
from lf_west.image import Image, is_native_sim
from lf_west.options import add_build_options, add_time_limit

_DESCRIPTION = """\
Build a Lingua Franca program without federates as `lf-build` does, then run its image on this computer: on native_sim,
or on a board that QEMU plays (qemu_cortex_m3, mps2/an385).

Exit status: that of the program; 124 when --timeout ended the run; 130 after ^C.
"""


class LfRun(LfCommand):
    """One main reactor, from its build to its result."""

    def __init__(self) -> None:
        """Its texts."""
        super().__init__(
            "lf-run", "build a Lingua Franca program as one image and run it on this computer", _DESCRIPTION
        )

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the build and the run."""
        add_build_options(parser, federated=False)
        add_time_limit(parser)

    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Build, then become the program that runs the image and ends with its status."""
        lfz = compiler.find(args.lfc, os.environ, self.inf)
        args.lfc = str(lfz.path)
        timeout_ns = None if args.timeout is None else lfz.nanoseconds(args.timeout, "--timeout")
        described, image = build_program(self, open_application(file, args.build_dir), args, cmake_arguments)
        process = {
            "name": described.program,
            "words": _words(image),
            "crate": str(described.participants[0].crate),
            "status_line": qemu.STATUS_LINE if qemu.is_played(image.board) else None,
        }
        lfz.supervise(
            {"version": 1, "id": {"exactly": described.program}, "timeout_ns": timeout_ns, "federates": [process]}
        )


def _words(image: Image) -> list[str]:
    """The command that runs an image."""
    if is_native_sim(image.board):
        return [str(image.executable())]
    if not qemu.is_played(image.board):
        raise LfError(
            f"{image.board} does not run on this computer.",
            f"Flash it: west flash -d {image.folder}",
            f"Build it for a board that does: native_sim/native/64, {', '.join(qemu.boards())}",
        )
    if not qemu.is_installed():
        raise LfError(f"there is no {qemu.PROGRAM}, which plays {image.board}.", qemu.ADVICE)
    return qemu.command(image.board, image.executable())
