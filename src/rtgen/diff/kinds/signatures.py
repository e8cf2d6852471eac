"""Kinds of changes of CDL: signatures, types, celltypes, cells (DIF04..)."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_NONE: tuple[Break, ...] = ()

SIGNATURE_ADDED = Kind(
    "DIF0401",
    "signature added",
    _NONE,
    "no code called the signature before",
)
SIGNATURE_REMOVED = Kind(
    "DIF0402",
    "signature removed",
    _SOURCE,
    "callers and cells have no signature any more",
    (Wire.TDR,),
)
SIGNATURE_RENAMED = Kind(
    "DIF0403",
    "signature renamed",
    _SOURCE,
    "messages hold no name, but celltypes and code do",
)
SIGNATURE_CONTEXT = Kind(
    "DIF0404",
    "context or callback of a signature changed",
    _SOURCE,
    "the functions may be called from other contexts",
)
SIGNATURE_DEVIATE = Kind(
    "DIF0405",
    "deviate changed",
    _NONE,
    "only warnings about pointers depend on it",
)
FUNCTION_ADDED = Kind(
    "DIF0410",
    "function added at the end of a signature",
    _SOURCE,
    "no other function id changes, but cells have to implement the function",
)
FUNCTION_INSERTED = Kind(
    "DIF0411",
    "function inserted into a signature",
    _SOURCE,
    "function ids count in the order of the text, so all that follow get another "
    "one",
    (Wire.FUNCTION_ID,),
)
FUNCTION_REMOVED = Kind(
    "DIF0412",
    "function removed from a signature",
    _SOURCE,
    "requests with its id are refused, or reach another function",
    (Wire.FUNCTION_ID,),
)
FUNCTION_RENAMED = Kind(
    "DIF0413",
    "function renamed",
    _SOURCE,
    "requests hold the id alone, but code names the function",
)
FUNCTION_MOVED = Kind(
    "DIF0414",
    "function with another id",
    _NONE,
    "requests with the old id reach another function",
    (Wire.FUNCTION_ID,),
)
FUNCTION_ONEWAY = Kind(
    "DIF0415",
    "function made oneway or twoway",
    _SOURCE,
    "a oneway function has no reply",
    (Wire.TDR,),
)
FUNCTION_RESULT = Kind(
    "DIF0416",
    "function with another result",
    _SOURCE,
    "the caller interprets the octets as a value of its own type",
    (Wire.TDR,),
)
PARAMETER_ADDED = Kind(
    "DIF0420",
    "parameter added to a function",
    _SOURCE,
    "messages carry exactly the parameters of their function",
    (Wire.TDR,),
)
PARAMETER_REMOVED = Kind(
    "DIF0421",
    "parameter removed from a function",
    _SOURCE,
    "messages carry exactly the parameters of their function",
    (Wire.TDR,),
)
PARAMETERS_REORDERED = Kind(
    "DIF0422",
    "parameters of a function in another order",
    _SOURCE,
    "parameters travel in order",
    (Wire.TDR,),
)
PARAMETER_RENAMED = Kind(
    "DIF0423",
    "parameter of a function renamed",
    _SOURCE,
    "messages hold no names, but calls with keywords and the digest of the "
    "signature do",
)
PARAMETER_DIRECTION = Kind(
    "DIF0424",
    "direction specifier changed",
    _SOURCE,
    "the value joins or leaves the request or the reply",
    (Wire.TDR,),
)
PARAMETER_TYPE = Kind(
    "DIF0425",
    "parameter of another C type",
    _SOURCE,
    "the receiver interprets the octets as a value of its own type",
    (Wire.TDR,),
)
PARAMETER_ALIAS = Kind(
    "DIF0426",
    "parameter of the same C type by another name",
    _NONE,
    "a typedef or qualifier changes no octet",
)
SIZE_IS = Kind(
    "DIF0427",
    "size_is changed",
    _SOURCE,
    "caller and cell disagree on how many elements fit",
    (Wire.TDR,),
)
COUNT_IS = Kind(
    "DIF0428",
    "count_is changed",
    _SOURCE,
    "caller and cell disagree on how many elements travel",
    (Wire.TDR,),
)
STRING = Kind(
    "DIF0429",
    "string specifier changed",
    _SOURCE,
    "caller and cell disagree on the length of the text",
    (Wire.TDR,),
)
MAX_SIZE_LOWERED = Kind(
    "DIF0430",
    "greatest size lowered or added",
    _SOURCE,
    "longer arrays than the new bound are refused",
    (Wire.TDR,),
)
MAX_SIZE_RAISED = Kind(
    "DIF0431",
    "greatest size raised or removed",
    _NONE,
    "old peers refuse longer arrays than their bound",
    (Wire.TDR,),
)
NULLABLE = Kind(
    "DIF0432",
    "nullable changed",
    _SOURCE,
    "a nullable pointer travels with a flag",
    (Wire.TDR,),
)
ALLOCATOR = Kind(
    "DIF0433",
    "allocator of a send or receive parameter changed",
    _SOURCE,
    "memory comes from another cell",
)
STRUCT_ADDED = Kind(
    "DIF0440",
    "C type added",
    _NONE,
    "nothing used the type",
)
STRUCT_REMOVED = Kind(
    "DIF0441",
    "C type removed",
    _SOURCE,
    "code of the type has no declaration any more",
)
STRUCT_RENAMED = Kind(
    "DIF0451",
    "C struct renamed",
    _SOURCE,
    "messages hold no name, but code does",
)
STRUCT_MEMBER_ADDED = Kind(
    "DIF0442",
    "member added to a C struct",
    _SOURCE,
    "structs travel with exactly their members",
    (Wire.TDR,),
)
STRUCT_MEMBER_REMOVED = Kind(
    "DIF0443",
    "member removed from a C struct",
    _SOURCE,
    "structs travel with exactly their members",
    (Wire.TDR,),
)
STRUCT_MEMBERS_REORDERED = Kind(
    "DIF0444",
    "members of a C struct in another order",
    _SOURCE,
    "members travel in order",
    (Wire.TDR,),
)
STRUCT_MEMBER_RENAMED = Kind(
    "DIF0445",
    "member of a C struct renamed",
    _SOURCE,
    "messages hold no names, but code does",
)
STRUCT_MEMBER_TYPE = Kind(
    "DIF0446",
    "member of a C struct of another type",
    _SOURCE,
    "the receiver interprets the octets as a value of its own type",
    (Wire.TDR,),
)
STRUCT_MEMBER_SIZES = Kind(
    "DIF0447",
    "size specifiers of a member changed",
    _SOURCE,
    "sender and receiver disagree on the length",
    (Wire.TDR,),
)
TYPEDEF = Kind(
    "DIF0448",
    "C typedef of another type",
    _SOURCE,
    "everything of the typedef's type has another type",
)
ENUM = Kind(
    "DIF0449",
    "C enum changed",
    _SOURCE,
    "numbers have other names",
)
CONST = Kind(
    "DIF0450",
    "constant of CDL changed",
    _SOURCE,
    "expressions and bounds with the constant have another value",
)
CELLTYPE_ADDED = Kind(
    "DIF0460",
    "celltype added",
    _NONE,
    "no cell was of the celltype",
)
CELLTYPE_REMOVED = Kind(
    "DIF0461",
    "celltype removed",
    _SOURCE,
    "cells and their C code have no celltype any more",
)
CELLTYPE_PORT_ADDED = Kind(
    "DIF0462",
    "call port added to a celltype",
    _SOURCE,
    "cells have to join the port",
)
CELLTYPE_ENTRY_ADDED = Kind(
    "DIF0463",
    "entry or optional port added to a celltype",
    _NONE,
    "no cell needs to join the port",
)
CELLTYPE_PORT_REMOVED = Kind(
    "DIF0464",
    "port removed from a celltype",
    _SOURCE,
    "joins to or from the port have no end",
)
CELLTYPE_PORT_SIGNATURE = Kind(
    "DIF0465",
    "port with another signature or kind",
    _SOURCE,
    "joined ports need one signature",
    (Wire.TDR,),
)
CELLTYPE_PORT_ARRAY = Kind(
    "DIF0466",
    "array of a port changed",
    _SOURCE,
    "joins have other subscripts",
)
CELLTYPE_PORT_SPECIFIER = Kind(
    "DIF0467",
    "specifiers of a port changed",
    _SOURCE,
    "tecsgen makes other code for the port",
)
CELLTYPE_VARIABLE = Kind(
    "DIF0468",
    "attribute or variable of a celltype changed",
    _SOURCE,
    "cells initialise it, and C code uses it",
)
CELLTYPE_KIND = Kind(
    "DIF0469",
    "singleton, active or idx_is_id changed",
    _SOURCE,
    "tecsgen makes other code for the celltype",
)
CELL_ADDED = Kind(
    "DIF0480",
    "cell added",
    _NONE,
    "nothing was joined to the cell",
)
CELL_REMOVED = Kind(
    "DIF0481",
    "cell removed",
    _SOURCE,
    "proxies and tasks of the cell are removed",
)
CELL_RENAMED = Kind(
    "DIF0482",
    "cell renamed",
    _SOURCE,
    "joins and generated names contain the name",
)
CELL_CELLTYPE = Kind(
    "DIF0483",
    "cell of another celltype",
    _SOURCE,
    "the cell has other ports",
)
CELL_ATTRIBUTE = Kind(
    "DIF0484",
    "attribute of a cell changed",
    _STORED,
    "the cell starts with another value",
)
JOIN_ADDED = Kind(
    "DIF0485",
    "join added",
    _NONE,
    "the call port reached nothing before",
)
JOIN_REMOVED = Kind(
    "DIF0486",
    "join removed",
    _SOURCE,
    "calls through the port reach no cell",
)
JOIN_TARGET = Kind(
    "DIF0487",
    "join with another entry",
    _SOURCE,
    "calls reach another cell",
)
JOIN_PLUGIN = Kind(
    "DIF0488",
    "plug-ins of a join changed",
    _SOURCE,
    "the calls travel in another way",
)
JOIN_OPTIONS = Kind(
    "DIF0489",
    "options of a join through RTCPlugin changed",
    _SOURCE,
    "the peers have to agree on transport, address and data representation",
    (Wire.TDR,),
)
REGION_ADDED = Kind(
    "DIF0491",
    "region added",
    _NONE,
    "no cell was in the region",
)
REGION = Kind(
    "DIF0490",
    "region changed",
    _SOURCE,
    "cells move to another executable, and joins between regions change",
)

KINDS = (
    SIGNATURE_ADDED,
    SIGNATURE_REMOVED,
    SIGNATURE_RENAMED,
    SIGNATURE_CONTEXT,
    SIGNATURE_DEVIATE,
    FUNCTION_ADDED,
    FUNCTION_INSERTED,
    FUNCTION_REMOVED,
    FUNCTION_RENAMED,
    FUNCTION_MOVED,
    FUNCTION_ONEWAY,
    FUNCTION_RESULT,
    PARAMETER_ADDED,
    PARAMETER_REMOVED,
    PARAMETERS_REORDERED,
    PARAMETER_RENAMED,
    PARAMETER_DIRECTION,
    PARAMETER_TYPE,
    PARAMETER_ALIAS,
    SIZE_IS,
    COUNT_IS,
    STRING,
    MAX_SIZE_LOWERED,
    MAX_SIZE_RAISED,
    NULLABLE,
    ALLOCATOR,
    STRUCT_ADDED,
    STRUCT_REMOVED,
    STRUCT_RENAMED,
    STRUCT_MEMBER_ADDED,
    STRUCT_MEMBER_REMOVED,
    STRUCT_MEMBERS_REORDERED,
    STRUCT_MEMBER_RENAMED,
    STRUCT_MEMBER_TYPE,
    STRUCT_MEMBER_SIZES,
    TYPEDEF,
    ENUM,
    CONST,
    CELLTYPE_ADDED,
    CELLTYPE_REMOVED,
    CELLTYPE_PORT_ADDED,
    CELLTYPE_ENTRY_ADDED,
    CELLTYPE_PORT_REMOVED,
    CELLTYPE_PORT_SIGNATURE,
    CELLTYPE_PORT_ARRAY,
    CELLTYPE_PORT_SPECIFIER,
    CELLTYPE_VARIABLE,
    CELLTYPE_KIND,
    CELL_ADDED,
    CELL_REMOVED,
    CELL_RENAMED,
    CELL_CELLTYPE,
    CELL_ATTRIBUTE,
    JOIN_ADDED,
    JOIN_REMOVED,
    JOIN_TARGET,
    JOIN_PLUGIN,
    JOIN_OPTIONS,
    REGION_ADDED,
    REGION,
)
