"""The rules of Python types and CDR: restrictions on what can be emitted."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

_NOT_MARSHALLED = """\
The member has no codec in CDR. Its type is, or holds,

- a native type, a component, a home: they have no form outside of the process;
- a local interface: its objects do not leave the process;
- a custom valuetype: only its user's own code knows how its state is marshalled;
- a sequence of elements that take no octets: nothing would bound its length when it is read;
- sequences nested in each other more than 12 deep, with no struct or union between;
- an optional member (`@optional`) or a mutable type (`@mutable`) together with `any`,
  `CORBA::TypeCode`, a value or an abstract interface: the former belongs to the CDR of DDS, the
  latter to that of CORBA.

Such a type may be a parameter of an operation that is called within one process, but not a member
of a struct, a union, an exception or a value:

```idl
native Handle;
struct Sample { Handle at; };     // PY0001 at `at`
```

Give the member a definite type, or a union of the types that are needed.
"""

_NOT_IN_XCDR = """\
The struct or union is represented as XCDR, since `@data_representation(XCDR2)` or the setting
`representation` says so, or since it is mutable or has optional members, or a type in it. The types
of DDS have no `any`, no `fixed`, no object references and no valuetypes:

```idl
@data_representation(XCDR2)
struct Price { fixed<8,2> amount; };     // PY0003 at `amount`
```

Give the member a type that DDS has, or the struct `@data_representation(XCDR)` for classic CDR.
"""

_LONG_NAME = """\
Modules become folders, and their names parts of paths: at most 120 characters.
"""

NOT_MARSHALLED = Rule(
    "PY0001", "Type without a CDR codec", Severity.ERROR, _NOT_MARSHALLED
)
NOT_IN_XCDR = Rule("PY0003", "Type unknown to DDS", Severity.ERROR, _NOT_IN_XCDR)
LONG_NAME = Rule("PY0002", "Name too long for a folder", Severity.ERROR, _LONG_NAME)

RULES = (NOT_MARSHALLED, LONG_NAME, NOT_IN_XCDR)
"""All rules, by code."""
