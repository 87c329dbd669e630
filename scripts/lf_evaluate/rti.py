# SPDX-License-Identifier: Apache-2.0
"""RTIs side by side."""

from __future__ import annotations

from itertools import chain

from lf_evaluate import figures
from lf_evaluate.measured import Measured, spread_out
from lf_evaluate.results import Finding, finding
from lf_evaluate.setting import Setting

OURS = ("lfz rti",)
# From this standard deviation of its round trips on, a stock federate discards its exchanges before the start.
SPREAD_MAX_US = 100.0


def latency(setting: Setting) -> Finding:
    """Measure the latency of grants and messages through RTIs, and through forwarders without any other work."""
    seen = setting.rtis("latency", "--exchanges", setting.exchanges)
    return finding(
        "Latency of the RTI",
        "How long are a grant and a message on their way through the RTI?",
        [
            f"In µs over {setting.exchanges} exchanges, best of {setting.rounds} rounds, in turns.",
            "Forwarders: one sleeps until something comes, the other one looks all the time and takes a processor for "
            "it; compare ours with the quicker one.",
        ],
        spread_out(seen, {"median": 50, "99 %": 99}),
        OURS,
        ["median µs", "99 % µs"],
        figures=[
            figures.distributions(f"Latency: {row}", [one for one in seen if one.row == row])
            for row in dict.fromkeys(one.row for one in seen)
        ],
    )


def throughput(setting: Setting) -> Finding:
    """Measure the messages per second that an RTI forwards."""
    seen = setting.rtis("throughput", "--seconds", setting.seconds)
    return finding(
        "Throughput of the RTI",
        "How many messages does the RTI forward, and what does each cost?",
        [
            f"Pairs of federates, {setting.seconds} s each, best of {setting.rounds} rounds.",
            "A sender has up to 8 tags under way; each tag costs NET, TAG, LTC and NET beside its messages.",
            "Own memory is that part of the resident memory that is not of files, such as the program's.",
        ],
        seen,
        OURS,
        ["messages/s"],
        "federates, messages per tag",
        figures=[
            figures.dots("Messages per second through the RTI", figures.axis("messages/s", True), "messages/s", seen)
        ],
    )


def encryption(setting: Setting) -> Finding:
    """Measure our RTI with encrypted connections beside the same with plain ones."""
    words = ("--exchanges", setting.exchanges, "--seconds", setting.seconds)
    seen = setting.bench("encryption", "--lfz", setting.lfz, "--rounds", setting.rounds, *words)
    spread = spread_out(seen, {"median": 50, "99 %": 99})
    return finding(
        "Encryption",
        "What does encryption cost on Linux?",
        [
            f"Latency over {setting.exchanges} exchanges, throughput over {setting.seconds} s, in turns with plain "
            f"connections; best of {setting.rounds} rounds.",
            "All federates share one thread that encrypts and decrypts for them, too: the rate of messages falls with "
            "its load. The processor time is that of the RTI alone.",
        ],
        [*spread, *(one for one in seen if not one.samples)],
        ("lfz rti, encrypted",),
        ["median µs", "99 % µs", "messages/s", "CPU µs/message"],
        "latency, or federates and messages per tag",
    )


def growth(setting: Setting) -> Finding:
    """Measure the cost of a grant as the federation grows."""
    seen = setting.rtis("growth", "--seconds", setting.seconds)
    return finding(
        "Growth of the federation",
        "What does a grant take as the federation grows?",
        [
            f"{setting.seconds} s each, best of {setting.rounds} rounds.",
            "CPU: time of the RTI's process for all that leads to a grant, forwarded messages included.",
        ],
        seen,
        OURS,
        ["grants/s"],
        "graph, federates",
        figures=[figures.dots("What a grant costs", figures.axis("µs/grant", True), "CPU µs/grant", seen)],
    )


def large(setting: Setting) -> Finding:
    """One large federation from its start to its end."""
    return finding(
        "A large federation",
        "Does a federation of hundreds start, run and stop?",
        [f"A random federation of {setting.large} federates for {setting.large_seconds} s, once."],
        setting.rtis("large", "--federates", setting.large, "--seconds", setting.large_seconds),
        OURS,
        ["messages/s"],
    )


def initial(setting: Setting) -> Finding:
    """Measure the jitter of an RTI's answers in the exchanges of clock synchronization before the start."""
    seen = setting.rtis("initial")
    # All federations count together.
    keys = dict.fromkeys((one.row, one.who, one.unit) for one in seen)
    together = [
        Measured(*key, samples=tuple(chain(*(one.samples for one in seen if (one.row, one.who, one.unit) == key))))
        for key in keys
    ]
    spreads = [one for one in together if one.unit == "spread µs"]
    discarded = [
        Measured(one.row, one.who, "discarded", float(sum(it >= SPREAD_MAX_US for it in one.samples)))
        for one in spreads
    ]
    return finding(
        "Exchanges before the start",
        "How evenly does the RTI answer federates that all come at once?",
        [
            f"Ten exchanges; {10 * setting.rounds} federations each.",
            "The spread is the standard deviation of a federate's round trips; from "
            f"{SPREAD_MAX_US:.0f} µs on, a stock federate discards them. `discarded` counts these federates.",
        ],
        [*discarded, *spread_out(together, {"median": 50, "90 %": 90, "99 %": 99, "worst": 100})],
        OURS,
        ["median spread µs", "90 % spread µs"],
        figures=[
            figures.dots(
                "Spread of the round trips before the start",
                figures.axis("standard deviation in µs", True),
                "spread µs",
                [Measured(one.row, one.who, one.unit, it) for one in spreads for it in one.samples],
                [figures.mark("a stock federate discards from here on", "stock RTI", SPREAD_MAX_US)],
                caption="A dot for each federate, and the median.",
            )
        ],
    )
