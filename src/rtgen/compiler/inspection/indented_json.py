"""Fast indented JSON: the standard library uses its slow Python encoder when it indents."""

from __future__ import annotations

import json
from typing import Any

import msgspec

_LONE_SURROGATES = "surrogatepass"


def dumps(value: Any) -> str:
    """Return `json.dumps(value, indent=2, ensure_ascii=False)`; numbers are finite."""
    text = json.dumps(value, ensure_ascii=False, check_circular=False)
    flat = text.encode("utf-8", _LONE_SURROGATES)
    return msgspec.json.format(flat, indent=2).decode("utf-8", _LONE_SURROGATES)
