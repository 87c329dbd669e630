# SPDX-License-Identifier: Apache-2.0
"""The boards that QEMU plays: how an image is started on one, and how its end is known.

QEMU goes on when the program in it has ended, as a board does; so the program says its status on the console.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

PROGRAM = "qemu-system-arm"
ADVICE = "Install QEMU for Arm: apt install qemu-system-arm"
# The text of `end` in zephyr/src/fatal.c before the status, after the end of the program and after a fault.
STATUS_LINE = "lf: the program ended with status "


@dataclass(frozen=True)
class _Machine:
    name: str
    cpu: str
    # The Ethernet controller, as QEMU calls it.
    controller: str
    # The events that QEMU can trace of its pins.
    trace: tuple[str, ...] = ()


# By the board's name without its revision.
_MACHINES = {
    "qemu_cortex_m3": _Machine("lm3s6965evb", "cortex-m3", "stellaris", ("pl061_reset", "pl061_set_output")),
    "mps2/an385": _Machine("mps2-an385", "cortex-m3", "lan9118"),
}


def boards() -> Sequence[str]:
    """The boards that can be played."""
    return list(_MACHINES)


def is_installed() -> bool:
    """Return whether there is a QEMU that plays them."""
    return shutil.which(PROGRAM) is not None


def is_played(board: str) -> bool:
    """Return whether QEMU plays this board."""
    return _machine(board) is not None


def has_pins(board: str) -> bool:
    """Return whether QEMU can tell what the pins of this board do."""
    machine = _machine(board)
    return machine is not None and machine.trace != ()


def command(
    board: str, image: Path, interface: str | None = None, mac: str | None = None, trace: Path | None = None
) -> list[str]:
    """Start an image on a board whose Ethernet, if it is connected, is the other end of a TAP interface.

    What its pins do is traced into a file, by the clock of this computer.
    """
    machine = _machine(board)
    if machine is None:
        raise ValueError(f"QEMU does not play {board}")
    network = "none"
    if interface is not None:
        network = f"tap,ifname={interface},script=no,downscript=no,model={machine.controller}"
        # Some controllers tell the driver their address; others are told theirs by the devicetree.
        network += f",mac={mac}" if mac is not None else ""
    words = [PROGRAM, "-machine", machine.name, "-cpu", machine.cpu, "-nic", network]
    if trace is not None:
        events = [word for event in machine.trace for word in ("-trace", event)]
        words += [*events, "-msg", "timestamp=on", "-D", str(trace)]
    return [*words, "-display", "none", "-monitor", "none", "-serial", "stdio", "-kernel", str(image)]


def _machine(board: str) -> _Machine | None:
    name, _, rest = board.partition("@")
    _, slash, qualifiers = rest.partition("/")
    # qemu_cortex_m3/ti_lm3s6965 is the full name of qemu_cortex_m3.
    return _MACHINES.get((name + slash + qualifiers).removesuffix("/ti_lm3s6965"))
