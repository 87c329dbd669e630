# SPDX-License-Identifier: Apache-2.0
"""Flash and RAM of an image, from its ELF file and its configuration.

The linker prints the same numbers, but only when it links.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

_MAGIC_32_LITTLE = b"\x7fELF\x01\x01"
_MAGIC_64_LITTLE = b"\x7fELF\x02\x01"
_PT_LOAD = 1


@dataclass(frozen=True)
class Memory:
    """Sizes in bytes."""

    flash: int
    ram: int


@dataclass(frozen=True)
class Segment:
    """A part of an image that is loaded."""

    virtual_address: int
    file_size: int
    memory_size: int


def measure(image_folder: Path) -> Memory | None:
    """Measure the image in a build folder; None if its size is unknown, as for a program of this computer."""
    try:
        ram_start, ram_size = _ram(image_folder / "zephyr" / ".config")
        segments = read_segments((image_folder / "zephyr" / "zephyr.elf").read_bytes())
    except (OSError, ValueError, KeyError, struct.error):
        return None
    in_ram = [part for part in segments if ram_start <= part.virtual_address < ram_start + ram_size]
    if not in_ram:
        return None
    return Memory(
        flash=sum(part.file_size for part in segments),
        ram=max(part.virtual_address + part.memory_size for part in in_ram) - ram_start,
    )


def read_segments(image: bytes) -> list[Segment]:
    """The loaded segments of an ELF file; a ValueError when it is none."""
    if image.startswith(_MAGIC_32_LITTLE):
        (table,) = struct.unpack_from("<I", image, 28)
        size, count = struct.unpack_from("<HH", image, 42)
        # type, offset, virtual address, physical address, size in the file, size in memory, …
        rows = [struct.unpack_from("<6I", image, table + index * size) for index in range(count)]
        return [Segment(row[2], row[4], row[5]) for row in rows if row[0] == _PT_LOAD]
    if image.startswith(_MAGIC_64_LITTLE):
        (table,) = struct.unpack_from("<Q", image, 32)
        size, count = struct.unpack_from("<HH", image, 54)
        # type, flags, offset, virtual address, physical address, size in the file, size in memory, …
        rows = [struct.unpack_from("<2I5Q", image, table + index * size) for index in range(count)]
        return [Segment(row[3], row[5], row[6]) for row in rows if row[0] == _PT_LOAD]
    raise ValueError("no ELF file of a little-endian machine")


def _ram(config: Path) -> tuple[int, int]:
    """Read the address and the size of the RAM from the image's .config."""
    values = {}
    for line in config.read_text(encoding="utf-8").splitlines():
        name, equals, value = line.partition("=")
        if equals:
            values[name] = value
    return int(values["CONFIG_SRAM_BASE_ADDRESS"], 0), int(values["CONFIG_SRAM_SIZE"], 0) * 1024
