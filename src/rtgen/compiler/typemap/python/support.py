"""Names of the runtime, the standard library and builtins in generated modules."""

from __future__ import annotations

HOMES = {
    "Aggregated": "rtgen.runtime.cdr",
    "AliasCodec": "rtgen.runtime.cdr",
    "ANY": "rtgen.runtime.marshalling.descriptors",
    "Any": "typing",
    "AnyValue": "rtgen.runtime.values",
    "Bitset": "rtgen.runtime.cdr",
    "Box": "rtgen.runtime.values",
    "Call": "rtgen.runtime.services.calls",
    "ClassVar": "typing",
    "Decimal": "decimal",
    "Enumeration": "rtgen.runtime.cdr",
    "Final": "typing",
    "Flags": "rtgen.runtime.cdr",
    "InterfaceDescriptor": "rtgen.runtime.marshalling.descriptors",
    "MutableSequence": "collections.abc",
    "NDArray": "numpy.typing",
    "NULL": "rtgen.runtime.marshalling.descriptors",
    "ObjectReference": "rtgen.runtime.marshalling.octets",
    "PrimitiveDescriptor": "rtgen.runtime.marshalling.descriptors",
    "Self": "typing",
    "Servant": "rtgen.runtime",
    "Skeleton": "rtgen.runtime",
    "operation": "rtgen.runtime",
    "Stub": "rtgen.runtime",
    "TypeAlias": "typing",
    "Union": "rtgen.runtime.cdr",
    "UserException": "rtgen.runtime.cdr",
    "Value": "rtgen.runtime.values",
    "abstractmethod": "abc",
    "bool": "builtins",
    "bytearray": "builtins",
    "bytes": "builtins",
    "cast": "typing",
    "classmethod": "builtins",
    "dataclass": "dataclasses",
    "dataclass_field": "dataclasses:field",
    "dict": "builtins",
    "field": "rtgen.runtime.cdr",
    "float": "builtins",
    "idl": "rtgen.runtime",
    "int": "builtins",
    "len": "builtins",
    "list": "builtins",
    "map": "builtins",
    "numpy": "numpy",
    "object": "builtins",
    "property": "builtins",
    "range": "builtins",
    "staticmethod": "builtins",
    "str": "builtins",
    "super": "builtins",
    "tuple": "builtins",
    "type": "builtins",
    "zip": "builtins",
}
"""Module of each name, with the name there if it differs (`module:name`)."""

BASE_NAMES = frozenset(
    {
        *("Component", "Configuration", "annotations", "configuration", "consumer"),
        *("inport", "outport", "parameter", "provider"),
    }
)
"""Names imported by modules with bases of components."""

CANOPEN_NAMES = frozenset(
    {
        *("Any", "Callable", "Iterator", "Mapping", "cast", "replace"),
        *("CONFIGURATION", "DESCRIPTION", "REMAPPED"),
        *("CanopenDevice", "CanopenProxy", "SdoService"),
        *("Gathering", "Getter", "Incoming", "Inlet", "Outgoing", "Receiver", "Sender"),
        *("ObjectNumber", "ObjectValue", "Setter", "over_sdo", "unread", "_pdo"),
        *("bytes", "codecs", "data", "dict", "divmod", "get", "int", "now", "port"),
        *("sample", "set_", "str", "tuple", "value", "values"),
    }
)
"""Names that are imports or variables in modules of CANopen proxies and devices."""
