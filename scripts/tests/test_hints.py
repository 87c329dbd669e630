# SPDX-License-Identifier: Apache-2.0
"""Images that are configured in a way that cannot work, or works badly, name the symbol of Kconfig to change."""

from __future__ import annotations

import pytest
from conftest import BUILD
from test_zephyr import COMPUTER_AND_BOARD, PROGRAMS, board, lf, rti

pytestmark = pytest.mark.zephyr


@pytest.mark.parametrize(
    ("program", "options", "of_the_rti", "of_the_image", "words"),
    [
        ("DescriptorTaken", (), ["-n", "1"], [], "other code of the image has them: raise CONFIG_ZVFS_EVENTFD_MAX\n"),
        (
            "Drifting",
            (),
            ["-n", "1", "-c", "on", "period", "5000000"],
            # A fifth is more than can be corrected.
            ["-rt-drift=0.2"],
            "check the frequency that it is configured with (CONFIG_SYS_CLOCK_HW_CYCLES_PER_SEC)\n",
        ),
        (
            "Squares",
            COMPUTER_AND_BOARD,
            ["-n", "2", "-a"],
            # The default of an image.
            ["-lf-federation-id=Unidentified Federation"],
            "others can guess this one: choose another with --id, or CONFIG_LF_FEDERATION_ID\n",
        ),
    ],
)
def test_an_image_names_the_symbol_to_change(
    program: str, options: tuple[str, ...], of_the_rti: list[str], of_the_image: list[str], words: str
) -> None:
    lf("lf-fed-build", PROGRAMS / f"{program}.lf", *options)
    image = BUILD / f"zephyr/{program}/board/zephyr/zephyr.exe"
    with rti("-i", "hints", *of_the_rti) as (_, port), board(image, "hints", port, *of_the_image) as process:
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            lines.append(line)
            if words in line:
                return
        raise AssertionError("".join(lines))
