"""Folders of results of earlier runs, each bounded in number and size of its files."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

from rtgen.compiler.kit.own_files import RUNS, is_own, user_folder
from rtgen.facts.files import write_atomically

MAX_BYTES = 64 * 1024 * 1024
"""Maximum size of all files."""
_MAX_FILES = 128
_NAME = r"[0-9a-f]{64}\.json|[0-9a-f]{8}\.answer"
_STORED = re.compile(rf"{_NAME}|\.({_NAME})\.\d+")


def folder() -> Path:
    """Return the user's folder of results and answers of commands."""
    return Path(user_folder()) / RUNS


def write(place: Path, name: str, data: bytes) -> None:
    """Write a file to a folder, unless that is read-only or another user's.

    A name is a hash and `.json`, or that of an answer: least recently used ones are removed.
    """
    with contextlib.suppress(OSError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not is_own(str(place), sole_writer=False):
            return
        place.chmod(0o700)
        write_atomically(place / name, data, mode=0o600)
        _trim(place)


def _trim(place: Path) -> None:
    """Remove the least recently used files, and leftovers of killed runs."""
    entries = []
    for file in place.iterdir():
        if not _STORED.fullmatch(file.name):
            continue
        with contextlib.suppress(FileNotFoundError):
            status = file.stat()
            entries.append((status.st_mtime_ns, status.st_size, file))
    size = 0
    for number, (_, bytes_, file) in enumerate(sorted(entries, reverse=True)):
        size += bytes_
        if number >= _MAX_FILES or size > MAX_BYTES:
            file.unlink(missing_ok=True)
