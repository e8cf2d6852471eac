"""Distinguishes stack frames of the user from those of rtgen, Python and installed packages."""

from __future__ import annotations

import importlib
import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from traceback import FrameSummary
from types import FrameType

import rtgen

_RTGEN = tuple(str(Path(folder).resolve()) + os.sep for folder in rtgen.__path__)
IMPORTING = ("<", str(Path(importlib.__file__).parent))
"""File names of the import system, at which tracebacks of imports begin."""
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


def own_frames(frames: Sequence[FrameSummary]) -> list[FrameSummary]:
    """Return the frames in the user's own files; else those of other packages; never rtgen's."""
    for is_candidate in (
        is_users,
        lambda file: not (is_rtgens(file) or file.startswith(IMPORTING)),
    ):
        if own := [frame for frame in frames if is_candidate(frame.filename)]:
            return own
    return []


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
