"""File names of IDL."""

from __future__ import annotations

from typing import Final

IDL_SUFFIXES: Final = (".idl", ".pidl")
"""Suffixes of files in IDL, in lower case; `.pidl`: the pseudo IDL of CORBA's own interfaces."""
