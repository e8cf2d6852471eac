"""Rules of cells and joins (CDL06xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_CELLTYPE = Rule("CDL0600", "celltype not found", Severity.ERROR)
NOT_A_CELLTYPE = Rule("CDL0601", "not a celltype", Severity.ERROR)
CELL_MISMATCH = Rule("CDL0602", "cell declared again differently", Severity.ERROR)
CELL_TWICE = Rule("CDL0603", "cell defined twice", Severity.ERROR)
CELL_IN_NAMESPACE = Rule("CDL0604", "cell in a name space", Severity.ERROR)
SECOND_SINGLETON = Rule("CDL0605", "second cell of a singleton", Severity.ERROR)
UNDEFINED_CELL = Rule("CDL0606", "cell used, but never defined", Severity.ERROR)
UNUSED_PROTOTYPE = Rule(
    "CDL0607", "prototype of a cell that is neither used nor defined", Severity.NOTE
)
UNUSED_CELL = Rule("CDL0608", "cell without callers", Severity.WARNING)
PROTOTYPE = Rule("CDL0609", "invalid prototype", Severity.ERROR)
UNKNOWN_CELL = Rule("CDL0610", "cell not found", Severity.ERROR)
NOT_A_CELL = Rule("CDL0611", "not a cell", Severity.ERROR)
UNKNOWN_ENTRY = Rule("CDL0612", "cell has no such port", Severity.ERROR)
NOT_AN_ENTRY = Rule("CDL0613", "not an entry port", Severity.ERROR)
SIGNATURE_MISMATCH = Rule(
    "CDL0614", "call port and entry port of different signatures", Severity.ERROR
)
LEFT_SUBSCRIPT = Rule("CDL0615", "subscript of a call port", Severity.ERROR)
RIGHT_SUBSCRIPT = Rule("CDL0616", "subscript of an entry port", Severity.ERROR)
UNKNOWN_NAME = Rule("CDL0617", "celltype has no such port or attribute", Severity.ERROR)
ENTRY_ON_THE_LEFT = Rule(
    "CDL0618", "entry port where a call port is required", Severity.ERROR
)
VARIABLE_IN_CELL = Rule("CDL0619", "variable set by a cell", Severity.ERROR)
NOT_A_TARGET = Rule("CDL0620", "call port joined to no entry port", Severity.ERROR)
JOINED_TWICE = Rule("CDL0621", "joined or set twice", Severity.ERROR)
NOT_JOINED = Rule("CDL0622", "call port without a join", Severity.ERROR)
ARRAY_HOLE = Rule(
    "CDL0623", "call port array with another number of joins", Severity.ERROR
)
NO_VALUE = Rule("CDL0624", "attribute without a value", Severity.ERROR)
BAD_ID = Rule("CDL0625", "impossible id", Severity.ERROR)
ID_TAKEN = Rule("CDL0626", "id too large or taken", Severity.ERROR)
REVERSE_JOIN = Rule("CDL0627", "invalid reverse join", Severity.ERROR)
NOT_REACHED = Rule("CDL0628", "required cell not reached", Severity.ERROR)
REQUIRE_OVERRIDDEN = Rule(
    "CDL0629", "required port joined by the cell", Severity.WARNING
)
RESTRICT = Rule("CDL0630", "region of restrict not found", Severity.ERROR)
RELAY = Rule("CDL0631", "allocator cannot be relayed", Severity.ERROR)
NOT_A_CHOICE = Rule("CDL0632", "value not among the choices", Severity.WARNING)
MANY_CALLERS = Rule("CDL0633", "fixed join beside another join", Severity.WARNING)
GENERATE_TARGET = Rule("CDL0634", "target of generate not found", Severity.ERROR)
MADE_BY_PLUGIN = Rule("CDL0635", "name or join that a plug-in may add", Severity.NOTE)
ALLOCATOR_OF_CELL = Rule(
    "CDL0636", "allocator of a cell that names nothing", Severity.ERROR
)

RULES = rules_of(globals())
