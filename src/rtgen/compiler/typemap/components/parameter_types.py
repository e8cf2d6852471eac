"""Types of configuration parameters and their C++ names in an RtcProfile.

Source: the output of RTCBuilder (facts on `rtc:Configuration`).
"""

from __future__ import annotations

from rtgen.compiler.model import (
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.facts.parameter_words import STRING, canonical

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


def type_of(word: str) -> Type | None:
    """Return the type for a name; None for an unknown one."""
    name = canonical(word)
    if name is None:
        return None
    element = name.removeprefix("sequence<").removesuffix(">")
    type_ = StringType() if element == STRING else PrimitiveType(Primitive(element))
    return type_ if element == name else SequenceType(type_)
