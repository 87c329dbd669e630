# SPDX-License-Identifier: Apache-2.0
"""The message test, with its sender and its receiver on boards."""

from __future__ import annotations

import re
from collections.abc import Callable


def test_all_messages_arrive_in_order(run: Callable[[str], str]) -> None:
    output = run("message_test/src/MessageTest.lf")
    assert re.search(r"^receiver +\| received 3000 of 3000 messages in order, ", output, re.MULTILINE)
