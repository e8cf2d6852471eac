"""The tokens of `rtgen ui --port N`, stored so that pages find a restarted server."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from pathlib import Path
from typing import Final

from rtgen.compiler.kit.own_files import user_folder
from rtgen.facts.files import write_atomically
from rtgen.ui.server import Tokens

MAX_AGE: Final = 24 * 3600.0
"""Lifetime of stored tokens since the last start [s]."""
_TOLERANCE: Final = 60.0
"""How far the clocks of file systems may be ahead [s]."""
_MAX_OCTETS: Final = 1024
_NEITHER_LINK_NOR_PIPE: Final = getattr(os, "O_NOFOLLOW", 0) | getattr(
    os, "O_NONBLOCK", 0
)


def tokens_of(port: int) -> Tokens:
    """Return the tokens of the last server at a port, else new ones; store them for the next one.

    A file that another user can read, or could have written, is ignored.
    """
    file = Path(user_folder()) / "ui" / f"{port}.tokens"
    tokens = _read(file) or Tokens()
    with contextlib.suppress(OSError):  # then they are only valid for this start
        _write(file, tokens)
    return tokens


def _read(file: Path) -> Tokens | None:
    try:
        number = os.open(file, os.O_RDONLY | _NEITHER_LINK_NOR_PIPE)
    except OSError:
        return None
    with os.fdopen(number, encoding="ascii", errors="replace") as stream:
        status = os.fstat(number)
        # A file from the future is of no known age: the clock has been set back since.
        is_recent = -_TOLERANCE < time.time() - status.st_mtime < MAX_AGE
        if not (is_recent and stat.S_ISREG(status.st_mode) and _is_private(status)):
            return None
        full, _, read_only = stream.read(_MAX_OCTETS).partition(" ")
    return Tokens(full, read_only) if full and read_only and full != read_only else None


def _is_private(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o077


def _write(file: Path, tokens: Tokens) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(
        file, f"{tokens.full} {tokens.read_only}".encode("ascii"), mode=0o600
    )
