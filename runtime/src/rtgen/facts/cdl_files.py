"""File names of TECS CDL."""

from __future__ import annotations

from typing import Final

CDL_SUFFIXES: Final = (".cdl", ".cde")
"""Suffixes of files in CDL, in lower case; `.cde`: those of the editor tecscde."""
