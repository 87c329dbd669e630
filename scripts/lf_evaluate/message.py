# SPDX-License-Identifier: Apache-2.0
"""The message test: how long a message takes, and how many get through (thesis, section 6.2)."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from lf_evaluate import figures, thesis
from lf_evaluate.measured import Measured, Run, in_turns, no_result_in, spread_out
from lf_evaluate.peers import RUNTIMES, Lfc, of_target
from lf_evaluate.results import Finding, finding
from lf_evaluate.setting import (
    PROGRAMS,
    TIME_LIMIT,
    Setting,
    Word,
    application,
    build_folder,
    deployment,
    execute,
    variant,
)

COORDINATIONS = ("centralized", "decentralized")
# As in MessageDelays.lf.
MESSAGES = 1000
PERIOD_MS = 10
# Periods in µs, and how many messages there are: as in the thesis, and ten times as many.
RATES = ((100, 3000), (10, 30_000))
# Pairs of a sender and a receiver, and how many messages each of them has.
FLOW_PAIRS = (1, 8)
FLOW_MESSAGES = 100_000
FLOW_TARGETS = ("Rust", "C")
# LF's C runtime takes less for the messages of all pairs.
LFC_TIMEOUT = "60 s"
# Virtual boards, by their names for people and for Zephyr.
BOARDS = (("qemu_cortex_m3", "qemu_cortex_m3"), ("native_sim", "native_sim/native/64"))
# Twenty times as many messages per second as between the boards of the thesis.
BOARD_RATE = 12_000


def delay(setting: Setting) -> Finding:
    """Measure the latency of messages on Linux, and of the same bytes over a raw connection, in turns."""
    # The clock of native_sim stands still while the program works, and lags behind by as much afterwards; the clocks
    # of two images differ by more than what is measured here.
    files = {coordination: _delay_program(coordination) for coordination in COORDINATIONS}
    for file in files.values():
        setting.build("Linux", file)
    seen: list[Measured] = []
    for _ in range(setting.rounds):
        (raw,) = setting.bench("raw", "--exchanges", MESSAGES, "--period-ms", PERIOD_MS)
        for row, file in files.items():
            seen += [
                Measured(row, "federates", "µs", samples=delays_in(setting.run("Linux", file))),
                replace(raw, row=row),
            ]
    told = [Measured(row, "thesis", "median µs", delay) for row, delay in thesis.DELAYS.items()]
    arrived = [Measured(one.row, one.who, "arrived", float(len(one.samples))) for one in seen]
    drawn = [replace(one, who=one.row) if one.who == "federates" else one for one in seen]
    return finding(
        "Delay of messages",
        "How long does a message take from federate to federate?",
        [
            f"One way: {MESSAGES} messages of 8 bytes, {PERIOD_MS} ms apart; best of {setting.rounds} rounds.",
            "The raw connection carries the same 29 bytes from one process to another.",
        ],
        [*spread_out(seen, {"median": 50, "99 %": 99, "slowest": 100}), *arrived, *told],
        ["federates"],
        ["median µs"],
        figures=[figures.distributions("Delay of messages on Linux", drawn, thesis.delay_marks(), "figure 6.6")],
        limits=[
            "The thesis measured two boards of 1 GHz on a switch of 100 Mbit/s, every 100 ms, by an oscilloscope, and "
            "tells of its histogram only where about it lies; here both federates are on one computer. The part on "
            "virtual boards has Zephyr's network stack in between."
        ],
    )


def _delay_program(coordination: str) -> Path:
    text = (PROGRAMS / "MessageDelays.lf").read_text(encoding="utf-8")
    text = text.replace("coordination: decentralized", f"coordination: {coordination}")
    return variant("MessageDelays" + coordination.title(), text.replace("../../../applications", str(application(""))))


def delays_in(output: str) -> tuple[float, ...]:
    """The lines `delay 120345 ns`, in µs."""
    delays = tuple(int(found) / 1000 for found in re.findall(r"delay (\d+) ns$", output, re.MULTILINE))
    if not delays:
        raise no_result_in(output)
    return delays


def rate(setting: Setting) -> Finding:
    """Measure the throughput in messages per second, and check that none is lost."""
    seen = []
    for coordination in COORDINATIONS:
        for period_us, messages in RATES:
            file = _rate_program(coordination, period_us * 1000, messages)
            row = f"{coordination}, {messages} messages, one per {period_us} µs"
            for board in setting.boards():
                setting.build(board, file)
                for _ in range(setting.rounds):
                    seen += rate_in(row, board, setting.run(board, file))
            seen += thesis.rates(row, coordination)
    return finding(
        "Messages per second",
        "How many messages get through from a federate to another one, and do all of them?",
        [f"Best of {setting.rounds} rounds; messages of 4 bytes; the timer of the program limits the rate."],
        seen,
        setting.boards(),
        ["messages/s"],
        figures=[figures.dots("Messages/s", figures.axis("messages/s", True), "messages/s", seen, thesis="table 6.1")],
        limits=[
            "The thesis sent 3000 messages, one per 100 µs, between two boards; here both federates are on one "
            "computer. At a period of 100 µs there cannot be more than 10,000 messages/s."
        ],
    )


def _rate_program(coordination: str, period_ns: int, messages: int) -> Path:
    """MessageTest.lf with this number of messages, one in each period."""
    text = f"""target Rust {{ coordination: {coordination} }}
import Sender, Receiver from "{application("message_test/src/MessageTest.lf")}"
federated reactor {{
    sender = new Sender(period = {period_ns} nsec, iterations = {messages})
    receiver = new Receiver(iterations = {messages})
    sender.y -> receiver.x
}}
"""
    return variant("MessageRate", text)


def rate_in(row: str, who: str, output: str) -> list[Measured]:
    """Parse `received 3000 of 3000 messages in order, 9938 messages per second`."""
    found = re.search(r"received (\d+) of \d+ messages in order, ([\d.]+) messages per second", output)
    if found is None:
        raise no_result_in(output)
    received, per_second = map(float, found.groups())
    return [Measured(row, who, "messages/s", per_second), Measured(row, who, "received", received)]


def flow(setting: Setting) -> Finding:
    """Measure the messages per second of federates whose senders are as fast as they can be, in turns."""
    lfc = Lfc.of(setting)
    runs: list[Run] = []

    def add(row: str, who: str, pairs: int, run: Callable[[], str]) -> None:
        runs.append((row, who, lambda: [Measured(row, who, "messages/s", flow_in(run(), pairs))]))

    for coordination in COORDINATIONS:
        for pairs in FLOW_PAIRS:
            row = f"{coordination}, {2 * pairs} federates"
            for target in FLOW_TARGETS:
                text = _flow_text(coordination, target, pairs)
                name = f"Flow{target}{coordination.title()}{2 * pairs}"
                file = variant(name, text)
                setting.build("Linux", file)
                add(row, f"bodies in {target}", pairs, partial(setting.run, "Linux", file))
                if lfc is not None and target == "C":
                    # Without a time-out, LF's federates do not end: receivers wait for what may still come.
                    properties = f"coordination: {coordination}, timeout: {LFC_TIMEOUT}, {lfc.properties(target)}"
                    program = lfc.build(variant(f"{name}OfLfc", of_target(text, target, properties)))
                    add(row, RUNTIMES[target], pairs, partial(execute, [program], errors=True))
    ours = [f"bodies in {target}" for target in FLOW_TARGETS]
    seen = in_turns(setting.rounds, runs, must_succeed=ours)
    return finding(
        "Throughput of federates",
        "How many messages get through where no timer limits the senders?",
        [
            f"Pairs of a sender and a receiver, {FLOW_MESSAGES} messages of 4 bytes each; the sum of all pairs.",
            f"Best of {setting.rounds} rounds, in turns.",
            "Each message causes the next one, a microstep later.",
        ],
        seen,
        ours,
        ["messages/s"],
        figures=[figures.dots("Messages/s without a limit", figures.axis("messages/s", True), "messages/s", seen)],
        limits=["All federates share the processors of one computer."],
    )


def _flow_text(coordination: str, target: str, pairs: int) -> str:
    """Return a program with pairs of the federates of FlowRust.lf or FlowC.lf."""
    reactors = (PROGRAMS / f"Flow{target}.lf").read_text(encoding="utf-8")
    federation = f"""
federated reactor {{
    sender = new[{pairs}] Sender(count = {FLOW_MESSAGES})
    receiver = new[{pairs}] Receiver(count = {FLOW_MESSAGES})
    sender.y -> receiver.x
}}
"""
    return of_target(f"{reactors}{federation}", target, f"coordination: {coordination}")


def flow_in(output: str, pairs: int) -> float:
    """Parse `received 3000 of 3000 messages in 345678 ns` of each receiver; the sum of their rates."""
    found = re.findall(r"received (\d+) of (\d+) messages in (\d+) ns", output)
    if len(found) != pairs or any(received != count for received, count, _ in found):
        raise no_result_in(output)
    return sum((int(received) - 1) * 1e9 / max(1, int(time)) for received, _, time in found)


def boards(setting: Setting) -> Finding:
    """The same between virtual boards with Zephyr's own network stack, beside a raw connection between the images."""
    seen = []
    for name, board in BOARDS[:1] if setting.quick else BOARDS:
        for coordination in COORDINATIONS:
            row = f"{name}, {coordination}"
            text = (PROGRAMS / "BoardDelay.lf").read_text(encoding="utf-8")
            if coordination == "centralized":
                # Only where no RTI says who may go on does anybody wait by himself.
                text = text.replace("coordination: decentralized", "coordination: centralized")
                text = text.replace("@maxwait(0)", "")
            file = variant("BoardDelay", text)
            room = PROGRAMS / "raw_connection.conf"
            for output in _on_boards(setting, file, board, coordination, ("asker", "answerer"), "-c", room):
                seen += board_delays_in(row, output)
            file = _rate_program(coordination, 1_000_000_000 // BOARD_RATE, BOARD_RATE)
            for output in _on_boards(setting, file, board, coordination, ("sender", "receiver")):
                seen += rate_in(row, "federates", output)
            seen.append(Measured(row, "thesis", "median µs", thesis.DELAYS[coordination]))
            seen += thesis.rates(row, coordination)
    axes = {"messages/s": figures.axis("messages/s", True), "median µs": figures.axis("delay in µs", True)}
    return finding(
        "Virtual boards",
        "How long do messages take between boards with Zephyr's own network stack, and how many get through?",
        [
            f"The RTI is on this computer; best of {setting.rounds} rounds.",
            "Delay: half of the time until the answer; raw: between the same images in the same run.",
            f"Messages: {BOARD_RATE}, all of which would have to be sent in a second.",
        ],
        seen,
        ["federates"],
        ["median µs", "messages/s"],
        figures=[
            figures.dots("Delay of messages between boards", axes["median µs"], "median µs", seen, (), "figure 6.6"),
            figures.dots("Messages/s between boards", axes["messages/s"], "messages/s", seen, (), "table 6.1"),
        ],
        limits=[
            "QEMU and native_sim are not the thesis's boards: processor and time are this computer's, and the network "
            "is a bridge in its kernel. The raw connection of the same run is the fair comparison."
        ],
    )


def _on_boards(
    setting: Setting, file: Path, board: str, coordination: str, federates: tuple[str, str], *words: Word
) -> list[str]:
    """Return the output of two images on boards of their own, by round."""
    folder = build_folder(file) / board.replace("/", "_") / coordination
    places = deployment(f"{file.stem}.yaml", "host", dict.fromkeys(federates, board))
    setting.west("lf-fed-build", file, folder, "--deployment", places, *words)
    run = ("--no-build", "--timeout", TIME_LIMIT)
    return [setting.west("lf-fed-run", file, folder, *run) for _ in range(setting.rounds)]


def board_delays_in(row: str, output: str) -> list[Measured]:
    """Parse `federates: 1000 messages, delay in us: median 120, p99 164, max 200`, and the same behind `raw`."""
    pattern = r"\| (federates|raw): \d+ messages, delay in us: median (-?\d+), p99 (-?\d+), max"
    found = {who: values for who, *values in re.findall(pattern, output)}
    if len(found) < 2:
        raise no_result_in(output)
    return [
        Measured(row, "raw TCP" if who == "raw" else who, unit, float(value))
        for who, values in found.items()
        for unit, value in zip(("median µs", "99 % µs"), values, strict=True)
    ]
