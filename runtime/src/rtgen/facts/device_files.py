"""File names of CANopen device descriptions (CiA 306, CiA 311)."""

from __future__ import annotations

from pathlib import PurePath
from typing import Final

TEXT_SUFFIXES: Final = (".eds", ".dcf")
"""Suffixes of descriptions in sections (CiA 306)."""
XML_SUFFIXES: Final = (".xdd", ".xdc")
"""Suffixes of descriptions in XML (CiA 311)."""
DEVICE_SUFFIXES: Final = (*TEXT_SUFFIXES, *XML_SUFFIXES)
"""Suffixes of all device descriptions, in lower case."""
_CONFIGURED: Final = (".dcf", ".xdc")


def is_device_file(path: PurePath) -> bool:
    """Return whether a file is a device description, by its name."""
    return path.suffix.lower() in DEVICE_SUFFIXES


def is_configured(path: PurePath) -> bool:
    """Return whether a description is of a configured device, by its name: a DCF or XDC."""
    return path.suffix.lower() in _CONFIGURED
