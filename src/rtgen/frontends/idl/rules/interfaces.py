"""Rules of interfaces, operations and valuetypes (IDL06xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

DUPLICATE_BASE = Rule(
    "IDL0600",
    "base named twice",
    Severity.ERROR,
    """
A declaration names each of its direct bases once.

```idl
// gives this finding
interface A {};
interface B : A, A {};
```
""",
)

ABSTRACT_BASE = Rule(
    "IDL0601",
    "abstract interface or valuetype with a concrete base",
    Severity.ERROR,
    """
An abstract interface inherits from abstract interfaces only, an abstract valuetype from abstract
valuetypes only.

```idl
// gives this finding
interface A {};
abstract interface B : A {};
```
""",
)

LOCAL_BASE = Rule(
    "IDL0602",
    "remote interface with a local base",
    Severity.ERROR,
    """
Only a local interface may inherit from a local one.

```idl
// gives this finding
local interface A {};
interface B : A {};
```
""",
)

REDEFINED = Rule(
    "IDL0603",
    "inherited operation or attribute declared again",
    Severity.ERROR,
    """
Operations and attributes that are inherited cannot be declared again, in whatever case. Types,
constants and exceptions can.

```idl
// gives this finding
interface A { void f(); };
interface B : A { void F(); };
```
""",
)

INHERITED_CLASH = Rule(
    "IDL0604",
    "two bases with one operation",
    Severity.ERROR,
    """
Two bases that do not inherit from each other declare an operation or attribute of the same name, so
the derived interface would have both.

```idl
// gives this finding
interface A { void f(); };
interface B { void f(); };
interface C : A, B {};
```
""",
)

NOT_RAISABLE = Rule(
    "IDL0605",
    "not an exception",
    Severity.ERROR,
    """
`raises`, `getraises` and `setraises` name exceptions.

```idl
// gives this finding
struct S { long a; };
interface I { void f() raises(S); };
```
""",
)

RAISED_TWICE = Rule(
    "IDL0606",
    "exception named twice",
    Severity.WARNING,
    """
An exception stands twice in one `raises`; once is enough.

```idl
// gives this finding
exception E {};
interface I { void f() raises(E, E); };
```
""",
)

ONEWAY = Rule(
    "IDL0607",
    "impossible oneway operation",
    Severity.ERROR,
    """
The caller of a `oneway` operation does not wait for an answer. So it returns void, has `in`
parameters only, and raises nothing.

```idl
// gives this finding
exception E {};
interface I { oneway long f(out long a) raises(E); };
```
""",
)

BAD_CONTEXT = Rule(
    "IDL0608",
    "malformed context name",
    Severity.ERROR,
    """
A context name begins with a letter, goes on with letters, digits, `.` and `_`, and may end with one
`*`.

```idl
// gives this finding
interface I { void f() context("1a"); };
```
""",
)

CONCRETE_BASES = Rule(
    "IDL0609",
    "concrete base in the wrong place",
    Severity.ERROR,
    """
A valuetype has at most one base that is not abstract, and supports at most one interface that is
not
abstract; each stands first in its list.

```idl
// gives this finding
valuetype A {};
valuetype B {};
valuetype C : A, B {};
```
""",
)

CUSTOM = Rule(
    "IDL0610",
    "custom valuetype in the wrong place",
    Severity.ERROR,
    """
A custom valuetype is not truncatable, and a valuetype that is not custom does not inherit from a
custom one.

```idl
// gives this finding
valuetype A {};
custom valuetype B : truncatable A {};
```
""",
)

ABSTRACT_STATE = Rule(
    "IDL0611",
    "state in an abstract valuetype",
    Severity.ERROR,
    """
An abstract valuetype has no state members and no factories.

```idl
// gives this finding
abstract valuetype A { public long a_; };
```
""",
)

BOXED_VALUE = Rule(
    "IDL0612",
    "boxed valuetype",
    Severity.ERROR,
    """
A value box holds a type that is no valuetype itself.

```idl
// gives this finding
valuetype A {};
valuetype B A;
```
""",
)

BAD_PARAMETER = Rule(
    "IDL0613",
    "impossible parameter of a factory",
    Severity.ERROR,
    """
Factories and finders take `in` parameters only.

```idl
// gives this finding
valuetype V { factory make(inout long a); };
```
""",
)

BAD_CLAUSE = Rule(
    "IDL0614",
    "exceptions of an attribute named the wrong way",
    Severity.ERROR,
    """
A readonly attribute names the exceptions of reading it behind `raises`. One that can be set names
those of reading behind `getraises`, those of setting behind `setraises`.

```idl
exception Unset {};
interface Lamp {
    readonly attribute float watts raises(Unset);
    attribute float level getraises(Unset) setraises(Unset);
    attribute float tint raises(Unset);      // of reading, or of setting?
};
```
""",
)

NOTHING_TO_TRUNCATE = Rule(
    "IDL0615",
    "truncatable without a concrete base",
    Severity.WARNING,
    """
Who does not know a truncatable valuetype reads it as its concrete base instead. With abstract
bases only there is none, and the word does nothing.

```idl
abstract valuetype A {};
valuetype B : truncatable A { public long x; };   // odd
valuetype B : A { public long x; };               // right
```
""",
)

RULES = (
    DUPLICATE_BASE,
    ABSTRACT_BASE,
    LOCAL_BASE,
    REDEFINED,
    INHERITED_CLASH,
    NOT_RAISABLE,
    RAISED_TWICE,
    ONEWAY,
    BAD_CONTEXT,
    CONCRETE_BASES,
    CUSTOM,
    ABSTRACT_STATE,
    BOXED_VALUE,
    BAD_PARAMETER,
    BAD_CLAUSE,
    NOTHING_TO_TRUNCATE,
)
