"""Errors of commands, with the codes of `docs/ui-protocol.md`."""

from __future__ import annotations

from typing import Final

BAD_MESSAGE: Final = "UIS0001"
NO_RIGHT: Final = "UIS0002"
UNKNOWN: Final = "UIS0003"
NO_FIT: Final = "UIS0004"
BAD_VALUE: Final = "UIS0005"
WRONG_STATE: Final = "UIS0006"
CALL_FAILED: Final = "UIS0007"
NOTHING_TO_UNDO: Final = "UIS0008"
IMPOSSIBLE: Final = "UIS0009"
FILE: Final = "UIS0010"
QUESTION: Final = "UIS0011"


class CommandError(Exception):
    """A command that was not executed; `hint` may be empty."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.hint = hint
