"""Names made from those in device descriptions."""

from __future__ import annotations

import re
from unicodedata import combining, normalize

_PARTS = re.compile(r"[A-Za-z0-9]+")


def module_name(stem: str) -> str:
    """The IDL module of a device: Pascal case of its file's stem."""
    parts = _PARTS.findall(_ascii(stem))
    name = "".join(part[0].upper() + part[1:] for part in parts)
    return f"Device{name}" if not name or name[0].isdigit() else name


def _ascii(text: str) -> str:
    """The text with letters without their marks; it keeps what has no like in ASCII."""
    return "".join(c for c in normalize("NFKD", text) if not combining(c))
