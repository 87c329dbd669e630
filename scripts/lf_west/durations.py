# SPDX-License-Identifier: Apache-2.0
"""Times on the command line, with LF's units, as `lfz` reads them."""

from __future__ import annotations

import argparse
import math
import re

_UNITS = {
    ("ns", "nsec", "nsecs"): 1e-9,
    ("us", "usec", "usecs"): 1e-6,
    ("ms", "msec", "msecs"): 1e-3,
    ("", "s", "sec", "secs", "second", "seconds"): 1.0,
    ("min", "mins", "minute", "minutes"): 60.0,
    ("h", "hour", "hours"): 3600.0,
    ("d", "day", "days"): 86_400.0,
    ("wk", "week", "weeks"): 7 * 86_400.0,
}
_TIME = re.compile(r"\s*([0-9]+(?:\.[0-9]+)?)\s*([a-z]*)\s*", re.ASCII)
# The run's clock counts in 64 bits.
_SECONDS_MAX = 292 * 365 * 86_400.0


def seconds(text: str) -> float:
    """Read `30`, `30s` or `1.5 min`; an `ArgumentTypeError` says what is wrong."""
    match = _TIME.fullmatch(text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no time; write it like 30, 30s or 1.5min")
    factor = next((factor for names, factor in _UNITS.items() if match[2] in names), None)
    if factor is None:
        raise argparse.ArgumentTypeError(f"{match[2]!r} is no unit of time; try ns, us, ms, s, min, h, d or wk")
    value = float(match[1]) * factor
    if not math.isfinite(value) or value > _SECONDS_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is longer than 292 years")
    return value
