"""Types of configuration parameters and their C++ names in an RtcProfile.

Source: the output of RTCBuilder (facts on `rtc:Configuration`); `_FURTHER` has variants used by
people.
"""

from __future__ import annotations

import re

from rtgen.model import Primitive, PrimitiveType, SequenceType, StringType, Type

WORDS = {
    Primitive.OCTET: "unsigned short int",
    Primitive.INT8: "short",
    Primitive.UINT8: "unsigned short int",
    Primitive.SHORT: "short",
    Primitive.UNSIGNED_SHORT: "unsigned short int",
    Primitive.LONG: "int",
    Primitive.UNSIGNED_LONG: "unsigned int",
    Primitive.LONG_LONG: "long long",
    Primitive.UNSIGNED_LONG_LONG: "unsigned long long",
    Primitive.FLOAT: "float",
    Primitive.DOUBLE: "double",
    Primitive.BOOLEAN: "bool",
}

_FURTHER = {
    "short int": Primitive.SHORT,
    "unsigned short": Primitive.UNSIGNED_SHORT,
    "unsigned": Primitive.UNSIGNED_LONG,
    "long": Primitive.LONG,
    "long int": Primitive.LONG,
    "unsigned long": Primitive.UNSIGNED_LONG,
    "unsigned long int": Primitive.UNSIGNED_LONG,
    "long long int": Primitive.LONG_LONG,
    "unsigned long long int": Primitive.UNSIGNED_LONG_LONG,
    "boolean": Primitive.BOOLEAN,
    "octet": Primitive.OCTET,
    "unsigned char": Primitive.OCTET,
}
_STRINGS = ("string", "std::string", "char*", "const char*", "char", "str")
_TYPES = {
    **_FURTHER,
    **{word: kind for kind, word in reversed(WORDS.items())},
    "short": Primitive.SHORT,
    "unsigned short int": Primitive.UNSIGNED_SHORT,
}
_VECTOR = re.compile(r"(?:std::)?vector ?< ?(.*?) ?>")


def type_of(word: str) -> Type | None:
    """Return the type for a name; None for an unknown one."""
    word = " ".join(word.split())
    if word in _STRINGS:
        return StringType()
    if (found := _VECTOR.fullmatch(word)) is not None:
        element = type_of(found[1])
        plain = element is not None and not isinstance(element, SequenceType)
        return SequenceType(element) if element is not None and plain else None
    kind = _TYPES.get(word)
    return None if kind is None else PrimitiveType(kind)
