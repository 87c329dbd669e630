# SPDX-License-Identifier: Apache-2.0
"""Encrypted federations with images in them, with keys that `lfz keys new` has made for each run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import BUILD, LF
from test_private_networks import _allowed
from test_virtual_boards import _qemu, assert_all_ended_well
from test_zephyr import ALLOCATOR, LIMIT_S, PROGRAMS, SECURE, _arm, lf, symbols

from lf_west import compiler
from lf_west.workspace import REPOSITORY

__all__ = ["_allowed", "_arm", "_qemu"]

pytestmark = pytest.mark.zephyr

# The maximum size of an image of an RTI for eight encrypted federates on qemu_cortex_m3, with 256 and 64 KiB: its size
# and a little. A comment here has to justify more.
FLASH_MAX_KIB = 148.0
RAM_MAX_KIB = 63.75


def with_keys(file: Path) -> Path:
    """A copy of a program in a folder of its own, with new keys; the folder is always the same, so that an image that
    was built is only linked again."""
    folder = BUILD / "encrypted" / file.stem
    shutil.rmtree(folder, ignore_errors=True)
    copy = folder / "src" / file.name
    copy.parent.mkdir(parents=True)
    shutil.copy(file, copy)
    command = [str(compiler.find(None, os.environ).path), "keys", "new", str(copy)]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    return copy


def arguments(deployment: str, *options: str) -> tuple[str, ...]:
    return ("--deployment", str(PROGRAMS / deployment), "--timeout", str(LIMIT_S), *options)


def assert_is_secret(text: str, keys: Path) -> None:
    """The secrets of all participants are in files that only their user can read, and nobody prints them."""
    secrets = [*keys.glob("*.key"), *keys.glob("*.secret")]
    assert len(secrets) > 2
    for file in secrets:
        assert file.stat().st_mode & 0o077 == 0, file
        assert file.read_text().splitlines()[1] not in text


def test_an_rti_and_a_federate_in_images_encrypt_every_kind_of_connection() -> None:
    """On native_sim: messages by way of the RTI and past it, and the datagrams of clock synchronization."""
    file = with_keys(REPOSITORY / "tests/federations/programs/Encrypted.lf")
    output = lf("lf-fed-run", file, *arguments("encrypted_native_sim.yaml"), build=BUILD)
    assert re.search(r"^source +host ", output, re.MULTILINE), output
    assert re.search(r"^sink +\| the sum is 666, and directly came true$", output, re.MULTILINE), output
    # Rounds over UDP count at both ends, and no datagram and no connection was refused.
    for federate in ("source", "sink"):
        rounds = re.search(rf"^{federate} +\| .*clock synchronization: ([0-9]+) rounds over UDP", output, re.MULTILINE)
        assert rounds is not None and int(rounds[1]) > 0, output
    assert "not secure" not in output and "not authentic" not in output, output
    assert_is_secret(output, file.parents[1] / "keys/Encrypted")
    for image in ("rti", "sink"):
        assert any(map(SECURE.search, symbols(BUILD / "zephyr/Encrypted" / image)))


@pytest.mark.usefixtures("_allowed", "_arm", "_qemu")
def test_an_rti_of_eight_encrypted_federates_fits_a_small_board_and_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a source of entropy the board is refused by name, unless the configuration says that it is a test."""
    file = with_keys(PROGRAMS / "EncryptedChain.lf")
    build = BUILD / "boards"
    words = [sys.executable, str(LF), "lf-fed-build", str(file), "-f", "rti", "--build-dir", str(build)]
    words += ["--deployment", str(PROGRAMS / "encrypted_chain.yaml")]
    refused = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert refused.returncode != 0
    assert "encryption needs random numbers: this board has no driver for its entropy source" in refused.stdout

    settings = ("-c", str(PROGRAMS / "test_entropy.conf"))
    output = lf("lf-fed-run", file, *arguments("encrypted_chain.yaml", *settings), build=build)
    # 20 values, at 0, 10, … 190 ms, to which eight federates have added one each.
    assert re.search(r"^eight +\| the sum is 160$", output, re.MULTILINE), output
    assert_all_ended_well(output, "rti")
    assert "not secure" not in output, output
    sizes = re.search(r"^rti +qemu_cortex_m3 +([0-9.]+) KiB +([0-9.]+) KiB ", output, re.MULTILINE)
    assert sizes is not None, output
    with capsys.disabled():
        print(f"\nan encrypted RTI for eight on qemu_cortex_m3: {sizes[1]} KiB of flash, {sizes[2]} KiB of RAM")
    assert float(sizes[1]) <= FLASH_MAX_KIB
    assert float(sizes[2]) <= RAM_MAX_KIB
    linked = symbols(build / "zephyr/EncryptedChain/rti")
    assert any(map(SECURE.search, linked))
    assert [name for name in linked if ALLOCATOR.fullmatch(name)] == []
