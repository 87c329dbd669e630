# SPDX-License-Identifier: Apache-2.0
"""The command line: which parts are measured, and where the results go."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from lf_evaluate import clocks, engine, grid, machine, message, page, results, rti, sizes, suite
from lf_evaluate.results import Finding
from lf_evaluate.setting import Setting
from lf_west.errors import LfError

# In the order in which they are measured, with what `--help` says of them.
PARTS: dict[str, tuple[Callable[[Setting], Finding], str]] = {
    "engine": (engine.engine, "what a reaction costs in a program that is not federated"),
    "suite": (suite.suite, "LF's benchmarks, from a clone that --benchmarks names"),
    "latency": (rti.latency, "how long grants and messages are on their way"),
    "throughput": (rti.throughput, "messages per second, processor time for each, and memory"),
    "encryption": (rti.encryption, "what encrypted connections cost beside plain ones, on Linux"),
    "growth": (rti.growth, "what a grant takes as the federation grows"),
    "large": (rti.large, "one large federation from its start to its end"),
    "clock": (clocks.clock, "how far clocks are apart, in virtual time"),
    "initial": (rti.initial, "how evenly an RTI answers in the exchanges before the start"),
    "pins": (clocks.pins, "how far apart two participants toggle their pins, from a --recording"),
    "delay": (message.delay, "how long a message takes on Linux, beside a raw connection"),
    "rate": (message.rate, "how many messages get through in a second"),
    "flow": (message.flow, "how many messages get through where no timer limits the senders"),
    "grid": (grid.grid, "how long the smart grid takes to react; takes minutes"),
    "after": (grid.after, "the smallest delay of the smart grid's connections; takes up to half an hour"),
    "drift": (clocks.drift, "a drifting clock, synchronized for ten minutes"),
    "boards": (message.boards, "delay and rate between virtual boards, beside a raw connection"),
    "sizes": (sizes.sizes, "flash and RAM of images for a small board, and what of them is this project's"),
}
NEEDS_ZEPHYR = ("drift", "boards", "sizes")
# Options without which a part is left out.
NEEDS = {"pins": "recording", "suite": "benchmarks"}


def main(arguments: Sequence[str]) -> int:
    """Measures what was asked for, or makes the page of what was measured before; the exit status."""
    try:
        return _run(arguments)
    except LfError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def _run(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    if options.source is not None and options.report is None:
        raise LfError("--from needs --report FOLDER, where the page goes")
    if options.report is not None:
        page.require_libraries()
        _make(options.report)
    if options.source is not None:
        _write(options.report, results.load(options.source))
        return 0
    numbers = {name: getattr(options, name) or (quick if options.quick else usual)
               for name, (_, usual, quick, _) in NUMBERS.items()}  # fmt: skip
    # Images are built only where ZEPHYR_BASE names a workspace; `cargo xtask evaluate` sets it.
    has_zephyr = "ZEPHYR_BASE" in os.environ
    setting = Setting(
        options.built,
        options.stock_rti,
        options.lfc,
        options.reactor_rs,
        options.benchmarks,
        options.quick,
        options.recording,
        has_zephyr,
        **numbers,
    )
    names = []
    for name in (name for name in PARTS if not options.only or name in options.only):
        need = NEEDS.get(name)
        if need is None or getattr(setting, need) is not None:
            names.append(name)
        elif options.only:
            raise LfError(f"--only {name} needs --{need} {need.upper()}")
    measured: dict[str, Any] = {
        "format": results.FORMAT,
        "begun": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "quick": setting.quick,
        "arguments": list(arguments[1:]),
        "machine": machine.this(setting),
        "parts": [],
    }
    for place, name in enumerate(names):
        left = f", then {', '.join(names[place + 1 :])}" if names[place + 1 :] else ""
        print(f"[{place + 1}/{len(names)}] {name}{left}", file=sys.stderr)
        measured["parts"].append(_part(name, setting))
        # After each part, so that nothing that was measured is lost.
        if options.report is not None:
            _write(options.report, measured)
    if options.report is not None:
        print(f"\nThe report is {options.report / 'report.html'}.")
    failed = [part["name"] for part in measured["parts"] if "failed" in part["outcome"]]
    if failed:
        raise LfError(f"failed: {', '.join(failed)}")
    return 0


def _part(name: str, setting: Setting) -> dict[str, Any]:
    """Measures a part; what became of it."""
    begin = time.monotonic()
    outcome: dict[str, Any]
    if name in NEEDS_ZEPHYR and not setting.has_zephyr:
        reason = "there is no Zephyr workspace; set ZEPHYR_BASE, or run `west zephyr-export` in one"
        print(f"\n{name} is left out: {reason}", flush=True)
        outcome = {"skipped": reason}
    else:
        try:
            finding = PARTS[name][0](setting)
            print(results.finding_text(finding), flush=True)
            outcome = {"measured": finding}
        except Exception as error:
            # Whatever it is, what was measured before is worth keeping, and so is what comes after.
            reason = str(error) if isinstance(error, (LfError, OSError)) else repr(error)
            print(f"error: {name}: {reason}", file=sys.stderr)
            outcome = {"failed": reason}
    return {"name": name, "seconds": round(time.monotonic() - begin, 3), "outcome": outcome}


def _make(folder: Path) -> None:
    """Makes a folder; tells now if it cannot be written to, and not after an hour."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".lf-evaluate"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise LfError(f"--report {folder}: {error.strerror}; name a folder that you may write to") from error


def _write(folder: Path, measured: dict[str, Any]) -> None:
    """Writes the results and their page, each as a whole: an interruption leaves the one before."""
    text = json.dumps(measured, ensure_ascii=False, indent=2) + "\n"
    for name, content in (("results.json", text), ("report.html", page.render(measured))):
        new = folder / f"{name}.new"
        try:
            new.write_text(content, encoding="utf-8")
            new.replace(folder / name)
        except OSError as error:
            raise LfError(f"{folder / name}: {error.strerror}") from error


# Numbers of the command line: what they are, their defaults, those of a quick run, and the least.
NUMBERS = {
    "rounds": ("how often each measurement is made, in turns; the best one counts", 3, 2, 1),
    "exchanges": ("how many exchanges a measurement of latency has", 5000, 1000, 1),
    "seconds": ("how many seconds a measurement of throughput or growth takes", 2, 1, 1),
    "large": ("how many federates the large federation has", 500, 100, 2),
    "large_seconds": ("how many seconds the large federation runs", 60, 5, 1),
    "iterations": ("how often the smart grid is run with each setting", 10, 3, 1),
    "after_runs": ("how often the smart grid runs without a violation before a delay is long enough", 100, 5, 1),
    "drift_seconds": ("how many seconds the application with the drifting clock runs", 600, 20, 2),
}


def _parser() -> argparse.ArgumentParser:
    width = max(map(len, PARTS))
    parser = argparse.ArgumentParser(
        prog="cargo xtask evaluate",
        description="Measures RTIs side by side, and the applications of this repository, on this computer.",
        epilog="The parts:\n" + "\n".join(f"  {name:{width}}  {text}" for name, (_, text) in PARTS.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    # The folder of lf-bench and lfz, which `cargo xtask evaluate` names.
    parser.add_argument("built", type=Path, help=argparse.SUPPRESS)
    for option, text in (
        ("--stock-rti", "the stock RTI, to be measured beside ours"),
        ("--lfc", "LF's compiler, whose C programs are to be measured beside ours"),
        ("--reactor-rs", "LF's Rust runtime, so that programs in Rust that --lfc compiles are measured, too"),
    ):
        parser.add_argument(option, type=Path, metavar="PATH", help=text)
    parser.add_argument(
        "--benchmarks", type=Path, metavar="FOLDER", help="a clone of LF's benchmarks-lingua-franca, for `suite`"
    )
    parser.add_argument(
        "--report", type=Path, metavar="FOLDER", help="write results.json and report.html there, after each part"
    )
    parser.add_argument(
        "--from",
        dest="source",
        type=Path,
        metavar="RESULTS",
        help="measure nothing, and make the page of results that were written before",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="measure everything in short: numbers are rough, and all takes minutes. The smart grid and the rate run "
        "on Linux alone, and of virtual boards and images only the first ones are measured",
    )
    parser.add_argument(
        "--recording",
        type=Path,
        metavar="VCD",
        help="what was recorded at two pins that are toggled at the same logical times, for the thesis's figure 6.3",
    )
    parser.add_argument(
        "--only", action="append", choices=PARTS, metavar="PART", help="measure only this; may be repeated"
    )
    for name, (text, usual, quick, least) in NUMBERS.items():
        text = f"{text} ({usual}; {quick} with --quick)"
        parser.add_argument(f"--{name.replace('_', '-')}", type=_from(least), metavar="N", help=text)
    return parser


def _from(least: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is no number from {least} on")
        return int(text)

    return parse
