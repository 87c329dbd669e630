# SPDX-License-Identifier: Apache-2.0
"""Descriptions of programs by the compiler, stored and completed; and the sizes of images."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import pytest
from conftest import World

from lf_west import description
from lf_west.errors import LfError
from lf_west.memory import Memory, Segment, measure, read_segments
from lf_west.summary import Row, table


def described(world: World) -> description.Description:
    return description.load(world.description)


def test_a_description_survives_being_kept(world: World) -> None:
    first = described(world)
    first.save(world.top / "new" / "kept.json")
    assert description.load(world.top / "new" / "kept.json") == first
    options = ("--number_of_federates", "2", "--clock_sync", "off")
    assert first.rti == description.Rti("localhost", 15045, "Grid", 2, options)
    assert [item.is_image for item in first.participants] == [False, True]


def test_earlier_builds_are_not_forgotten(world: World) -> None:
    world.describe(a="host", b="native_sim/native/64", c="host")
    older = described(world)
    world.describe(a="native_sim/native/64")
    merged = described(world).merged_over(older)
    assert [(item.name, item.is_image) for item in merged.participants] == [("a", True), ("b", True), ("c", False)]


def test_federates_are_selected_in_the_programs_order(world: World) -> None:
    assert [item.name for item in described(world).select(["b", "a"])] == ["a", "b"]
    assert [item.name for item in described(world).select([])] == ["a", "b"]
    with pytest.raises(LfError, match=r"Grid has no federate x, y\.") as raised:
        described(world).select(["a", "x", "y"])
    assert "a, b" in str(raised.value)


def test_another_board_is_for_images_only(world: World) -> None:
    moved = described(world).with_board("qemu_cortex_m3")
    assert [item.board for item in moved.participants] == [None, "qemu_cortex_m3"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"program": None}, "None is not a text"),
        ({"rti": {}}, "'host' is missing"),
        ({"rti": 1}, "is no description"),
        ({"participants": [{"name": "a"}]}, "'crate' is missing"),
        ({"participants": [{"name": "a", "crate": "c", "platform": "zephyr"}]}, "'role' is missing"),
        (
            {"participants": [{"name": "a", "crate": "c", "platform": "zephyr", "role": "rti"}]},
            "'board' is missing",
        ),
        ({"participants": 3}, "is no description"),
    ],
)
def test_an_unknown_form_is_refused_with_the_reason(change: dict[str, object], words: str, world: World) -> None:
    source = {**json.loads(world.description.read_text()), **change}
    with pytest.raises(LfError, match=words):
        description.parse(source, "the test")


def test_text_that_is_no_json_is_refused() -> None:
    with pytest.raises(LfError, match="the output of lfz is no description of a program"):
        description.parse_text("error", "the output of lfz")
    with pytest.raises(LfError, match="nothing has been generated yet"):
        description.load(Path("/nowhere/federation.json"))


def elf_32(segments: list[tuple[int, int, int, int]]) -> bytes:
    """An ELF file with nothing but segments: (type, address, size in the file, size in memory)."""
    header = (
        b"\x7fELF\x01\x01".ljust(28, b"\0") + struct.pack("<I", 52) + bytes(10) + struct.pack("<HH", 32, len(segments))
    )
    rows = (struct.pack("<8I", kind, 0, address, 0, size, memory, 0, 4) for kind, address, size, memory in segments)
    return header.ljust(52, b"\0") + b"".join(rows)


def test_flash_and_ram_are_read_from_the_image(tmp_path: Path) -> None:
    folder = tmp_path / "zephyr"
    folder.mkdir()
    assert measure(tmp_path) is None
    segments = [(1, 0, 1000, 1000), (1, 0x2000_0000, 24, 24), (1, 0x2000_0018, 0, 2000), (4, 0, 5, 5)]
    (folder / "zephyr.elf").write_bytes(elf_32(segments))
    (folder / ".config").write_text("CONFIG_X=y\nCONFIG_SRAM_SIZE=64\nCONFIG_SRAM_BASE_ADDRESS=0x20000000\n")
    assert measure(tmp_path) == Memory(flash=1024, ram=2024)


def test_segments_of_64_bit_images_are_read() -> None:
    header = b"\x7fELF\x02\x01".ljust(32, b"\0") + struct.pack("<Q", 64) + bytes(14) + struct.pack("<HH", 56, 1)
    row = struct.pack("<2I6Q", 1, 5, 0, 0x1000, 0, 10, 20, 4)
    assert read_segments(header.ljust(64, b"\0") + row) == [Segment(0x1000, 10, 20)]


@pytest.mark.parametrize("image", [b"", b"#!/bin/sh\n", b"\x7fELF\x01\x02"])
def test_a_file_that_is_no_image_is_refused(image: bytes) -> None:
    with pytest.raises(ValueError, match="no ELF file"):
        read_segments(image)


def test_the_summary_is_a_table() -> None:
    rows = [Row("a", "host", None, Path("/x/a")), Row("longer", "qemu_cortex_m3", Memory(2048, 512), None)]
    assert table(rows).splitlines() == [
        "federate  board           flash    RAM      image",
        "a         host            –        –        /x/a",
        "longer    qemu_cortex_m3  2.0 KiB  0.5 KiB  –",
    ]
