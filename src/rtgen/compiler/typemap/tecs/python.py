"""Python names and types for declarations of a CDL file."""

from __future__ import annotations

import builtins
from collections.abc import Mapping

from rtgen.compiler.kit.words import words
from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Octets,
    Record,
    String,
)
from rtgen.compiler.model import ScopedName
from rtgen.compiler.model.tecs import Signature
from rtgen.compiler.typemap.python.names import identifier, module_name
from rtgen.compiler.typemap.python.support import BASE_NAMES, HOMES
from rtgen.facts.tdr import Scalar

CODEC_IMPORTS: Mapping[str, tuple[str, ...]] = {
    "channel": ("More",),
    "codecs": ("Codec", "Messages", "REPLY_LIMIT", "REQUEST_LIMIT", "RecordCodec"),
    "tdr": (
        "EOP_NOTHING_FOLLOWS",
        "EOP_REPLY_FOLLOWS",
        "INT8",
        "Items",
        "NETWORK",
        "SOP_REPLY",
        "SOP_REQUEST",
        "Tdr",
        "UINT8",
    ),
    "values": (
        "ByteBudget",
        "FAILURES",
        "Text",
        "WideText",
        "argument_error",
        "cast",
        "element",
        "exactly",
        "is_rpc_error",
        "leading",
        "leading_bytes",
        "present",
        "quotient",
        "remainder",
        "shifted_left",
        "shifted_right",
        "size_error",
        "within",
    ),
}
"""Names that generated codecs import, by module of `rtgen.runtime.opaque_rpc`."""

IMPORTED_NAMES = frozenset(name for names in CODEC_IMPORTS.values() for name in names)

CODEC_ATTRIBUTES = words("""
    awaiting_reply digest encoding functions nothing_follows reply_limit request_head request_limit
    request_sop signature tdr
    """)
"""Attributes of codecs, besides those for functions."""

MARSHALLER_NAMES = words("""
    Channel CommunicationChannel OpaqueRpc ProxyServant RTC_OK ReturnCode_t Sequence make_tdr
    """)
"""Names imported by the module of a marshaller, besides those of its types and bases."""

_OF_MODULES = frozenset(
    (
        *IMPORTED_NAMES,
        *MARSHALLER_NAMES,
        *BASE_NAMES,
        *HOMES,
        *("ABC", "Handlers", "Mapping"),
        *dir(builtins),
    )
)
"""Names used by generated modules, which structs and constants cannot have."""

_IN_CLASSES = ("bool", "bytes", "field", "float", "int", "list", "range", "str")
"""Names used in the body of a struct's class."""

_FLOATS = (Scalar.FLOAT32, Scalar.DOUBLE64)


def plain_name(signature: Signature) -> str:
    """Return the name of a signature's artifacts: `sServer` gives `Server`."""
    name = signature.name[-1]
    if name[0] == "s" and name[1:2].isupper():
        return name[1:]
    return name


def codec_class(signature: Signature) -> str:
    """Return the class of a signature's codec."""
    return identifier(f"{identifier(plain_name(signature))}Codec", HOMES)


def codec_module(signature: Signature) -> str:
    """Return the module of a signature's codec."""
    return f"{module_name(plain_name(signature))}_codec"


def struct_class(tag: ScopedName) -> str:
    """Return the class of a struct."""
    return module_level_name("_".join(tag))


def module_level_name(name: str) -> str:
    """Return the name of a struct's class, a typedef or a constant."""
    return identifier(name, _OF_MODULES)


def member_name(name: str) -> str:
    """Return the attribute of a struct's member."""
    return identifier(name, _IN_CLASSES)


def annotation(node: Node, given: bool = False) -> str:
    """Return the annotation of a value; `given`: it is only read, so tuples are accepted."""
    many = "Sequence" if given else "list"
    match node:
        case Basic(Scalar.BOOL):
            return "bool"
        case Basic(scalar):
            return "float" if scalar in _FLOATS else "int"
        case Octets():
            return "bytes"
        case FixedArray(element):
            return f"{many}[{annotation(element, given)}]"
        case Record(struct):
            return struct_class(struct.name)
        case Counted():
            if node.is_octets:
                return "bytes"
            return f"{many}[{annotation(node.element, given)}]"
        case String():
            return f"{many}[int]" if node.is_wide else "str"
    return "None"


def item_annotation(item: Item, given: bool = False) -> str:
    """Return the annotation of a parameter; None represents NULL."""
    text = annotation(item.node, given)
    return f"{text} | None" if item.nullable and text != "None" else text


def argument_annotation(item: Item) -> str:
    """Return the annotation of a parameter in a request."""
    return "bool" if item.asked else item_annotation(item, given=True)


def zero(node: Node) -> str:
    """Return an expression for a zero value; arrays and texts of variable length are empty."""
    match node:
        case Basic(Scalar.BOOL):
            return "False"
        case Basic(scalar):
            return "0.0" if scalar in _FLOATS else "0"
        case Octets(count=count):
            return f"bytes({count})"
        case FixedArray(element, count):
            if isinstance(element, Basic | Octets):
                return f"[{zero(element)}] * {count}"
            return f"[{zero(element)} for _ in range({count})]"
        case Record(struct):
            return f"{struct_class(struct.name)}()"
        case Counted():
            return 'b""' if node.is_octets else "[]"
        case String():
            return "[]" if node.is_wide else '""'
    return "None"


def is_mutable(node: Node) -> bool:
    """Return whether a value is mutable."""
    match node:
        case FixedArray() | Record():
            return True
        case Counted():
            return not node.is_octets
        case String():
            return node.is_wide
    return False
