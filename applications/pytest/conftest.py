# SPDX-License-Identifier: Apache-2.0
"""The fixtures of the applications' tests under twister.

Twister builds an image per scenario and names the build folders; the federation is run from them.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture
def run(request: pytest.FixtureRequest, required_build_dirs: list[str]) -> Callable[..., str]:
    """Runs the federation of a program, of which twister has built the images, and gives what was printed. Federates
    on this computer need the option --deployment."""

    def run(file: str, *options: str) -> str:
        images = [request.config.getoption("--build-dir"), *required_build_dirs]
        limit_s = request.config.getoption("--base-timeout")
        command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-run"]
        command += [str(REPOSITORY / "applications" / file), "--timeout", str(limit_s), *options]
        command += ["--images", *images]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        print(result.stdout)
        assert result.returncode == 0
        return result.stdout

    return run
