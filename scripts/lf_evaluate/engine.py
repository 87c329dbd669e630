# SPDX-License-Identifier: Apache-2.0
"""The cost of a reaction in programs that are not federated."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from lf_evaluate import figures
from lf_evaluate.measured import Measured, no_result_in
from lf_evaluate.peers import RUNTIMES, SINGLE_THREADED, WITHOUT, Lfc, of_target
from lf_evaluate.results import Finding, finding
from lf_evaluate.setting import PROGRAMS, Setting, execute, variant

TARGETS = ("Rust", "C")
# The least round counts, of this many at least: a single one may have had to share its processor.
ROUNDS_MIN = 7


@dataclass(frozen=True)
class Program:
    """A main reactor for the reactors of EngineRust.lf and EngineC.lf."""

    row: str
    name: str
    count: int
    # Reactions that run for each value that is counted; the few at the start and the end make no difference.
    reactions: int
    body: str


PROGRAMS_OF_ROWS = (
    Program(
        "ping-pong",
        "PingPong",
        1_000_000,
        3,
        "ping = new Ping(count = {count})\n    pong = new Pong()\n"
        "    ping.send -> pong.receive\n    pong.send -> ping.receive",
    ),
    Program(
        "chain of 100",
        "Chain",
        30_000,
        102,
        "source = new Source(count = {count})\n    stages = new[100] Stage()\n    sink = new Sink()\n"
        "    source.out, stages.send -> stages.receive, sink.receive",
    ),
    Program(
        "bank of 1000",
        "Bank",
        3_000,
        1001,
        "source = new Source(count = {count})\n    sinks = new[1000] Sink()\n    (source.out)+ -> sinks.receive",
    ),
)


def engine(setting: Setting) -> Finding:
    """Measure the cost of a reaction, with bodies in Rust and in C, and with LF's runtimes, in turns."""
    rounds = max(setting.rounds, ROUNDS_MIN)
    lfc = Lfc.of(setting)
    runs: list[tuple[Program, str, Callable[[], str]]] = []
    for program in PROGRAMS_OF_ROWS:
        for target in TARGETS:
            reactors = (PROGRAMS / f"Engine{target}.lf").read_text(encoding="utf-8")
            text = f"{reactors}\nmain reactor {{\n    {program.body.format(count=program.count)}\n}}\n"
            name = f"Engine{program.name}{target}"
            file = variant(name, text)
            setting.build("Linux", file)
            runs.append((program, f"bodies in {target}", partial(setting.run, "Linux", file)))
            if lfc is not None and target in lfc.targets():
                file = variant(f"{name}OfLfc", of_target(text, target, f"{SINGLE_THREADED}, {lfc.properties(target)}"))
                runs.append((program, RUNTIMES[target], partial(execute, [lfc.build(file)])))
    seen = [
        Measured(program.row, who, "ns/reaction", time / (program.count * program.reactions))
        for _ in range(rounds)
        for program, who, run in runs
        for time in [time_in(run())]
    ]
    return finding(
        "Cost of a reaction",
        "What does a reaction cost in a program that is not federated?",
        [
            f"Time from startup to shutdown by the number of reactions; best of {rounds} rounds, in turns.",
            "Ping-pong: three reactions in each tag. Chain: each stage triggers the next one, within a tag. Bank: one "
            "value triggers all members.",
        ],
        seen,
        [f"bodies in {target}" for target in TARGETS],
        ["ns/reaction"],
        figures=[figures.dots("A reaction", figures.axis("ns/reaction", False), "ns/reaction", seen)],
        limits=[] if lfc is not None else [WITHOUT],
    )


def time_in(output: str) -> float:
    """The time in a line `took 345678 ns`, in ns."""
    found = re.search(r"took (\d+) ns$", output, re.MULTILINE)
    if found is None:
        raise no_result_in(output)
    return float(found.group(1))
