"""Widgets of parameters (`__widget__`): names known to tools, and their requirements."""

from __future__ import annotations

import re

_STEP = re.compile(r"\d+\.?\d*|\.\d+")
_OF_RANGES = ("slider", "spin")
_OF_VALUES = ("radio", "checkbox", "ordered_list", "orderd_list")


def is_widget(text: str) -> bool:
    """Return whether a text is a known widget, with its step if it has one."""
    kind, _, step = text.partition(".")
    if kind in _OF_RANGES and step:
        return bool(_STEP.fullmatch(step)) and float(step) > 0
    if kind in ("text", "spin"):
        return text in (kind, f"{kind}.")
    return text == "" or text in _OF_VALUES


def needs_range(text: str) -> bool:
    """Return whether the widget requires bounds."""
    return text.partition(".")[0] in _OF_RANGES


def needs_values(text: str) -> bool:
    """Return whether the widget requires an enumeration of values."""
    return text in _OF_VALUES
