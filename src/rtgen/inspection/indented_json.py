"""JSON with an indentation of two, as the standard library writes it, which indents in Python."""

from __future__ import annotations

import json
from typing import Any

import msgspec

_LONE_SURROGATES = "surrogatepass"


def dumps(value: Any) -> str:
    """The text of `json.dumps(value, indent=2, ensure_ascii=False)`; its numbers are finite."""
    flat = json.dumps(value, ensure_ascii=False).encode("utf-8", _LONE_SURROGATES)
    return msgspec.json.format(flat, indent=2).decode("utf-8", _LONE_SURROGATES)
