# SPDX-License-Identifier: Apache-2.0
"""The error of a command that cannot continue."""

from __future__ import annotations


class LfError(Exception):
    """A reason to end, what the user can try next, and the exit status."""

    def __init__(self, message: str, *tries: str, status: int = 1) -> None:
        """Keep the parts; `tries` are shown as a list below the message."""
        super().__init__(message)
        self.message = message
        self.tries = tries
        self.status = status

    def __str__(self) -> str:
        """The whole text for the user."""
        if not self.tries:
            return self.message
        return "\n".join([self.message, "Things to try:", *(f"  - {text}" for text in self.tries)])
