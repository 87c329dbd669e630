# SPDX-License-Identifier: Apache-2.0
"""Checks that each image has a probe, and that no two images share one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west.errors import LfError

# Where Linux lists what is connected by USB.
USB_DEVICES = Path("/sys/bus/usb/devices")
# Runners whose probes are named by their USB serial number. That of pyOCD may be a part of it.
_BY_SERIAL = ("jlink", "linkserver", "nrfjprog", "nrfutil", "openocd", "pyocd")


@dataclass(frozen=True)
class Target:
    """An image and the probe of its board."""

    name: str
    # None as long as it is not known, or when there is none.
    runner: str | None
    probe: str | None

    @property
    def _serial(self) -> str:
        """The probe as tools compare it: without regard to case and leading zeros."""
        return (self.probe or "").lower().lstrip("0")

    def is_vague(self) -> bool:
        """Return whether the probe's name fits several probes by its form."""
        return "*" in (self.probe or "") or (self.probe or "").startswith("#")

    def may_be(self, other: Target) -> bool:
        """Return whether the board of this image may be taken for that of the other."""
        if self.runner == "pyocd" and (self.probe or "").lower() in (other.probe or "").lower():
            return True
        return self._serial == other._serial

    def fits(self, serials: Sequence[str]) -> list[str] | None:
        """Return the connected devices that match the probe's name; None if that is unknown here."""
        # With a colon or a slash it is an address or a file.
        if self.runner not in _BY_SERIAL or not (self.probe or "").isalnum():
            return None
        exact = [serial for serial in serials if serial.lower().lstrip("0") == self._serial]
        if exact or self.runner != "pyocd":
            return exact
        return [serial for serial in serials if (self.probe or "").lower() in serial.lower()]


def check(targets: Sequence[Target]) -> None:
    """Refuse images without a probe, and probes that may be taken for each other."""
    missing = [target.name for target in targets if not target.probe]
    if missing:
        raise LfError(
            f"no probe is known for {', '.join(missing)}, so it is not known which board is meant.",
            "Name the probe of each board in the deployment file:",
            *(f"  {name}: {{ platform: BOARD, …, runner: pyocd, probe: SERIAL_NUMBER }}" for name in missing),
            *_advice(),
        )
    vague = [target for target in targets if target.is_vague()]
    if vague:
        raise LfError(
            f"the probe {vague[0].probe} of {vague[0].name} may be any of several probes.",
            "Name the serial number of the board's probe in the deployment file.",
            *_advice(),
        )
    for one, other in itertools.permutations(targets, 2):
        if one.may_be(other):
            same = one.probe == other.probe
            raise LfError(
                f"{one.name} and {other.name} have the same probe {one.probe}, but each needs a board of its own."
                if same
                else f"the probe {one.probe} of {one.name} may be taken for {other.probe} of {other.name}.",
                "Name the whole serial number of each board's probe in the deployment file.",
                *_advice(),
            )


def check_connected(targets: Sequence[Target], by_hand: Callable[[Target], str]) -> None:
    """Refuse probes that are not there, or that several devices may be, before the first board is flashed."""
    serials = connected()
    if serials is None:
        return
    for target in targets:
        found = target.fits(serials)
        if found is not None and not found:
            raise LfError(
                f"the probe {target.probe} of {target.name} is not connected to this computer: no USB device has this "
                "serial number.",
                "Connect the board, switch it on, and look at its USB cable.",
                *_advice(),
                f"Flash it by hand, if you know better: {by_hand(target)}",
            )
        if found is not None and len(found) > 1:
            raise LfError(
                f"the probe {target.probe} of {target.name} may be any of {len(found)} USB devices: "
                f"{', '.join(found)}.",
                "Name the whole serial number, or disconnect the other boards.",
                f"Flash it by hand, if you know better: {by_hand(target)}",
            )


def connected(folder: Path | None = None) -> list[str] | None:
    """The serial numbers of all USB devices; None where the system does not list them."""
    try:
        devices = sorted((folder or USB_DEVICES).iterdir())
    except OSError:
        return None
    serials = []
    for device in devices:
        # The computer's own USB controllers are named by their place.
        if device.name.startswith("usb"):
            continue
        try:
            serials.append((device / "serial").read_text(encoding="utf-8").strip())
        except (OSError, UnicodeDecodeError):
            continue
    return serials


def _advice() -> list[str]:
    serials = connected()
    seen = f"These serial numbers are connected by USB: {', '.join(serials)}" if serials else None
    return [*([seen] if seen else []), "List the probes with the runner's own tool, such as `pyocd list`."]
