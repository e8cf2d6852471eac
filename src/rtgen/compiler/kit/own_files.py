"""Files of rtgen itself: those that affect what it prints, and the user's folder of caches.

This module is quick to import: commands whose answer is stored need nothing else.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Collection, Iterable, Iterator

from rtgen.facts import version

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
_RUNTIME = os.path.dirname(os.path.dirname(os.path.abspath(version.__file__)))
_PARTS = ("compiler", "openrtm", "ros2", "templates")
_RUNTIME_PARTS = ("facts", "small_runtime")
RUNS = "runs"
"""The folder of results of runs, in that of caches."""
RENAME_JOURNAL = ".rtgen-rename.json"
"""The file beside rtgen.toml that a rename has until it is complete."""
_SKIPPED = ("__pycache__", "pages")
"""Folders without effect on the output; pages only explain it."""


def compiler_folders() -> list[str]:
    """Return the folders whose files affect what is generated."""
    packed = os.path.join(PACKAGE, "grammars")
    beside = os.path.join(PACKAGE, "..", "..", "grammars")
    return [
        *(os.path.join(PACKAGE, name) for name in _PARTS),
        *(os.path.join(_RUNTIME, name) for name in _RUNTIME_PARTS),
        packed if os.path.isdir(packed) else beside,
    ]


def stamp(folders: Iterable[str], skip: Collection[str] = _SKIPPED) -> str:
    """Return paths, sizes and times of the files below, quicker than a hash of their contents.

    A changed file has another time of change (on Windows of modification), whatever sets its times.
    """
    parts: list[str] = []
    for folder in folders:
        for entry in _files_below(folder, skip):
            parts.append(stamp_of(entry))
    return "\0".join(parts)


def stamp_of(file: os.DirEntry[str] | str) -> str:
    """Return path, size and times of a file."""
    found = os.stat(file) if isinstance(file, str) else file.stat()
    times = f"{found.st_mtime_ns} {found.st_ctime_ns}"
    return f"{os.fspath(file)}\0{found.st_size} {times}"


def _files_below(folder: str, skip: Collection[str]) -> Iterator[os.DirEntry[str]]:
    with os.scandir(folder) as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            if entry.is_dir(follow_symlinks=False):
                if entry.name not in skip:
                    yield from _files_below(entry.path, skip)
            elif entry.is_file():
                yield entry


def user_folder() -> str:
    """Return the user's folder of caches: `RTGEN_CACHE_DIR`, or the system's cache folder."""
    folder = os.environ.get("RTGEN_CACHE_DIR")
    if not folder and sys.platform == "linux":
        # As platformdirs, which takes a tenth of the time of a check of unchanged files.
        base = os.environ.get("XDG_CACHE_HOME", "")
        home = base if os.path.isabs(base) else os.path.expanduser("~/.cache")
        folder = os.path.join(home, "rtgen")
    elif not folder:
        from platformdirs import user_cache_dir

        folder = user_cache_dir("rtgen", appauthor=False)
    return os.path.join(os.getcwd(), folder)


def read_own(path: str, limit: int) -> bytes | None:
    """Return up to `limit` bytes of a file of the cache; None if it is missing or unreadable.

    None, too, if another user may have written the file, or may replace it.
    """
    try:
        folder = os.path.dirname(path)
        if not (
            is_own(folder) and is_own(path) and stat.S_ISREG(os.stat(path).st_mode)
        ):
            return None
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0)
        with open(os.open(path, flags | getattr(os, "O_NONBLOCK", 0)), "rb") as stream:
            if not _is_owned(os.fstat(stream.fileno())):  # exchanged meanwhile
                return None
            return stream.read(limit)
    except (OSError, ValueError):
        return None


def is_own(path: str, *, sole_writer: bool = True) -> bool:
    """Return whether only this user can write to a path, or set a link there. Raises OSError."""
    if sys.platform == "win32":  # user profiles are private
        return True
    is_ours = os.lstat(path).st_uid == os.geteuid()
    return is_ours and _is_owned(os.stat(path), sole_writer=sole_writer)


def _is_owned(status: os.stat_result, *, sole_writer: bool = True) -> bool:
    if sys.platform == "win32":
        return True
    shared = sole_writer and status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return status.st_uid == os.geteuid() and not shared
