"""The values that `[adapter.NAME] set` gives to members."""

from __future__ import annotations

from typing import TypeAlias

AdapterConstant: TypeAlias = bool | int | float | str | tuple[str, ...]
"""A truth value, a number, a text, or texts of a sequence."""
