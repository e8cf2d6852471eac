"""The rules about Python types and CDR: what can be emitted, with the story behind each."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

_NOT_MARSHALLED = """\
The member has no codec in CDR. Its type is, or holds,

- a native type, a component, a home: they have no form outside of the process;
- a local interface: its objects do not leave the process;
- a custom valuetype: only its user's own code knows how its state is marshalled;
- a sequence of elements that take no octets: nothing would bound its length when it is read;
- an optional member (`@optional`) together with `any`, `CORBA::TypeCode`, a value or an abstract
  interface: the former belongs to the CDR of DDS, the latter to that of CORBA.

Such a type may be a parameter of an operation that is called within one process, but not a member
of a struct, a union, an exception or a value:

```idl
native Handle;
struct Sample { Handle at; };     // PY0001 at `at`
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
