"""Looks at the disk: what a run has asked of it, and whether the answers would be the same now.

A look is a letter for what is asked, followed by an absolute path. What the status of a file tells
decides first; only if that differs, content or names are compared. This module is quick to import.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

CONTENT = "c"
"""The octets of a file."""
NAMES = "n"
"""The names in a folder, and which of them are files, folders and links."""
KIND = "k"
"""Whether a path is a file, a folder, or nothing; links are followed."""
LINK = "l"
"""The same of a link itself."""

NOTHING = "-"
"""The status, and the digest, of what is missing or cannot be read."""
_MAX_BYTES = 64 * 1024 * 1024
_BYTECODE = "__pycache__"
_SECOND = 1_000_000_000
_TICK = 20_000_000
"""Nanoseconds by which the time of a change may be too early: kernels read a clock that ticks."""

_LOOKS: ContextVar[dict[str, str] | None] = ContextVar("looks", default=None)


def look(kind: str, path: str | os.PathLike[str]) -> None:
    """Note that the run depends on a path; `kind` is one of the letters."""
    looks = _LOOKS.get()
    if looks is not None:
        # Not normalized: `..` after a link is the folder of its target.
        name = kind + os.path.join(os.getcwd(), path)
        if name not in looks:
            looks[name] = status(name)


@contextmanager
def noted() -> Iterator[dict[str, str]]:
    """Within the block, the first status of each look is noted in the mapping."""
    looks: dict[str, str] = {}
    token = _LOOKS.set(looks)
    try:
        yield looks
    finally:
        _LOOKS.reset(token)


def status(name: str) -> str:
    """Return what the status of the path of a look tells of what is asked."""
    kind = name[0]
    try:
        found = os.lstat(name[1:]) if kind == LINK else os.stat(name[1:])
    except (OSError, ValueError):
        return NOTHING
    if kind in (KIND, LINK):
        return str(stat.S_IFMT(found.st_mode))
    if (kind == NAMES) is not stat.S_ISDIR(found.st_mode):
        return f"other {stat.S_IFMT(found.st_mode)}"
    return f"{found.st_size} {found.st_mtime_ns} {found.st_ctime_ns} {found.st_ino}"


def digest(name: str) -> str:
    """Return the SHA-256 of what is asked; NOTHING for what the status tells entirely."""
    from hashlib import sha256

    kind, path = name[0], name[1:]
    if kind in (KIND, LINK):
        return NOTHING
    try:
        if kind == NAMES:
            with os.scandir(path) as entries:
                names = sorted(
                    f"{each.name}\0{each.is_dir()} {each.is_symlink()}"
                    for each in entries
                    if each.name != _BYTECODE
                )
            return sha256(os.fsencode("\0".join(names))).hexdigest()
        if not stat.S_ISREG(os.stat(path).st_mode):
            return NOTHING  # A device is not even opened.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(number, "rb") as stream:
            if not stat.S_ISREG(os.fstat(number).st_mode):
                return NOTHING
            return sha256(stream.read(_MAX_BYTES)).hexdigest()
    except (OSError, ValueError):
        return NOTHING


def is_settled(before: str, began: int) -> bool:
    """Return whether a status is older than the time `began` [ns since 1970] of a run.

    A later change has another time then, so that equal status means equal content. A time in whole
    seconds may be that of a file system with coarse times.
    """
    words = before.split()
    if len(words) != 4:
        return True
    times = [int(words[1])] if sys.platform == "win32" else map(int, words[1:3])
    return all(
        time + (_TICK if time % _SECOND else 2 * _SECOND) < began for time in times
    )


def is_same(name: str, now: str, before: str, content: str) -> bool:
    """Return whether a look whose status was another before has the digest of then."""
    return NOTHING not in (content, now, before) and digest(name) == content
