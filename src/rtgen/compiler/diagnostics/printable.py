"""Removes terminal control characters from texts of inputs."""

from __future__ import annotations

import re

_STEERING = (
    r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
    r"\ufeff\ufffe\uffff]"
)
"""Control and bidirectional characters, Unicode line ends, and lone surrogates."""


def printable(text: str, keep: str = "") -> str:
    """Replace control characters with U+FFFD, except those in `keep`.

    Directional marks and lone surrogates count as control characters, since they would change what
    a reader of the text sees.
    """
    if text.isprintable():
        return text
    return re.sub(
        _STEERING,
        lambda m: m[0] if m[0] in keep else "\N{REPLACEMENT CHARACTER}",
        text,
    )
