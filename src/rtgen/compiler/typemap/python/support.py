"""Names of the runtime, the standard library and builtins in generated modules."""

from __future__ import annotations

from rtgen.compiler.kit.words import words

_NAMES = {
    "rtgen.runtime.cdr": (
        "Aggregated AliasCodec Bitset Enumeration Flags Union UserException field"
    ),
    "rtgen.runtime.marshalling.descriptors": (
        "ANY InterfaceDescriptor NULL PrimitiveDescriptor"
    ),
    "typing": "Any ClassVar Final Self TypeAlias cast",
    "rtgen.runtime.values": "AnyValue Box Value",
    "rtgen.runtime.services.call_types": "CallTypes",
    "decimal": "Decimal",
    "collections.abc": "MutableSequence",
    "numpy.typing": "NDArray",
    "rtgen.runtime.marshalling.octets": "ObjectReference",
    "rtgen.runtime": "Servant Skeleton operation Stub idl",
    "abc": "abstractmethod",
    "builtins": (
        "bool bytearray bytes classmethod dict float int len list map object "
        "property range staticmethod str super tuple type zip"
    ),
    "dataclasses": "dataclass",
    "numpy": "numpy",
}
"""The names of each module."""

HOMES = {
    **{name: module for module, names in _NAMES.items() for name in names.split()},
    "dataclass_field": "dataclasses:field",
}
"""Module of each name, with the name there if it differs (`module:name`)."""

BASE_NAMES = words("""
    Component Configuration annotations configuration consumer inport outport parameter provider
    """)
"""Names imported by modules with bases of components."""

CANOPEN_NAMES = words("""
    Any Callable Iterator Mapping cast replace CONFIGURATION DESCRIPTION REMAPPED CanopenDevice
    CanopenProxy SdoService Gathering Getter Incoming Inlet Outgoing Receiver Sender ObjectNumber
    ObjectValue Setter over_sdo unread _pdo bytes codecs data dict divmod get int now port sample
    set_ str tuple value values
    """)
"""Names that are imports or variables in modules of CANopen proxies and devices."""
