# SPDX-License-Identifier: Apache-2.0
"""`west lf-fed-flash`"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
from collections.abc import Sequence

from lf_west import description, flash, probes
from lf_west.application import Application, open_application
from lf_west.command import LfCommand
from lf_west.description import SPARE, Description, Participant
from lf_west.errors import LfError
from lf_west.fed_build_command import federation_of
from lf_west.flash import Flash
from lf_west.options import add_build_options, positive
from lf_west.runners import zephyr_runners
from lf_west.workspace import Workspace, find_workspace

_DESCRIPTION = """\
Build a federated Lingua Franca program as `lf-fed-build` does, then flash each image onto its own board with
`west flash`: the RTI's first, if it has a board, then the federates'.

The deployment file names the probe of each board, which is the serial number of its debugger or of what else it is
connected by, and its runner, where it is not to be the board's default:

  federates:
    a: { platform: mimxrt1170_evk@B/mimxrt1176/cm7, ip: 10.0.0.2, runner: pyocd, probe: 0244000041… }

A spare board has its own `probe`, in `spare`; `-f a-spare` flashes that board alone.

Nothing is flashed when a probe is missing, is not connected, belongs to two images, or may be one of several.
Federates on this computer, native_sim and QEMU are not flashed; `lf-fed-run` runs them, and is told at the end.
"""


class LfFedFlash(LfCommand):
    """A federation from its build onto its boards."""

    def __init__(self) -> None:
        """Its texts."""
        super().__init__(
            "lf-fed-flash", "flash the images of a federated Lingua Franca program, each onto its board", _DESCRIPTION
        )

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the build and the flashing."""
        add_build_options(parser, federated=True, short_no_lfc=False)
        parser.add_argument("--no-build", action="store_true", help="flash what was built before")
        parser.add_argument(
            "-n",
            "--number",
            metavar="N",
            type=positive,
            help="flash the first N boards of the program; default: all (not to run the compiler is --no-lfc here)",
        )
        parser.add_argument("--dry-run", action="store_true", help="flash nothing: print the commands that would")
        parser.add_argument(
            "--flash-arguments",
            metavar="ARGUMENTS",
            default="",
            help='further arguments for `west flash`, as one text: --flash-arguments="--erase"',
        )

    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Build, flash one board after the other, and say what is to be started then."""
        application = open_application(file, args.build_dir)
        further = _taken_apart(args.flash_arguments)

        def chosen(described: Description) -> list[Participant]:
            boards = flash.select(described, args.federate, args.number, application.file)
            flash.check_early(boards)
            return boards

        # The images of both boards of a federate are built together.
        federates = list(dict.fromkeys(name.removesuffix(SPARE) for name in args.federate))
        build = argparse.Namespace(**{**vars(args), "federate": federates})
        boards = chosen(federation_of(self, application, build, cmake_arguments, check=chosen))
        workspace = find_workspace(os.environ, self.topdir)
        flashes = flash.plan(application, boards, zephyr_runners(workspace), further)
        if args.dry_run:
            for item in flashes:
                self.inf(item.text())
        else:
            by_name = {item.name: item for item in flashes}
            probes.check_connected([item.target for item in flashes], lambda target: by_name[target.name].text())
            self._flash(flashes, workspace)
        # This build may be of a part only.
        everybody = description.load(application.description)
        left_out = [item.name for item in flash.without_probe(everybody) if not args.federate]
        if left_out:
            self.inf(f"not flashed: {', '.join(left_out)}, for which `spare` names no probe")
        self.inf(_afterwards(application, everybody))

    def _flash(self, flashes: Sequence[Flash], workspace: Workspace) -> None:
        """One after the other, because tools for probes disturb each other; the first failure ends it."""
        environment = workspace.environment(os.environ)
        for index, item in enumerate(flashes):
            self.inf(f"{item.name}: flashing with {item.runner} by the probe {item.probe}")
            status = subprocess.call(item.command(), cwd=workspace.topdir, env=environment)
            if status != 0:
                names = [other.name for other in flashes]
                done = f"; {', '.join(names[:index])} done" if index else ""
                raise LfError(
                    f"{item.name} could not be flashed{done}.",
                    "Read what the runner says above; a tool that it needs may have to be installed.",
                    f"Look at it alone: {item.text()}",
                    f"Flash what is missing: -f {' '.join(names[index:])}",
                    status=status if status > 0 else 128 - status,
                )
        self.inf(f"flashed: {', '.join(item.name for item in flashes)}")


def _taken_apart(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError as error:
        raise LfError(f"--flash-arguments: {error} in {text!r}.") from error


def _afterwards(application: Application, described: Description) -> str:
    """List the other programs to start: the RTI, if no board has it, and those of this computer."""
    here = [item for item in described.participants if flash.is_run_here(item)]
    if here:
        names = [item.name for item in here] + ([] if described.has_rti_image else ["the RTI"])
        command = flash.run_command(here, application.file)
        return f"on this computer, start {', '.join(names)}: {command} --no-build"
    if described.rti is not None and not described.has_rti_image:
        rti = described.rti
        words = ["lfz", "rti", "--id", rti.federation_id, "--port", str(rti.port), *rti.options]
        return f"on this computer, start the RTI: {shlex.join(words)}"
    return "the boards start by themselves"
