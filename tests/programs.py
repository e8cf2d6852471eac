"""Installed programs that tests run or compare with."""

from __future__ import annotations

import os
import shutil
import sysconfig
from pathlib import Path

import pytest


def find(name: str) -> str | None:
    """Return the path of a program in the tests' environment, else in the search path."""
    return shutil.which(name, path=sysconfig.get_path("scripts")) or shutil.which(name)


OMNIIDL = find("omniidl")

needs_omniidl = pytest.mark.skipif(
    OMNIIDL is None, reason="omniidl (jeteve-omniorb) is missing"
)


def omniidl() -> str:
    """Return the path of omniidl; without it the calling test is skipped."""
    if OMNIIDL is None:
        pytest.skip("omniidl (jeteve-omniorb) is missing")
    return OMNIIDL


TECSGEN = os.environ.get("RTGEN_TECSGEN") or shutil.which("tecsgen")
"""tecsgen 1.7, named by the environment or on the path."""

needs_tecsgen = pytest.mark.skipif(TECSGEN is None, reason="tecsgen is missing")


def tecs_board_tools() -> dict[str, str]:
    """Return the variables with which `make` builds a TECS board.

    Without one of the programs, or the library of tecsgen, the calling test is skipped.
    """
    needed = {"tecsgen": TECSGEN, "gcc": find("gcc"), "make": find("make")}
    missing = [name for name, path in needed.items() if path is None]
    beside = Path(TECSGEN or "").resolve().parent / "tecs"
    library = Path(os.environ.get("TECSPATH") or beside)
    if TECSGEN and not (library / "rpc" / "rpc.cdl").exists():
        missing.append("TECSPATH, the folder tecs of tecsgen,")
    if TECSGEN is None or missing:
        pytest.skip(f"{', '.join(missing)} missing")
    return {"TECSGEN": TECSGEN, "TECSPATH": str(library)}
