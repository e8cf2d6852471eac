"""Texts of inputs without what steers a terminal."""

from __future__ import annotations

import re

_STEERING = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff\ufffe\uffff]"
)
"""Control characters, directions and ends of lines of Unicode, and what no encoding has."""


def printable(text: str, keep: str = "") -> str:
    """The text with U+FFFD in place of control characters, but for those to `keep`.

    Directional marks and lone surrogates count as control characters, since a reader of the text
    would see something else than what is there.
    """
    if text.isprintable():
        return text
    return _STEERING.sub(
        lambda m: m[0] if m[0] in keep else "\N{REPLACEMENT CHARACTER}", text
    )
