"""The rules about Python types and CDR: what can be emitted, with the story behind each."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

_NOT_MARSHALLED = """\
The member has no codec in classic CDR here: it is optional, or its type is `any`, a valuetype, a
native type, a bitset, or a sequence of elements without content. Such a type may be a parameter
of an operation that is called within one process, but not a member of a struct, a union or an
exception:

```idl
struct Sample { any value; };     // PY0001 at `value`
```

Give the member a definite type, or a union of the types that are needed.
"""

_LONG_NAME = """\
Modules become folders, and their names parts of paths: at most 120 characters.
"""

NOT_MARSHALLED = Rule(
    "PY0001", "Type without a CDR codec", Severity.ERROR, _NOT_MARSHALLED
)
LONG_NAME = Rule("PY0002", "Name too long for a folder", Severity.ERROR, _LONG_NAME)

RULES = (NOT_MARSHALLED, LONG_NAME)
"""All of them, by code."""
