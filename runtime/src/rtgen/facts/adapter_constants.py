"""Constants for members of messages: `set` of `[adapter.NAME]` and `[ros2.topics]` in rtgen.toml,
and the property `dataport.ros2.set` of a connector.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple, TypeAlias

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES

Scalar: TypeAlias = bool | int | float | str
AdapterConstant: TypeAlias = Scalar | tuple[Scalar, ...]
"""A boolean, number, text, or a sequence of them."""

_FEW: Final = 8
"""Number of values that a message shows."""


class Shape(NamedTuple):
    """The type of a member: a basic type by its IDL name, `string`, `array`, or another.

    `size` is the bound of a string or sequence, or the length of an array.
    """

    kind: str
    size: int | None = None
    element: Shape | None = None


def takes(shape: Shape, value: AdapterConstant) -> bool:
    """Return whether a value is valid for a member of the type."""
    match shape, value:
        case Shape("array", size, Shape() as element), tuple():
            return len(value) == size and all(takes(element, each) for each in value)
        case Shape("sequence", size, Shape() as element), tuple():
            fits = size is None or len(value) <= size
            return fits and all(takes(element, each) for each in value)
        case Shape("string", size), str():
            return size is None or len(value.encode()) <= size
        case Shape("wstring", size), str():
            return size is None or len(value) <= size
        case Shape("boolean"), bool():
            return True
        case _, bool() | str() | tuple():
            return False
        case Shape(kind), int() if kind in INTEGER_RANGES:
            low, high = INTEGER_RANGES[kind]
            return low <= value <= high
        case Shape(kind), int() | float() if kind in FLOAT_LIMITS:
            return abs(value) <= FLOAT_LIMITS[kind]
    return False


def shown(value: AdapterConstant) -> str:
    """Return a value as a message shows it."""
    if isinstance(value, tuple) and len(value) > _FEW:
        return f"a list of {len(value)}"
    return repr(list(value)) if isinstance(value, tuple) else repr(value)


def is_octets(shape: Shape) -> bool:
    """Return whether values of a sequence or array are `bytes` in Python."""
    return shape.element is not None and shape.element.kind in ("octet", "uint8")


def constants(table: Mapping[str, Any], prefix: str = "") -> dict[str, AdapterConstant]:
    """Return the values by paths of members (`header.frame_id`), which may be nested tables.

    Raises ValueError for other values.
    """
    return dict(_constants(table, prefix))


def _constants(
    table: Mapping[str, Any], prefix: str
) -> Iterator[tuple[str, AdapterConstant]]:
    for name, value in table.items():
        path = prefix + name
        match value:
            case dict():
                yield from _constants(value, f"{path}.")
            case list() if all(
                isinstance(each, bool | int | float | str) for each in value
            ):
                yield path, tuple(value)
            case bool() | int() | float() | str():
                yield path, value
            case _:
                raise ValueError(
                    f"{path!r} is no text, number, boolean, or list of them"
                )


def parsed(text: str) -> dict[str, AdapterConstant]:
    """Return the values of a text with the members of an inline table of TOML.

    Raises ValueError.
    """
    import tomllib

    if "\n" in text:
        raise ValueError("it has more than one line")
    return constants(tomllib.loads(f"set = {{ {text} }}")["set"])
