"""Kinds of changes of interfaces, their operations and valuetypes (DIF02..)."""

from __future__ import annotations

from rtgen.tools.diff.changes import Break, Kind, Wire, kinds_of

_SOURCE = (Break.SOURCE,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

INTERFACE_ADDED = Kind("DIF0201", "interface added", _NONE)
INTERFACE_REMOVED = Kind("DIF0202", "interface removed", _SOURCE, (Wire.GIOP,))
INTERFACE_RENAMED = Kind("DIF0203", "interface renamed", _BOTH, (Wire.GIOP,))
INTERFACE_ID = Kind(
    "DIF0204", "repository id of an interface changed", _NONE, (Wire.GIOP,)
)
INTERFACE_BASES = Kind(
    "DIF0205", "bases of an interface changed", _SOURCE, (Wire.GIOP,)
)
INTERFACE_LOCAL = Kind(
    "DIF0206", "interface made local or remote", _SOURCE, (Wire.GIOP,)
)
INTERFACE_ABSTRACT = Kind(
    "DIF0207", "interface made abstract or concrete", _SOURCE, (Wire.GIOP,)
)
OPERATION_ADDED = Kind("DIF0210", "operation added", _SOURCE)
OPERATION_REMOVED = Kind("DIF0211", "operation removed", _SOURCE, (Wire.GIOP,))
OPERATION_RENAMED = Kind("DIF0212", "operation renamed", _SOURCE, (Wire.GIOP,))
PARAMETER_ADDED = Kind(
    "DIF0213", "parameter added to an operation", _SOURCE, (Wire.GIOP,)
)
PARAMETER_REMOVED = Kind(
    "DIF0214", "parameter removed from an operation", _SOURCE, (Wire.GIOP,)
)
PARAMETERS_REORDERED = Kind(
    "DIF0215", "parameters in another order", _SOURCE, (Wire.GIOP,)
)
PARAMETER_RENAMED = Kind("DIF0216", "parameter of an operation renamed", _SOURCE)
PARAMETER_DIRECTION = Kind(
    "DIF0217", "direction of a parameter changed", _SOURCE, (Wire.GIOP,)
)
PARAMETER_TYPE = Kind("DIF0218", "parameter of another type", _SOURCE, (Wire.GIOP,))
PARAMETER_ALIAS = Kind(
    "DIF0219", "parameter or result of the same type by another name", _NONE
)
RESULT_TYPE = Kind("DIF0220", "result of another type", _SOURCE, (Wire.GIOP,))
ONEWAY = Kind("DIF0221", "operation made oneway or twoway", _SOURCE, (Wire.GIOP,))
RAISES_ADDED = Kind("DIF0222", "exception added to an operation", _SOURCE, (Wire.GIOP,))
RAISES_REMOVED = Kind("DIF0223", "exception removed from an operation", _SOURCE)
CONTEXT = Kind("DIF0224", "context of an operation changed", _SOURCE, (Wire.GIOP,))
OPERATIONS_REORDERED = Kind("DIF0225", "operations in another order", _NONE)
ATTRIBUTE_ADDED = Kind("DIF0230", "attribute added", _SOURCE)
ATTRIBUTE_REMOVED = Kind("DIF0231", "attribute removed", _SOURCE, (Wire.GIOP,))
ATTRIBUTE_TYPE = Kind("DIF0232", "attribute of another type", _SOURCE, (Wire.GIOP,))
ATTRIBUTE_READONLY = Kind("DIF0233", "attribute made readonly", _SOURCE, (Wire.GIOP,))
ATTRIBUTE_WRITABLE = Kind("DIF0234", "attribute made writable", _SOURCE)
ATTRIBUTE_RAISES = Kind(
    "DIF0235", "exceptions of an attribute changed", _SOURCE, (Wire.GIOP,)
)
VALUETYPE_CHANGED = Kind("DIF0240", "state of a valuetype changed", _BOTH, (Wire.GIOP,))
VALUETYPE_KIND = Kind(
    "DIF0241", "valuetype made abstract, custom or truncatable", _SOURCE, (Wire.GIOP,)
)
VALUETYPE_INTERFACE = Kind(
    "DIF0242", "operations or factories of a valuetype changed", _SOURCE
)

KINDS = kinds_of(globals())
