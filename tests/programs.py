"""Installed programs that tests run or compare with."""

from __future__ import annotations

import shutil
import sysconfig

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
