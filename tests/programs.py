"""Programs that tests run or compare with, if they are installed."""

from __future__ import annotations

import shutil
import sysconfig

import pytest


def find(name: str) -> str | None:
    """The path of a program: that of the tests' environment, else that of the search path."""
    return shutil.which(name, path=sysconfig.get_path("scripts")) or shutil.which(name)


OMNIIDL = find("omniidl")

needs_omniidl = pytest.mark.skipif(
    OMNIIDL is None, reason="omniidl (jeteve-omniorb) is missing"
)


def omniidl() -> str:
    """The path of omniidl; the test that calls this is skipped if there is none."""
    if OMNIIDL is None:
        pytest.skip("omniidl (jeteve-omniorb) is missing")
    return OMNIIDL
