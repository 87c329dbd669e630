# SPDX-License-Identifier: Apache-2.0
"""`west lf-fed-run`"""

from __future__ import annotations

import argparse
import math
import os
from dataclasses import replace
from pathlib import Path

from lf_west import compiler, description
from lf_west.application import open_application
from lf_west.command import LfCommand
from lf_west.fed_build_command import federation_of
from lf_west.federation import Bench, plan_federation
from lf_west.options import add_build_options, add_time_limit

_DESCRIPTION = """\
Build a federated Lingua Franca program as `lf-fed-build` does, then run its RTI and its federates on this computer:
programs, native_sim images, and images for boards that QEMU plays (qemu_cortex_m3, mps2/an385). A federate on another
board has to be started by hand; choose the others with -f.

Boards of QEMU, and native_sim images that have an `ip` in the deployment file, get a network with those addresses that
exists for this run only and is separate from all others. It needs root or a kernel that allows user namespaces.

`lfz ctl` starts, stops and swaps transient federates while it runs: a board for the spare one that it has in the
deployment file.

Each line of output bears the name of the participant that wrote it. ^C stops all participants, and so does the first
one that fails.

Exit status: 0 when all participants ended well; that of the first one that failed; 124 when --timeout ended the run;
130 after ^C.
"""


class LfFedRun(LfCommand):
    """A federation from its build to its result."""

    def __init__(self) -> None:
        """Its texts."""
        super().__init__(
            "lf-fed-run", "run a federated Lingua Franca program with its RTI on this computer", _DESCRIPTION
        )

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the build and the run."""
        add_build_options(parser, federated=True)
        parser.add_argument("--no-build", action="store_true", help="run what was built before")
        parser.add_argument(
            "--images",
            metavar="FOLDER",
            nargs="+",
            action="extend",
            default=[],
            type=Path,
            help="run the images in these build folders of `west build`, one for each federate on a board; with "
            "--deployment the federates on this computer are built, else nothing is",
        )
        parser.add_argument(
            "--without",
            metavar="FEDERATE",
            action="append",
            default=[],
            help="do not start this federate; `lfz ctl start` starts it while the others run",
        )
        add_time_limit(parser)
        parser.add_argument(
            "--rti-port",
            metavar="PORT",
            type=_port,
            help="the RTI's TCP port; default: a free one, or the deployed one when -f leaves federates out",
        )

        parser.add_argument(
            "--vcd",
            metavar="FILE",
            type=Path,
            help="write down what the pins of programs and of native_sim images do, by this computer's clock",
        )
        parser.add_argument(
            "--devices",
            metavar="SCRIPT",
            type=Path,
            help="what inputs do: a file of lines such as `100 ms sw0 1`; native_sim images find pins of it only",
        )
        parser.add_argument(
            "--drift",
            metavar="FEDERATE=RATE",
            type=_drift,
            action="append",
            default=[],
            help="what the clock of a native_sim image gains: 26e-6 for 26 microseconds in a second",
        )

    def execute(self, file: str, args: argparse.Namespace, cmake_arguments: list[str]) -> None:
        """Build, then become the program that runs all and ends with the status of the run."""
        application = open_application(file, args.build_dir)
        lfz = compiler.find(args.lfc, os.environ, self.inf)
        args.lfc = str(lfz.path)
        timeout_ns = None if args.timeout is None else lfz.nanoseconds(args.timeout, "--timeout")
        if args.images:
            described, folders = description.in_image_folders(args.images)
            application = replace(application, elsewhere=folders)
            if args.deployment is not None:
                deployment = application.deployment(args.deployment)
                here = lfz.build(application.file, application.generated, deployment=deployment, host_only=True)
                described = described.merged_over(here)
        else:
            described = federation_of(self, application, args, cmake_arguments)
        federation = plan_federation(
            application,
            described,
            lfz=lfz.path,
            federates=args.federate,
            port=args.rti_port,
            bench=Bench(args.vcd, args.devices, dict(args.drift)),
            without=args.without,
        )
        user = os.getuid()
        if federation.network is not None:
            federation.network.enter()
        lfz.supervise(federation.description(timeout_ns, user))


def _drift(text: str) -> tuple[str, float]:
    name, _, rate = text.rpartition("=")
    try:
        gain = float(rate)
    except ValueError:
        gain = math.nan
    # The difference of quartzes is far less than this.
    if not name or not abs(gain) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no federate and its drift, such as board=26e-6")
    return name, gain


def _port(text: str) -> int:
    number = int(text) if text.isascii() and text.isdigit() else 0
    if not 1 <= number <= 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 1 to 65535")
    return number
