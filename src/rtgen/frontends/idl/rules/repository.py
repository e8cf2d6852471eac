"""Rules of repository ids (IDL07xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

BAD_PRAGMA = Rule(
    "IDL0700",
    "malformed pragma",
    Severity.ERROR,
    """
The pragmas of CORBA have these forms:

```idl
#pragma prefix "omg.org"
#pragma ID Motor "IDL:omg.org/Motor:1.0"
#pragma version Motor 2.1
```

Other pragmas are for other tools and are never an error.
""",
)

NO_ID = Rule(
    "IDL0701",
    "no repository id",
    Severity.ERROR,
    """
Members, branches, enumerators, parameters and ports have no repository id that could be set.

```idl
// gives this finding
struct S { long a; };
#pragma ID S::a "IDL:a:1.0"
```
""",
)

ODD_ID = Rule(
    "IDL0702",
    "unusual repository id",
    Severity.WARNING,
    """
A repository id begins with its format: `IDL:path/name:1.0`, `DCE:...`, `RMI:...`. The id is kept as
it is.

```idl
// gives this finding
struct S { long a; };
#pragma ID S "foo"
```
""",
)

CONFLICT = Rule(
    "IDL0703",
    "repository id set twice",
    Severity.ERROR,
    """
A declaration has one repository id. A second `#pragma ID`, `#pragma version` or `typeid` may only
repeat it.

```idl
// gives this finding
struct S { long a; };
#pragma ID S "IDL:a:1.0"
#pragma ID S "IDL:b:1.0"
```
""",
)

SAME_ID = Rule(
    "IDL0704",
    "one repository id for two declarations",
    Severity.WARNING,
    """
Repository ids tell types apart on the wire, so no two declarations share one.

```idl
// gives this finding
struct S { long a; }; struct T { long a; };
#pragma ID T "IDL:S:1.0"
```
""",
)

UNKNOWN_PRAGMA = Rule(
    "IDL0705",
    "unknown pragma",
    Severity.NOTE,
    """
The pragma is none of CORBA's. It may be for another tool, or misspelt.

```idl
// gives this finding
#pragma perfix "omg.org"
```
""",
)

RULES = (BAD_PRAGMA, NO_ID, ODD_ID, CONFLICT, SAME_ID, UNKNOWN_PRAGMA)
