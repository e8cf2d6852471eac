"""The folder of IDL files that OpenRTM installs, found as by the generated `idlcompile.sh`."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from rtgen.compiler.kit.words import words

_MARK: Final = "BasicDataType.idl"
"""A file that the folder has."""
FILES: Final = frozenset(f"{stem}.idl" for stem in words("""
        CameraCommonInterface DataPort DataPort_OpenRTM ExtendedFsmService Manager
        ManipulatorCommonInterface_Common ManipulatorCommonInterface_DataTypes
        ManipulatorCommonInterface_Middle OpenRTM RTC SDOPackage SharedMemory
        """))
"""The files of OpenRTM-aist 2.1.0 that rtgen does not have."""
_TIMEOUT: Final = 5.0
"""Seconds that a script of OpenRTM may take."""
PLACES: Final = "RTM_IDL, rtm2-config, rtm-config, OpenRTM_aist, RTM_ROOT"
"""Where the folder is asked for, in order: environment, programs, the Python package."""


def installed_folder() -> Path | None:
    """Return OpenRTM's folder of IDL files; None if it is not installed."""
    names = ("RTM_IDL", "RTM_ROOT", "PATH")
    return _folder(*(os.environ.get(name, "") for name in names))


@cache
def _folder(rtm_idl: str, rtm_root: str, path: str) -> Path | None:
    for folder in _candidates(rtm_idl, rtm_root, path):
        if folder is not None and (folder / _MARK).is_file():
            return folder
    return None


def _candidates(rtm_idl: str, rtm_root: str, path: str) -> Iterator[Path | None]:
    yield Path(rtm_idl) if rtm_idl else None
    for program in ("rtm2-config", "rtm-config"):
        yield _said_by(shutil.which(program, path=path))
    yield _of_python()
    yield Path(rtm_root, "rtm", "idl") if rtm_root else None


def _said_by(program: str | None) -> Path | None:
    """Return the folder that a script of OpenRTM prints."""
    if program is None:
        return None
    try:
        done = subprocess.run(
            [program, "--rtm-idldir"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIMEOUT,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    lines = done.stdout.strip().splitlines()
    return Path(lines[0]) if done.returncode == 0 and len(lines) == 1 else None


def _of_python() -> Path | None:
    """Return the folder of OpenRTM-aist-Python, which is not imported."""
    try:
        spec = find_spec("OpenRTM_aist")
    except (ImportError, ValueError):
        return None
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).parent / "RTM_IDL"
