# SPDX-License-Identifier: Apache-2.0
"""Flash and RAM of images for a small board, and whose they are."""

from __future__ import annotations

import os
import re
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from lf_evaluate import figures
from lf_evaluate.results import Cell, Finding, Table, finding, number
from lf_evaluate.setting import PROGRAMS, Setting, Word, application, build_folder, deployment, execute, variant
from lf_west.errors import LfError
from lf_west.memory import Memory, measure

BOARD = "qemu_cortex_m3"
# Federates of the program whose RTI is measured alone.
MANY = 8
# Crates whose code is told apart, and their columns; then come other crates, and what is C.
CRATES = {
    "lf_model": "model",
    "lf_wire": "wire",
    "lf_coordination": "coordination",
    "lf_runtime": "runtime",
    "lf_embedded": "embedded",
    "lf_zephyr": "zephyr",
    "core": "core",
}
PARTS = (*CRATES.values(), "other crates", "C")
# Sections of the project's own, by what they begin with.
_KINDS = {"text": "text", "rodata": "rodata", "data": "data", "bss": "bss", "noinit": "bss", "COMMON": "bss"}
# A section of a linker's map: its name, its address, its bytes, the file that it is from.
_SECTION = re.compile(r"^ (\.\S+|COMMON)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S.*)$", re.MULTILINE)
_OURS = ("librustapp.a(", "app/libapp.a(", "modules/lf-zephyr-rs/")


@dataclass(frozen=True)
class Image:
    """The sizes of one image, in bytes."""

    name: str
    memory: Memory
    # The same image with an empty main().
    empty: Memory
    # This project's share of it: by text, rodata, data and bss, and its text by PARTS.
    share: Counter[str]
    code: Counter[str]
    # The stacks of the main thread and of the RTI.
    stacks: int


def sizes(setting: Setting) -> Finding:
    """Measures images, the same without a federate, and what of each is this project's."""
    grid = application("smart_grid/src/SmartGrid.lf")
    sender = deployment("sender.yaml", "host", dict.fromkeys(("sender", "receiver"), BOARD))
    many, alone = _many()
    joint = application("smart_grid/deployment/topology3.yaml")
    chosen = [
        ("message test's sender", application("message_test/src/MessageTest.lf"), sender, "sender"),
        ("smart grid's unit B", grid, joint, "b"),
        ("joint RTI and unit A, 4 federates", grid, joint, "a"),
        (f"RTI alone, {MANY} federates", many, alone, "rti"),
        ("message test's receiver", application("message_test/src/MessageTest.lf"), sender, "receiver"),
        *(
            (f"decentralized {participant}, clock-sync: {clock_sync}", _decentralized(clock_sync), sender, participant)
            for clock_sync in ("init", "off", "on")
            for participant in ("sender", "receiver")
        ),
    ]
    images = []
    for name, file, places, participant in chosen[:1] if setting.quick else chosen:
        empty = None
        for texts in (True,) if setting.quick else (True, False):
            folder = _build(setting, file, places, participant, texts)
            empty = empty or _build_empty(folder)
            images.append(image_in(folder, name if texts else f"{name}, without texts", empty))
    return of_images(images)


def image_in(folder: Path, name: str, empty: Memory) -> Image:
    """Read the sizes of the image in a build folder."""
    linked = (folder / "zephyr/zephyr.map").read_text(encoding="utf-8", errors="replace")
    config = dict(
        line.split("=", 1) for line in (folder / "zephyr/.config").read_text().splitlines() if line.startswith("CONFIG")
    )
    share, code = shares(linked)
    rti_stack = _rti_stack(config)
    # The RTI's stack is in the application's own memory, and is told apart from it here.
    share["bss"] = max(0, share["bss"] - rti_stack)
    return Image(name, _measure(folder), empty, share, code, int(config["CONFIG_MAIN_STACK_SIZE"]) + rti_stack)


def _rti_stack(config: dict[str, str]) -> int:
    """An RTI beside a federate has a stack of its own; alone it runs on the main thread."""
    is_joint = config.get("CONFIG_LF_RTI") == "y" and config.get("CONFIG_LF_FEDERATE") == "y"
    return int(config["CONFIG_LF_RTI_STACK_SIZE"]) if is_joint else 0


def shares(linked: str) -> tuple[Counter[str], Counter[str]]:
    """Read a linker's map: for the Rust library, the application and this repository's Zephyr module, the bytes of
    each kind of section, and those of the code by PARTS."""
    kinds: Counter[str] = Counter()
    code: Counter[str] = Counter()
    for section, address, size, file in _SECTION.findall(linked.partition("Linker script and memory map")[2]):
        # A section at 0 is not in the image.
        if int(address, 16) == 0 or not any(part in file for part in _OURS):
            continue
        kind = _KINDS.get(section.lstrip(".").split(".")[0])
        if kind is not None:
            kinds[kind] += int(size, 16)
        if kind == "text":
            part = CRATES.get(_crate_of(section), "other crates")
            code[part if "librustapp.a(" in file else "C"] += int(size, 16)
    return kinds, code


def _crate_of(symbol: str) -> str:
    """The first crate that a symbol names, and `core` only if there is no other.

    In symbols a crate's name stands after its length: Cs1a2B3c_13lf_coordination.
    """
    found = re.finditer(r"Cs[0-9A-Za-z]+_(\d+)", symbol)
    names = [symbol[match.end() : match.end() + int(match[1])] for match in found]
    return next((name for name in names if name != "core"), names[0] if names else "")


def of_images(images: list[Image]) -> Finding:
    """The tables and figures of these images."""
    whole, by_crate = [], []
    flash: dict[str, list[float]] = {}
    code: dict[str, list[float]] = {}
    for image in images:
        share, empty = image.share, image.empty
        ours = share["text"] + share["rodata"] + share["data"]
        bytes_of = {"flash": image.memory.flash, "RAM": image.memory.ram}
        bytes_of |= {"empty: flash": empty.flash, "empty: RAM": empty.ram}
        bytes_of |= {f".{kind}": share[kind] for kind in ("text", "rodata", "data", "bss")}
        bytes_of |= {"stacks": image.stacks, "our flash": ours, "our RAM": share["data"] + share["bss"] + image.stacks}
        whole.append([image.name, *map(_kib, bytes_of.values())])
        by_crate.append([image.name, *(_kib(image.code[part]) for part in PARTS)])
        # The rest, neither ours nor in the empty image, is the part of Zephyr that only the program calls.
        called = max(0, image.memory.flash - empty.flash - ours)
        parts = [empty.flash, called, share["text"], share["rodata"], share["data"]]
        flash[image.name] = [size / 1024 for size in parts]
        code[image.name] = [image.code[part] / 1024 for part in PARTS]
    names = ("Zephyr, empty main()", "Zephyr, called", "our code", "our constants", "our data")
    found = finding(
        f"Images for {BOARD}",
        "How large are images for a small board, and what of them is this project's?",
        [
            "In KiB: as they are, with an empty main() instead, and this project's share by the linker's map.",
            "The buffers of connections are in .bss; stacks are the main thread's and the RTI's.",
            "The project's .text by the crates that it is from; what is inlined counts where it is inlined.",
        ],
        figures=[
            figures.stacked("Flash", "All of an image; without texts, errors are codes.", "KiB", names, flash),
            figures.stacked("Our code by crates", "The .text of the image that is this project's.", "KiB", PARTS, code),
        ],
        limits=["The thesis does not tell sizes of its images."],
    )
    found["tables"] = [
        Table(title="The images in KiB", headings=["", *bytes_of], rows=whole),
        Table(title="The project's code by crates in KiB", headings=["", *PARTS], rows=by_crate),
    ]
    return found


def _kib(size: int) -> Cell:
    return number(size / 1024, digits=1)


def _decentralized(clock_sync: str) -> Path:
    """The message test from federate to federate, with this clock synchronization."""
    text = application("message_test/src/MessageTestDecentralized.lf").read_text(encoding="utf-8")
    text = text.replace("decentralized }", f"decentralized, clock-sync: {clock_sync} }}")
    text = text.replace('"MessageTest.lf"', f'"{application("message_test/src/MessageTest.lf")}"')
    return variant(f"MessageTest{clock_sync.title()}", text)


def _many() -> tuple[Path, Path]:
    """A program of many federates, and its deployment with the RTI as an image of its own."""
    names = [f"node{index}" for index in range(1, MANY + 1)]
    federates = [f"  {name} = new Node()" for name in names]
    connections = [f"  {one}.y -> {other}.x" for one, other in pairwise(names)]
    text = """target Rust
reactor Node {
  input x: u32
  output y: u32
  timer t(0, 1 sec)
  reaction(t, x) -> y {= ctx.set(y, 1); =}
}
federated reactor {
"""
    file = variant("Many", text + "\n".join([*federates, *connections, "}\n"]))
    return file, deployment("many.yaml", BOARD, dict.fromkeys(names, BOARD))


def _build(setting: Setting, file: Path, places: Path, participant: str, texts: bool) -> Path:
    """Builds one image; its build folder."""
    build = build_folder(file) / ("sizes" if texts else "sizes-codes") / participant
    codes = [] if texts else ["--", "-DCONFIG_LF_TEXTS=n", "-DCONFIG_LF_PANIC_TEXTS=n"]
    setting.west("lf-fed-build", file, build, "--deployment", places, "-f", participant, *codes)
    return build / "zephyr" / file.stem / participant


def _build_empty(folder: Path) -> Memory:
    """Builds the image of this folder with an empty main()."""
    cache = (folder / "CMakeCache.txt").read_text(encoding="utf-8")
    empty = folder.with_suffix(".empty")
    files = re.findall(r"^(EXTRA_CONF_FILE|EXTRA_DTC_OVERLAY_FILE)(?::\w+)?=(.*)$", cache, re.MULTILINE)
    words = [f"-D{name}={value}" for name, value in files]
    command: list[Word] = [
        "west",
        "build",
        "--board",
        BOARD,
        "--pristine",
        "always",
        "--build-dir",
        empty,
        PROGRAMS / "empty",
    ]
    execute([*command, "--", *words], errors=True, folder=os.environ["ZEPHYR_BASE"])
    return _measure(empty)


def _measure(folder: Path) -> Memory:
    memory = measure(folder)
    if memory is None:
        raise LfError(f"the sizes of the image in {folder} are not known")
    return memory
