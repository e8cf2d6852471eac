"""The terminal of a stream."""

from __future__ import annotations

import os

# That of typing takes longer to import than a stored answer to print.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TextIO


def width_of(stream: TextIO) -> int | None:
    """Return the number of columns of a stream's terminal; None if it is none that says it.

    The variable COLUMNS goes before what the terminal says.
    """
    if not stream.isatty():
        return None
    chosen = os.environ.get("COLUMNS", "")
    if chosen.isdecimal() and int(chosen):
        return int(chosen)
    try:
        return os.get_terminal_size(stream.fileno()).columns or None
    except OSError:
        return None
