"""Distinguishes stack frames of the user from those of rtgen, Python and installed packages."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import FrameType

import rtgen

_RTGEN = tuple(str(Path(folder).resolve()) + os.sep for folder in rtgen.__path__)
_DEBUGGER = (f"{os.sep}pdb.py", f"{os.sep}bdb.py")


@cache
def _installed() -> tuple[str, ...]:
    import sysconfig

    names = "stdlib", "platstdlib", "purelib"
    return tuple({sysconfig.get_path(name) + os.sep for name in names})


def shown(file: str) -> str:
    """Return the file as shown in messages: relative to the working folder if it is below."""
    folder = f"{Path.cwd()}{os.sep}"
    return file.removeprefix(folder).replace(os.sep, "/")


def is_rtgens(file: str) -> bool:
    """Return whether a file belongs to rtgen."""
    return file.startswith(_RTGEN)


def is_users(file: str) -> bool:
    """Return whether a file belongs to the user."""
    return not file.startswith((*_RTGEN, "<", *_installed()))


def is_debugger(frame: FrameType) -> bool:
    """Return whether a frame belongs to the debugger."""
    return frame.f_code.co_filename.endswith(_DEBUGGER)


def users_frame(frames: Sequence[FrameType]) -> FrameType:
    """Return the first frame of the user; else the first outside rtgen; else the first."""
    for is_candidate in (is_users, lambda file: not is_rtgens(file)):
        for frame in frames:
            if is_candidate(frame.f_code.co_filename):
                return frame
    return frames[0]
