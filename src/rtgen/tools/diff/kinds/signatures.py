"""Kinds of changes of CDL: signatures, types, celltypes, cells (DIF04..)."""

from __future__ import annotations

from rtgen.tools.diff.changes import Break, Kind, Wire, kinds_of

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_NONE: tuple[Break, ...] = ()

SIGNATURE_ADDED = Kind("DIF0401", "signature added", _NONE)
SIGNATURE_REMOVED = Kind("DIF0402", "signature removed", _SOURCE, (Wire.TDR,))
SIGNATURE_RENAMED = Kind("DIF0403", "signature renamed", _SOURCE)
SIGNATURE_CONTEXT = Kind(
    "DIF0404", "context or callback of a signature changed", _SOURCE
)
SIGNATURE_DEVIATE = Kind("DIF0405", "deviate changed", _NONE)
FUNCTION_ADDED = Kind("DIF0410", "function added at the end of a signature", _SOURCE)
FUNCTION_INSERTED = Kind(
    "DIF0411", "function inserted into a signature", _SOURCE, (Wire.FUNCTION_ID,)
)
FUNCTION_REMOVED = Kind(
    "DIF0412", "function removed from a signature", _SOURCE, (Wire.FUNCTION_ID,)
)
FUNCTION_RENAMED = Kind("DIF0413", "function renamed", _SOURCE)
FUNCTION_MOVED = Kind("DIF0414", "function with another id", _NONE, (Wire.FUNCTION_ID,))
FUNCTION_ONEWAY = Kind(
    "DIF0415", "function made oneway or twoway", _SOURCE, (Wire.TDR,)
)
FUNCTION_RESULT = Kind("DIF0416", "function with another result", _SOURCE, (Wire.TDR,))
PARAMETER_ADDED = Kind("DIF0420", "parameter added to a function", _SOURCE, (Wire.TDR,))
PARAMETER_REMOVED = Kind(
    "DIF0421", "parameter removed from a function", _SOURCE, (Wire.TDR,)
)
PARAMETERS_REORDERED = Kind(
    "DIF0422", "parameters of a function in another order", _SOURCE, (Wire.TDR,)
)
PARAMETER_RENAMED = Kind("DIF0423", "parameter of a function renamed", _SOURCE)
PARAMETER_DIRECTION = Kind(
    "DIF0424", "direction specifier changed", _SOURCE, (Wire.TDR,)
)
PARAMETER_TYPE = Kind("DIF0425", "parameter of another C type", _SOURCE, (Wire.TDR,))
PARAMETER_ALIAS = Kind("DIF0426", "parameter of the same C type by another name", _NONE)
SIZE_IS = Kind("DIF0427", "size_is changed", _SOURCE, (Wire.TDR,))
COUNT_IS = Kind("DIF0428", "count_is changed", _SOURCE, (Wire.TDR,))
STRING = Kind("DIF0429", "string specifier changed", _SOURCE, (Wire.TDR,))
MAX_SIZE_LOWERED = Kind(
    "DIF0430", "greatest size lowered or added", _SOURCE, (Wire.TDR,)
)
MAX_SIZE_RAISED = Kind("DIF0431", "greatest size raised or removed", _NONE, (Wire.TDR,))
NULLABLE = Kind("DIF0432", "nullable changed", _SOURCE, (Wire.TDR,))
ALLOCATOR = Kind("DIF0433", "allocator of a send or receive parameter changed", _SOURCE)
STRUCT_ADDED = Kind("DIF0440", "C type added", _NONE)
STRUCT_REMOVED = Kind("DIF0441", "C type removed", _SOURCE)
STRUCT_RENAMED = Kind("DIF0451", "C struct renamed", _SOURCE)
STRUCT_MEMBER_ADDED = Kind(
    "DIF0442", "member added to a C struct", _SOURCE, (Wire.TDR,)
)
STRUCT_MEMBER_REMOVED = Kind(
    "DIF0443", "member removed from a C struct", _SOURCE, (Wire.TDR,)
)
STRUCT_MEMBERS_REORDERED = Kind(
    "DIF0444", "members of a C struct in another order", _SOURCE, (Wire.TDR,)
)
STRUCT_MEMBER_RENAMED = Kind("DIF0445", "member of a C struct renamed", _SOURCE)
STRUCT_MEMBER_TYPE = Kind(
    "DIF0446", "member of a C struct of another type", _SOURCE, (Wire.TDR,)
)
STRUCT_MEMBER_SIZES = Kind(
    "DIF0447", "size specifiers of a member changed", _SOURCE, (Wire.TDR,)
)
TYPEDEF = Kind("DIF0448", "C typedef of another type", _SOURCE)
ENUM = Kind("DIF0449", "C enum changed", _SOURCE)
CONST = Kind("DIF0450", "constant of CDL changed", _SOURCE)
CELLTYPE_ADDED = Kind("DIF0460", "celltype added", _NONE)
CELLTYPE_REMOVED = Kind("DIF0461", "celltype removed", _SOURCE)
CELLTYPE_PORT_ADDED = Kind("DIF0462", "call port added to a celltype", _SOURCE)
CELLTYPE_ENTRY_ADDED = Kind(
    "DIF0463", "entry or optional port added to a celltype", _NONE
)
CELLTYPE_PORT_REMOVED = Kind("DIF0464", "port removed from a celltype", _SOURCE)
CELLTYPE_PORT_SIGNATURE = Kind(
    "DIF0465", "port with another signature or kind", _SOURCE, (Wire.TDR,)
)
CELLTYPE_PORT_ARRAY = Kind("DIF0466", "array of a port changed", _SOURCE)
CELLTYPE_PORT_SPECIFIER = Kind("DIF0467", "specifiers of a port changed", _SOURCE)
CELLTYPE_VARIABLE = Kind(
    "DIF0468", "attribute or variable of a celltype changed", _SOURCE
)
CELLTYPE_KIND = Kind("DIF0469", "singleton, active or idx_is_id changed", _SOURCE)
CELL_ADDED = Kind("DIF0480", "cell added", _NONE)
CELL_REMOVED = Kind("DIF0481", "cell removed", _SOURCE)
CELL_RENAMED = Kind("DIF0482", "cell renamed", _SOURCE)
CELL_CELLTYPE = Kind("DIF0483", "cell of another celltype", _SOURCE)
CELL_ATTRIBUTE = Kind("DIF0484", "attribute of a cell changed", _STORED)
JOIN_ADDED = Kind("DIF0485", "join added", _NONE)
JOIN_REMOVED = Kind("DIF0486", "join removed", _SOURCE)
JOIN_TARGET = Kind("DIF0487", "join with another entry", _SOURCE)
JOIN_PLUGIN = Kind("DIF0488", "plug-ins of a join changed", _SOURCE)
JOIN_OPTIONS = Kind(
    "DIF0489", "options of a join through RTCPlugin changed", _SOURCE, (Wire.TDR,)
)
REGION_ADDED = Kind("DIF0491", "region added", _NONE)
REGION = Kind("DIF0490", "region changed", _SOURCE)

KINDS = kinds_of(globals())
