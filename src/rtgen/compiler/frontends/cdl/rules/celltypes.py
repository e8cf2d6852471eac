"""Rules of celltypes and composites (CDL05xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_SIGNATURE = Rule("CDL0500", "signature not found", Severity.ERROR)
NOT_A_SIGNATURE = Rule("CDL0501", "not a signature", Severity.ERROR)
BAD_PORT_SIZE = Rule("CDL0502", "size of a port array", Severity.ERROR)
PORT_SPECIFIER = Rule("CDL0503", "specifier on the wrong kind of port", Severity.ERROR)
SPECIFIERS_CLASH = Rule("CDL0504", "specifiers that exclude each other", Severity.ERROR)
SPECIFIER_TWICE = Rule("CDL0506", "specifier given twice", Severity.ERROR)
NAME_TWICE = Rule("CDL0507", "name declared twice in a celltype", Severity.ERROR)
BAD_FIXED_JOIN = Rule("CDL0508", "invalid fixed join", Severity.ERROR)
UNKNOWN_REQUIRED = Rule(
    "CDL0509", "required celltype or cell not found", Severity.ERROR
)
REQUIRED_NOT_SINGLETON = Rule(
    "CDL0510", "required celltype is not a singleton", Severity.ERROR
)
REQUIRED_NOT_ENTRY = Rule(
    "CDL0511", "required port is not a single entry port", Severity.ERROR
)
REQUIRE_CLASH = Rule("CDL0512", "functions of one name required twice", Severity.ERROR)
UNKNOWN_FACTORY_FUNCTION = Rule(
    "CDL0513", "unknown function in a factory", Severity.ERROR
)
FACTORY_TEXT = Rule(
    "CDL0514", "file or format of write is not a string", Severity.ERROR
)
FACTORY_ARGUMENT = Rule(
    "CDL0515", "argument of write is not an attribute", Severity.ERROR
)
SIZE_IS_OF_NO_POINTER = Rule(
    "CDL0516", "size_is of something that is not a pointer", Severity.ERROR
)
SIZED_INITIALISER = Rule(
    "CDL0517", "initialiser that does not fit size_is", Severity.ERROR
)
UNSIZED_INITIALISER = Rule(
    "CDL0518", "list for a pointer without size_is", Severity.ERROR
)
SIZE_NOT_CONSTANT = Rule("CDL0519", "size_is that is not known", Severity.ERROR)
OPEN_ARRAY = Rule("CDL0520", "array without a size", Severity.ERROR)
NO_ENTRY = Rule("CDL0521", "celltype without an entry port", Severity.WARNING)
ALLOCATOR_FORM = Rule("CDL0522", "allocator of another form", Severity.ERROR)
ALLOCATOR_NAME = Rule("CDL0523", "unknown name in an allocator", Severity.ERROR)
ALLOCATOR_DIRECTION = Rule(
    "CDL0524", "allocator of a parameter that needs none", Severity.ERROR
)
ALLOCATOR_TWICE = Rule("CDL0525", "two allocators for one parameter", Severity.ERROR)
NOT_EXPORTED = Rule(
    "CDL0530", "port or attribute of a composite that is not connected", Severity.ERROR
)
NOT_DECLARED = Rule(
    "CDL0531", "exported name that the composite does not declare", Severity.ERROR
)
UNKNOWN_INNER_CELL = Rule("CDL0532", "inner cell not found", Severity.ERROR)
UNKNOWN_INNER_NAME = Rule(
    "CDL0533", "inner cell has no such port or attribute", Severity.ERROR
)
EXPORT_KIND = Rule("CDL0534", "exported as another kind", Severity.ERROR)
EXPORT_MISMATCH = Rule("CDL0535", "exported with another type", Severity.ERROR)
COMPOSITE_SINGLETON = Rule(
    "CDL0536", "composite of a singleton is not a singleton", Severity.ERROR
)
NO_SINGLETON_INSIDE = Rule(
    "CDL0537", "singleton without a singleton inside", Severity.WARNING
)
COMPOSITE_ACTIVE = Rule(
    "CDL0538", "composite and inner cells differ in active", Severity.ERROR
)
JOINED_AND_EXPORTED = Rule("CDL0539", "call port joined and exported", Severity.ERROR)
INNER_EXPRESSION = Rule(
    "CDL0540", "computed value of an inner attribute", Severity.ERROR
)
INNER_NAME = Rule(
    "CDL0541",
    "name of the inner cell where one of the composite is meant",
    Severity.ERROR,
)
OUTSIDE_COMPOSITE = Rule("CDL0542", "composite. outside of a composite", Severity.ERROR)
THROUGH_INSIDE = Rule("CDL0543", "through in a composite", Severity.ERROR)
SIZED_EXPORT = Rule("CDL0544", "size_is inside and outside a composite", Severity.ERROR)
NO_EFFECT_ON_COMPOSITE = Rule("CDL0545", "idx_is_id of a composite", Severity.WARNING)
ALLOCATOR_MISMATCH = Rule(
    "CDL0546", "another allocator inside than outside", Severity.ERROR
)
FACTORY_FORMAT = Rule("CDL0547", "format that does not fit its values", Severity.ERROR)

RULES = rules_of(globals())
