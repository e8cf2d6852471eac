"""Kinds of changes of interfaces, their operations and valuetypes (DIF02..)."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

INTERFACE_ADDED = Kind(
    "DIF0201",
    "interface added",
    _NONE,
    "no code called the interface before",
)
INTERFACE_REMOVED = Kind(
    "DIF0202",
    "interface removed",
    _SOURCE,
    "callers and servants have no class any more",
    (Wire.GIOP,),
)
INTERFACE_RENAMED = Kind(
    "DIF0203",
    "interface renamed",
    _BOTH,
    "references carry the repository id, and code and profiles the name",
    (Wire.GIOP,),
)
INTERFACE_ID = Kind(
    "DIF0204",
    "repository id of an interface changed",
    _NONE,
    "references carry the repository id, which narrowing compares",
    (Wire.GIOP,),
)
INTERFACE_BASES = Kind(
    "DIF0205",
    "bases of an interface changed",
    _SOURCE,
    "inherited operations come or go, and references narrow to other interfaces",
    (Wire.GIOP,),
)
INTERFACE_LOCAL = Kind(
    "DIF0206",
    "interface made local or remote",
    _SOURCE,
    "a local interface has no references that travel",
    (Wire.GIOP,),
)
INTERFACE_ABSTRACT = Kind(
    "DIF0207",
    "interface made abstract or concrete",
    _SOURCE,
    "an abstract interface travels with a flag for values",
    (Wire.GIOP,),
)
OPERATION_ADDED = Kind(
    "DIF0210",
    "operation added",
    _SOURCE,
    "callers stay as they are, but servants have to implement the operation",
)
OPERATION_REMOVED = Kind(
    "DIF0211",
    "operation removed",
    _SOURCE,
    "calls of the operation end in BAD_OPERATION",
    (Wire.GIOP,),
)
OPERATION_RENAMED = Kind(
    "DIF0212",
    "operation renamed",
    _SOURCE,
    "GIOP calls operations by name",
    (Wire.GIOP,),
)
PARAMETER_ADDED = Kind(
    "DIF0213",
    "parameter added to an operation",
    _SOURCE,
    "a call carries exactly the parameters of its operation",
    (Wire.GIOP,),
)
PARAMETER_REMOVED = Kind(
    "DIF0214",
    "parameter removed from an operation",
    _SOURCE,
    "a call carries exactly the parameters of its operation",
    (Wire.GIOP,),
)
PARAMETERS_REORDERED = Kind(
    "DIF0215",
    "parameters in another order",
    _SOURCE,
    "parameters travel, and are passed, in order",
    (Wire.GIOP,),
)
PARAMETER_RENAMED = Kind(
    "DIF0216",
    "parameter of an operation renamed",
    _SOURCE,
    "the octets hold no names, but calls with keywords do",
)
PARAMETER_DIRECTION = Kind(
    "DIF0217",
    "direction of a parameter changed",
    _SOURCE,
    "the parameter joins or leaves the request or the reply",
    (Wire.GIOP,),
)
PARAMETER_TYPE = Kind(
    "DIF0218",
    "parameter of another type",
    _SOURCE,
    "the receiver interprets the octets as a value of its own type",
    (Wire.GIOP,),
)
PARAMETER_ALIAS = Kind(
    "DIF0219",
    "parameter or result of the same type by another name",
    _NONE,
    "a typedef has the octets and values of its type",
)
RESULT_TYPE = Kind(
    "DIF0220",
    "result of another type",
    _SOURCE,
    "the caller interprets the octets as a value of its own type",
    (Wire.GIOP,),
)
ONEWAY = Kind(
    "DIF0221",
    "operation made oneway or twoway",
    _SOURCE,
    "a oneway call has no reply, and its caller does not wait",
    (Wire.GIOP,),
)
RAISES_ADDED = Kind(
    "DIF0222",
    "exception added to an operation",
    _SOURCE,
    "old callers get UNKNOWN for the exception",
    (Wire.GIOP,),
)
RAISES_REMOVED = Kind(
    "DIF0223",
    "exception removed from an operation",
    _SOURCE,
    "servants that raise it are refused",
)
CONTEXT = Kind(
    "DIF0224",
    "context of an operation changed",
    _SOURCE,
    "a call carries the context clause",
    (Wire.GIOP,),
)
OPERATIONS_REORDERED = Kind(
    "DIF0225",
    "operations in another order",
    _NONE,
    "GIOP calls operations by name, in any order",
)
ATTRIBUTE_ADDED = Kind(
    "DIF0230",
    "attribute added",
    _SOURCE,
    "callers stay as they are, but servants have to implement the attribute",
)
ATTRIBUTE_REMOVED = Kind(
    "DIF0231",
    "attribute removed",
    _SOURCE,
    "calls of _get_ and _set_ end in BAD_OPERATION",
    (Wire.GIOP,),
)
ATTRIBUTE_TYPE = Kind(
    "DIF0232",
    "attribute of another type",
    _SOURCE,
    "the receiver interprets the octets as a value of its own type",
    (Wire.GIOP,),
)
ATTRIBUTE_READONLY = Kind(
    "DIF0233",
    "attribute made readonly",
    _SOURCE,
    "calls of _set_ end in BAD_OPERATION",
    (Wire.GIOP,),
)
ATTRIBUTE_WRITABLE = Kind(
    "DIF0234",
    "attribute made writable",
    _SOURCE,
    "callers stay as they are, but servants have to take values",
)
ATTRIBUTE_RAISES = Kind(
    "DIF0235",
    "exceptions of an attribute changed",
    _SOURCE,
    "callers and servants disagree on exceptions",
    (Wire.GIOP,),
)
VALUETYPE_CHANGED = Kind(
    "DIF0240",
    "state of a valuetype changed",
    _BOTH,
    "values travel with all of their state in order",
    (Wire.GIOP,),
)
VALUETYPE_KIND = Kind(
    "DIF0241",
    "valuetype made abstract, custom or truncatable",
    _SOURCE,
    "the header and the truncation of a value depend on the modifier",
    (Wire.GIOP,),
)
VALUETYPE_INTERFACE = Kind(
    "DIF0242",
    "operations or factories of a valuetype changed",
    _SOURCE,
    "implementations and callers of the valuetype disagree",
)

KINDS = (
    INTERFACE_ADDED,
    INTERFACE_REMOVED,
    INTERFACE_RENAMED,
    INTERFACE_ID,
    INTERFACE_BASES,
    INTERFACE_LOCAL,
    INTERFACE_ABSTRACT,
    OPERATION_ADDED,
    OPERATION_REMOVED,
    OPERATION_RENAMED,
    PARAMETER_ADDED,
    PARAMETER_REMOVED,
    PARAMETERS_REORDERED,
    PARAMETER_RENAMED,
    PARAMETER_DIRECTION,
    PARAMETER_TYPE,
    PARAMETER_ALIAS,
    RESULT_TYPE,
    ONEWAY,
    RAISES_ADDED,
    RAISES_REMOVED,
    CONTEXT,
    OPERATIONS_REORDERED,
    ATTRIBUTE_ADDED,
    ATTRIBUTE_REMOVED,
    ATTRIBUTE_TYPE,
    ATTRIBUTE_READONLY,
    ATTRIBUTE_WRITABLE,
    ATTRIBUTE_RAISES,
    VALUETYPE_CHANGED,
    VALUETYPE_KIND,
    VALUETYPE_INTERFACE,
)
