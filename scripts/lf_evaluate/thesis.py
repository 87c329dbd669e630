# SPDX-License-Identifier: Apache-2.0
"""The measurements of the thesis, as far as it has numbers."""

from __future__ import annotations

from typing import Any

from lf_evaluate import figures
from lf_evaluate.measured import Measured

# Drift after the exchanges before the start, in µs/s (section 6.1).
DRIFT = 26.0
# The delay of messages in µs, about (section 6.2.1).
DELAYS = {"centralized": 6000.0, "decentralized": 4000.0}
# Messages per second in each of ten runs (table 6.1).
RATES = {
    "centralized": [604.76, 619.56, 614.00, 616.52, 599.82, 587.96, 581.17, 674.53, 628.42, 589.79],
    "decentralized": [583.43, 592.86, 585.22, 589.41, 601.12, 583.03, 588.81, 590.12, 588.02, 586.82],
}
# Reaction times of units B and C of the smart grid in ms (tables 6.2 to 6.4).
REACTIONS = {
    "table 6.2": (
        [25.67, 25.74, 25.68, 25.90, 25.55, 25.83, 25.55, 25.84, 25.54, 25.98],
        [25.66, 25.68, 25.79, 25.69, 25.68, 25.89, 25.70, 25.70, 26.06, 25.56],
    ),
    "table 6.3": (
        [18.14, 18.72, 18.20, 148.65, 18.18, 18.21, 17.94, 17.93, 150.10, 149.72],
        [150.25, 149.95, 150.08, 150.01, 149.86, 149.91, 149.82, 149.89, 149.83, 150.16],
    ),
    "table 6.4": (
        [13.25, 13.17, 12.99, 14.75, 13.02, 13.32, 14.27, 13.06, 13.74, 13.26],
        [14.18, 16.06, 13.92, 13.35, 14.43, 13.70, 15.34, 12.77, 13.11, 16.32],
    ),
}
# The least delay of the smart grid's connections that held in ten runs, in ms (table 6.2).
SMALLEST_AFTER = 25.0


def rates(row: str, coordination: str) -> list[Measured]:
    """Its messages per second."""
    return [Measured(row, "thesis", "messages/s", rate) for rate in RATES[coordination]]


def delay_marks() -> list[dict[str, Any]]:
    """Return the marks of its delays, in µs."""
    return [figures.mark(f"thesis, {how}: {delay / 1000:g} ms", "thesis", delay) for how, delay in DELAYS.items()]
