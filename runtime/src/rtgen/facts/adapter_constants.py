"""Constants for members in `[adapter.NAME] set` of rtgen.toml."""

from __future__ import annotations

from typing import TypeAlias

AdapterConstant: TypeAlias = bool | int | float | str | tuple[str, ...]
"""A boolean, number, text, or a sequence of texts."""
