"""Rules of names and scopes (IDL02xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_NAME = Rule("IDL0200", "unknown name", Severity.ERROR)
WRONG_CASE = Rule("IDL0201", "name in the wrong case", Severity.ERROR)
REDECLARED = Rule("IDL0202", "name declared twice", Severity.ERROR)
CASE_CLASH = Rule("IDL0203", "names that differ in case only", Severity.ERROR)
INTRODUCED = Rule(
    "IDL0204", "name already used in this scope with another meaning", Severity.ERROR
)
SAME_AS_SCOPE = Rule("IDL0205", "name of the scope around it", Severity.ERROR)
KEYWORD_CASE = Rule("IDL0206", "name like a keyword", Severity.ERROR)
BAD_IDENTIFIER = Rule("IDL0207", "malformed identifier", Severity.ERROR)
CORBA_3_WORD = Rule("IDL0208", "keyword of CORBA 3 as a name", Severity.WARNING)
NOT_A_SCOPE = Rule("IDL0209", "not a scope", Severity.ERROR)
NOT_A_TYPE = Rule("IDL0210", "not a type", Severity.ERROR)
NOT_A_VALUE = Rule("IDL0211", "not a constant", Severity.ERROR)
AMBIGUOUS = Rule("IDL0212", "ambiguous inherited name", Severity.ERROR)
ENUM_SCOPE = Rule("IDL0213", "enumerator with the name of its enum", Severity.WARNING)
FORWARD_MISMATCH = Rule("IDL0214", "declarations that do not agree", Severity.ERROR)
NEVER_DEFINED = Rule("IDL0215", "declared, but never defined", Severity.ERROR)
NEVER_DEFINED_INTERFACE = Rule(
    "IDL0216", "interface declared, but never defined", Severity.WARNING
)
TWO_DEFINITIONS = Rule(
    "IDL0217", "two definitions of one name in a project", Severity.ERROR
)
DECLARED_ALIKE = Rule("IDL0218", "same type declared in two files", Severity.NOTE)
CONSTANT_AS_TYPE = Rule("IDL0219", "constant used as a type", Severity.WARNING)

RULES = rules_of(globals())
