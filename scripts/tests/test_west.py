# SPDX-License-Identifier: Apache-2.0
"""The commands as west itself runs them, in a workspace whose manifest is this repository's."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import World

REPOSITORY = Path(__file__).resolve().parents[2]
MANIFEST = """
manifest:
  projects:
    - name: zephyr
      url: https://example.org/zephyr
  self:
    path: lf
    west-commands: scripts/west-commands.yml
"""


@pytest.fixture
def topdir(world: World) -> Path:
    """A workspace with this repository's commands, and without projects that would have to be fetched."""
    topdir = world.zephyr.parent
    (topdir / "lf").mkdir()
    (topdir / "lf/west.yml").write_text(MANIFEST)
    # West takes no commands from outside of the manifest repository, so a link would not do.
    ignored = shutil.ignore_patterns("tests", "__pycache__", ".*")
    shutil.copytree(REPOSITORY / "scripts", topdir / "lf/scripts", ignore=ignored)
    (topdir / ".west/config").write_text("[manifest]\npath = lf\nfile = west.yml\n[zephyr]\nbase = zephyr\n")
    # The place of the local configuration is west's own business here.
    world.monkeypatch.delenv("WEST_CONFIG_LOCAL")
    return topdir


def west(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "west", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_west_offers_the_commands(topdir: Path) -> None:
    result = west(topdir, "help")
    assert result.returncode == 0, result.stderr
    for name in ("lf-build:", "lf-fed-build:", "lf-fed-flash:", "lf-fed-run:", "lf-run:"):
        assert name in result.stdout


def test_west_builds_and_runs_from_any_folder(topdir: Path, world: World) -> None:
    world.touch("deployment.yaml")
    world.program("grid-a", "")
    world.monkeypatch.delenv("ZEPHYR_BASE")
    folder = topdir / "zephyr" / "samples"
    folder.mkdir()
    result = west(folder, "lf-fed-run", world.file, "--timeout", "10min", "--", "-DX=1")
    assert result.returncode == 0, result.stderr
    (call,) = world.calls("west")
    assert call[-1] == "-DX=1"
    assert "b: built in" in result.stdout


def test_west_passes_the_status_and_the_advice_on(topdir: Path, world: World) -> None:
    world.touch("deployment.yaml")
    world.set("STAND_IN_WEST_FAILS", "b")
    result = west(topdir, "lf-fed-build", world.file)
    assert result.returncode == 3
    assert "Things to try" in result.stderr


def test_wests_configuration_names_the_board(topdir: Path, world: World) -> None:
    with (topdir / ".west/config").open("a") as config:
        config.write("[build]\nboard = plank\n")
    world.describe(a="plank")
    result = west(topdir, "lf-fed-build", world.file)
    assert result.returncode == 0, result.stderr
    (call,) = world.calls("west")
    assert call[call.index("--board") + 1] == "plank"
