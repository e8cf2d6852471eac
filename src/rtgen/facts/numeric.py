"""The forms of numeric sequences and arrays in Python."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias, get_args

Numeric: TypeAlias = Literal["list", "array", "numpy"]
"""A list, `NumericArray` of the runtime (an `array.array`), a numpy array."""

FORMS: Final[tuple[Numeric, ...]] = get_args(Numeric)
"""All forms."""

LONGEST_LIST: Final = 16
"""Arrays and bounded sequences of up to so many numbers stay lists where "array" is the form.

Up to about as many items, an array takes longer to make than a list (docs/speed.md).
"""
