# SPDX-License-Identifier: Apache-2.0
"""Clocks: the algorithms in virtual time, what an oscilloscope saw, and a federation while a clock drifts."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Any

from lf_evaluate import figures, thesis
from lf_evaluate.measured import Measured, no_result_in
from lf_evaluate.results import Figure, Finding, finding
from lf_evaluate.setting import Setting, Word, application, execute, variant
from lf_west.errors import LfError


def clock(setting: Setting) -> Finding:
    """Measure the difference of clocks, in virtual time."""
    seen = setting.bench("clock", "--rounds", setting.rounds)
    looks = {one.who: list(enumerate(one.samples)) for one in seen if one.samples}
    # The clock gains evenly, so all of its looks are on the line from the first to the last one.
    (begin, first), (end, last) = looks["init"][0], looks["init"][-1]
    slope = (last - first) / (end - begin)
    drawn = [*_with_line("init", looks["init"], first, slope), figures.curve("on", "on", looks["on"], "points")]
    return finding(
        "Error of a federate's clock",
        "How far are clocks apart, once and while the program runs?",
        [
            "Over 60 s, in virtual time; the first 5 s after the start do not count. The clock is 1 s off and gains "
            f"{thesis.DRIFT:.0f} µs/s; LF's defaults; the worst of {setting.rounds} seeds.",
            "The stock federate discards the exchanges before the start when their round trips differ by 100 µs or "
            "more, and then begins with the whole offset.",
        ],
        [one for one in seen if not one.samples],
        ["ours"],
        ["median µs"],
        "network, mode",
        max,
        [_offsets("Offset of a drifting clock, in virtual time", first, end, drawn)],
        [
            "The thesis measured two boards with an oscilloscope; these are the algorithms in virtual time, under "
            "delays that a seed decides. Their drift was made the thesis's."
        ],
    )


def _with_line(name: str, points: Sequence[tuple[float, float]], begin: float, slope: float) -> list[dict[str, Any]]:
    end = points[-1][0]
    line = [(0.0, begin), (end, begin + slope * end)]
    return [figures.curve(name, "ours", points, "points"), figures.curve(f"{name}: {slope:.1f} µs/s", "ours", line)]


def _offsets(title: str, begin: float, end: float, drawn: list[dict[str, Any]]) -> Figure:
    line = [(0.0, begin), (end, begin + thesis.DRIFT * end)]
    return figures.curves(
        title,
        figures.axis("time in s"),
        figures.axis("offset in µs"),
        [*drawn, figures.curve(f"thesis: {thesis.DRIFT:.0f} µs/s", "thesis", line, "dashed")],
        "Each look at the clocks, and the line of regression. Of the thesis's line only the slope is known; it is "
        "drawn from our first point on.",
        thesis="figure 6.3",
    )


def pins(setting: Setting) -> Finding:
    """Measure the difference of two participants' pins in a recording."""
    if setting.recording is None:
        raise LfError("there is no --recording")
    scope: list[Word] = [setting.lfz, "scope", setting.recording, "--json"]
    one, other = two_of([signal["signal"] for signal in json.loads(execute(scope))["signals"]])
    report = json.loads(execute([*scope, "--reference", one, "--compare", other]))["compared"][0]
    delay, drift, pairs = report.get("delay"), report.get("drift"), report["pairs"]
    if not (delay and drift and pairs):
        raise LfError("the pins have too few edges in common; record the program for longer")
    first = pairs[0]["time_ns"]
    points = [((pair["time_ns"] - first) / 1e9, pair["delay_ns"] / 1e3) for pair in pairs]
    slope = drift["slope_us_per_s"]
    begin = drift["offset_us"] + slope * first / 1e9
    worst = max(abs(delay["min_us"]), abs(delay["max_us"]))
    told = {"edges": len(points), "at the start µs": begin, "drift µs/s": slope, "worst µs": worst}
    return finding(
        "Clocks at two pins",
        "How far apart do two participants toggle their pins at the same logical times?",
        [f"The edges of the pin {other} after those of the pin {one}, as recorded in {setting.recording}."],
        [
            *(Measured("init", "ours", unit, value) for unit, value in told.items()),
            Measured("init", "thesis", "drift µs/s", thesis.DRIFT),
        ],
        ["ours"],
        ["drift µs/s"],
        figures=[_offsets("Offset of two pins", begin, points[-1][0], _with_line("recorded", points, begin, slope))],
        limits=[
            "A recording by lfz run --vcd has the time that each participant takes for the federation's: it shows how "
            "late its reactions were. How far clocks were off as well is only in one with a time that both share."
        ],
    )


def two_of(signals: Sequence[str]) -> tuple[str, str]:
    """The first pin, and the first one of another participant, or else the next one."""
    if len(signals) < 2:
        raise LfError("the recording has fewer than two pins; record a program that toggles one in each federate")
    participant = signals[0].split(".")[0]
    others = [signal for signal in signals[1:] if signal.split(".")[0] != participant]
    return signals[0], (others or signals[1:])[0]


def drift(setting: Setting) -> Finding:
    """A board and a computer with clock synchronization `on`, decentralized, while the board's clock drifts."""
    text = application("clock_sync/src/ClockSync.lf").read_text(encoding="utf-8")
    file = variant("ClockSync", text.replace("timeout: 10 sec", f"timeout: {setting.drift_seconds} sec"))
    board = application("clock_sync/deployment/native_sim.yaml")
    setting.west("lf-fed-build", file, None, "--deployment", board)
    drift_of_board = f"board={thesis.DRIFT:.0f}e-6"
    said = setting.west("lf-fed-run", file, None, "--no-build", "--drift", drift_of_board)
    remark = re.compile("^(?!.*heard).*(?:late|clock|rounds).*$", re.MULTILINE)
    return finding(
        "A drifting clock",
        "Do clocks stay together while one of them drifts as the thesis's board did?",
        [
            "A program and a native_sim image, decentralized, clock synchronization on; the image's clock gains "
            f"{thesis.DRIFT:.0f} µs/s. Both send 100 messages a second for {setting.drift_seconds} s, and wait 10 ms "
            "for each.",
            *remark.findall(said),
        ],
        drift_in(said),
        limits=[
            "In the thesis synchronization while the program runs (`on`) did not work, so there is nothing to compare "
            "with. The computer has to be idle otherwise: it holds the participants up for longer than they wait."
        ],
    )


def drift_in(output: str) -> list[Measured]:
    """The numbers in `board | sent 900, heard 900, 0 late, the slowest after 812 us`."""
    pattern = r"^(\S+) *\| .*sent (\d+), heard (\d+), (\d+) late, the slowest after (\d+) us"
    found = re.findall(pattern, output, re.MULTILINE)
    if not found:
        raise no_result_in(output)
    units = ("sent", "heard", "late", "slowest µs")
    return [
        Measured(name, "", unit, float(value))
        for name, *values in found
        for unit, value in zip(units, values, strict=True)
    ]
