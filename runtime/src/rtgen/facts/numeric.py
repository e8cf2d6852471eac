"""Python types of numeric sequences and arrays."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias, get_args

Numeric: TypeAlias = Literal["list", "array", "numpy"]
"""A list; an array for more than MAX_LIST_LENGTH numbers, else a list; or a numpy array."""

FORMS: Final[tuple[Numeric, ...]] = get_args(Numeric)
"""All forms."""

MAX_LIST_LENGTH: Final = 64
"""Maximum number of numbers that are decoded as a list if the form is "array".

Up to about that many, a list takes less time to make than an array (docs/speed.md).
"""
