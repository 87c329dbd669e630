# SPDX-License-Identifier: Apache-2.0
"""Rustc's messages about the bodies of a program that is built as an image, from rustc to the terminal."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import BUILD

from lf_west.workspace import REPOSITORY

pytestmark = pytest.mark.zephyr


MISTAKE = """\
target Rust { timeout: 1 msec }
reactor Silent {
}
reactor Unit {
  input value: u32
  silent = new Silent()
  reaction(startup) {=
    @
  =}
  reaction(value) {= =} deadline(1 sec) {= info!("{:?}", ctx.get(value)); =}
}
federated reactor {
  unit = new Unit()
}
"""


def build_with(body: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Build an image whose first reaction has this body."""
    file = folder / "Mistake.lf"
    file.write_text(MISTAKE.replace("@", body))
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-build", str(file)]
    board = ["-w", "-b native_sim/native/64", "--build-dir", str(BUILD)]
    return subprocess.run([*command, *board], capture_output=True, text=True, check=False)


def codes(messages: Path) -> list[str]:
    """Return the codes of rustc's messages about the generated crate, scaffolding included."""
    items = map(json.loads, messages.read_text().splitlines())
    own = [item["message"] for item in items if str(BUILD) in item.get("manifest_path", "") and "message" in item]
    return [message["code"]["code"] for message in own if message["code"] is not None]


def test_errors_of_rustc_in_a_body_name_the_lf_file(tmp_path: Path) -> None:
    file = tmp_path / "Mistake.lf"
    result = build_with('let wrong: u8 = "text";', tmp_path)
    assert result.returncode != 0
    assert f"{file}:8:21: error[E0308]: mismatched types\n" in result.stderr
    assert '8 |     let wrong: u8 = "text";\n' in result.stderr
    assert "expected `u8`, found `&str`" in result.stderr
    assert "---- end of" not in result.stderr
    assert f"Read the whole log: {BUILD}/zephyr/Mistake/unit.log" in result.stderr
    # A warning is shown again when nothing has to be compiled; the scaffolding around the bodies causes none.
    for _ in range(2):
        result = build_with("let forgotten = 1;", tmp_path)
        assert result.returncode == 0, result.stdout + result.stderr
        assert f"{file}:8:9: warning[unused_variables]: unused variable: `forgotten`\n" in result.stderr
        assert codes(BUILD / "zephyr/Mistake/unit.cargo.json") == ["unused_variables"]
