# SPDX-License-Identifier: Apache-2.0
"""`west lf-fed-build`"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable

from lf_west import description, west_arguments
from lf_west.application import Application, open_application
from lf_west.build import Request, Surroundings, build_images, cargo_folder, generate, images, rows
from lf_west.command import LfCommand
from lf_west.description import Description, with_spares
from lf_west.errors import LfError
from lf_west.options import add_build_options, build_options_given
from lf_west.summary import table
from lf_west.workspace import find_workspace

_DESCRIPTION = """\
Build every federate of a federated Lingua Franca program: those on boards as Zephyr images, the others as programs of
this computer.

Where each federate runs stands in the deployment file; a board in --west-commands overrides it for all images. Each
image gets what its federate needs, then from the application's folder prj.conf, boards/BOARD.*, prj_FEDERATE.conf and
boards/BOARD_FEDERATE.* (.conf and .overlay), then the files of --conf-overlays.
"""


def fed_request(application: Application, args: argparse.Namespace, cmake_arguments: list[str]) -> Request:
    """Return the request that the options of a federated build describe."""
    return Request(
        application=application,
        west=west_arguments.parse(args.west_commands),
        conf_overlays=application.conf_overlays(args.conf_overlays),
        cmake_arguments=cmake_arguments,
        lfc=args.lfc,
        generate=not args.no_lfc,
        deployment=application.deployment(args.deployment),
        federates=tuple(args.federate),
    )


class LfFedBuild(LfCommand):
    """All federates, each in a build folder of its own."""

    def __init__(self) -> None:
        """Its texts."""
        super().__init__("lf-fed-build", "build every federate of a federated Lingua Franca program", _DESCRIPTION)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the build."""
        add_build_options(parser, federated=True)

    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Build all, then say what came out."""
        application = open_application(file, args.build_dir)
        request = fed_request(application, args, cmake_arguments)
        build_federation(self, request, args.jobs)


def federation_of(
    command: LfCommand,
    application: Application,
    args: argparse.Namespace,
    cmake_arguments: list[str],
    check: Callable[[Description], object] = lambda _: None,
) -> Description:
    """A federation that is to be run or flashed: built as the options say, or with --no-build what was built before."""
    if not args.no_build:
        return build_federation(command, fed_request(application, args, cmake_arguments), args.jobs, check=check)
    without_effect = build_options_given(args, cmake_arguments)
    if without_effect:
        command.wrn(f"without effect beside --no-build: {', '.join(without_effect)}")
    return description.load(application.description)


def build_federation(
    command: LfCommand, request: Request, parallel: int, check: Callable[[Description], object] = lambda _: None
) -> Description:
    """Build what was requested and print the summary; what the compiler said about all of it is returned.

    `check` can refuse it before the images are built, which takes long.
    """
    surroundings = Surroundings(os.environ, command.config.get("build.board"), command.inf)
    described = generate(request, surroundings)
    if not described.is_federated:
        raise LfError(
            f"{described.program} is not federated, so it is a single image.",
            f"Build it: west lf-build {request.application.file}",
            "Write `federated reactor` instead of `main reactor`.",
        )
    check(described)
    participants = with_spares(described.select(list(request.federates)))
    planned = images(request, participants, described.is_federated, cargo_folder(os.environ))
    if planned:
        workspace = find_workspace(os.environ, command.topdir)
        build_images(planned, request, workspace, surroundings, parallel)
    command.inf(table(rows(participants, planned)))
    return described
