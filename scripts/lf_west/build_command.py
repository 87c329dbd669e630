# SPDX-License-Identifier: Apache-2.0
"""`west lf-build`"""

from __future__ import annotations

import argparse
import os
import subprocess

from lf_west import west_arguments
from lf_west.application import Application, open_application
from lf_west.build import Request, Surroundings, cargo_folder, environment, generate, images, report_messages, rows
from lf_west.command import LfCommand
from lf_west.description import Description
from lf_west.errors import LfError
from lf_west.image import Image
from lf_west.messages import has_rust_errors
from lf_west.options import add_build_options
from lf_west.summary import table
from lf_west.workspace import find_workspace

_DESCRIPTION = """\
Build a Lingua Franca program without federates as one Zephyr image.

The image gets what the program needs, then prj.conf and boards/BOARD.conf and .overlay of the application's folder,
then the files of --conf-overlays. The board is that of --west-commands, of BOARD, of west's build.board, or that
which the program's target property `platform` names.
"""


class LfBuild(LfCommand):
    """One main reactor, one image."""

    def __init__(self) -> None:
        """Its texts."""
        super().__init__("lf-build", "build a Lingua Franca program as one Zephyr image", _DESCRIPTION)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the build."""
        add_build_options(parser, federated=False)

    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Build, then say what came out."""
        build_program(self, open_application(file, args.build_dir), args, cmake_arguments)


def build_program(
    command: LfCommand, application: Application, args: argparse.Namespace, cmake_arguments: list[str]
) -> tuple[Description, Image]:
    """Generate, then let west build the image; what the compiler said, and the image."""
    request = Request(
        application=application,
        west=west_arguments.parse(args.west_commands),
        conf_overlays=application.conf_overlays(args.conf_overlays),
        cmake_arguments=cmake_arguments,
        lfc=args.lfc,
    )
    workspace = find_workspace(os.environ, command.topdir)
    surroundings = Surroundings(os.environ, command.config.get("build.board"), command.inf)
    described = generate(request, surroundings)
    if described.is_federated:
        raise LfError(
            f"{described.program} is federated: it has {len(described.participants)} images and an RTI.",
            f"Build all federates: west lf-fed-build {application.file}",
            f"Build and run them: west lf-fed-run {application.file}",
        )
    [image] = images(request, described.participants, described.is_federated, cargo_folder(os.environ))
    words = image.command()
    image.forget()
    # The command is west's whole screen, so that what it runs may also ask questions and show colours.
    status = subprocess.call(words, cwd=workspace.topdir, env=environment(application, workspace, surroundings))
    report_messages(request, [image], surroundings)
    if status != 0:
        raise LfError(
            f"{described.program} could not be built.",
            *(["Correct what rustc reports above."] if has_rust_errors(image) else []),
            'Make the build folder anew, if its settings are out of date: -w "-p always"',
            status=status if status > 0 else 128 - status,
        )
    image.remember()
    command.inf(table(rows(described.participants, [image])))
    return described, image
