# SPDX-License-Identifier: Apache-2.0
"""The options that several commands have."""

from __future__ import annotations

import argparse
import os


def add_build_options(parser: argparse.ArgumentParser, *, federated: bool, short_no_lfc: bool = True) -> None:
    """Add the options for compiling an LF file; with `short_no_lfc`, -n suppresses the generation."""
    parser.add_argument(
        "-w",
        "--west-commands",
        metavar="ARGUMENTS",
        help='arguments for `west build`, as one text: -w "-b BOARD -p always"',
    )
    parser.add_argument(
        "-c",
        "--conf-overlays",
        metavar="CONF",
        nargs="+",
        action="extend",
        default=[],
        type=_not_an_lf_file("-c"),
        help="further configuration files, such as debug.conf, which count more than the others",
    )
    parser.add_argument(
        "--lfc",
        metavar="PATH",
        help="the LF compiler, lfz; default: LFZ in the environment, else that of this repository, built if need be",
    )
    parser.add_argument(
        "-d", "--build-dir", metavar="DIR", help="where everything is built; default: build in the application's folder"
    )
    if federated:
        parser.add_argument(
            *(["-n"] if short_no_lfc else []),
            "--no-lfc",
            action="store_true",
            help="do not run the compiler: build the images from what it generated before, changed by hand perhaps",
        )
        parser.add_argument(
            "-f",
            "--federate",
            metavar="FEDERATE",
            nargs="+",
            action="extend",
            default=[],
            type=_not_an_lf_file("-f"),
            help="only these federates; default: all",
        )
        parser.add_argument(
            "--deployment",
            metavar="FILE",
            help="where each federate runs; default: deployment.yaml in the application's folder, if there is one",
        )
        parser.add_argument(
            "-j",
            "--jobs",
            metavar="N",
            type=positive,
            default=os.cpu_count() or 1,
            help="how many images are built at once; default: one per processor (%(default)s)",
        )


def add_time_limit(parser: argparse.ArgumentParser) -> None:
    """Add the option for the time after which a run is stopped."""
    parser.add_argument("--timeout", metavar="TIME", help="stop all after this time: 90, 90s, 500ms, 2min")


def build_options_given(args: argparse.Namespace, cmake_arguments: list[str]) -> list[str]:
    """The options that would change a build, which do not change what was built before."""
    given = {
        "--west-commands": args.west_commands,
        "--conf-overlays": args.conf_overlays,
        "--deployment": args.deployment,
        "--no-lfc": args.no_lfc,
        "-- CMAKE_ARGUMENT": cmake_arguments,
    }
    return [name for name, value in given.items() if value]


def positive(text: str) -> int:
    """A number from 1 on."""
    number = int(text) if text.isascii() and text.isdigit() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 1 on")
    return number


class _NotAnLfFile:
    """An option that takes several words takes the LF file, too, when that comes last."""

    def __init__(self, option: str) -> None:
        self._option = option

    def __call__(self, text: str) -> str:
        if text.endswith((".lf", ".ulf")):
            raise argparse.ArgumentTypeError(f"{text} looks like the LF file; write it before {self._option}")
        return text


def _not_an_lf_file(option: str) -> _NotAnLfFile:
    return _NotAnLfFile(option)
