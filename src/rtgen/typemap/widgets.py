"""Widgets of parameters (`__widget__`): the words that tools know, and what each needs."""

from __future__ import annotations

import re

_SLIDER = re.compile(r"slider\.(\d+\.?\d*|\.\d+)")
_OF_RANGES = ("slider", "spin")
_OF_VALUES = ("radio", "checkbox", "ordered_list", "orderd_list")


def is_widget(text: str) -> bool:
    """Whether it is a widget with its step, if it has one."""
    kind = text.partition(".")[0]
    if kind == "slider":
        return bool(_SLIDER.fullmatch(text)) and float(text[len("slider.") :]) > 0
    if kind in ("text", "spin"):
        return text in (kind, f"{kind}.")
    return text == "" or text in _OF_VALUES


def needs_range(text: str) -> bool:
    """Whether the widget shows a value between two bounds."""
    return text.partition(".")[0] in _OF_RANGES


def needs_values(text: str) -> bool:
    """Whether the widget offers an enumeration of values."""
    return text in _OF_VALUES
