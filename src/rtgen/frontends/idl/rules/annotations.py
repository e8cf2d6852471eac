"""Rules of annotations and components (IDL08xx, IDL09xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_ANNOTATION = Rule(
    "IDL0800",
    "unknown annotation",
    Severity.WARNING,
    """
The annotation is none of IDL 4.2's or of rtgen's. It is kept, but nothing depends on it.

```idl
// gives this finding
@kee struct S { long a; };
```
""",
)

MISPLACED = Rule(
    "IDL0801",
    "annotation in the wrong place",
    Severity.WARNING,
    """
The annotation means nothing for what it is put on: `@key` and `@optional` belong to members,
`@rtc` to
components, `@unit` to members, ports and parameters, and so on.

```idl
// gives this finding
@key struct S { long a; };
```
""",
)

BAD_ARGUMENT = Rule(
    "IDL0802",
    "wrong argument of an annotation",
    Severity.ERROR,
    """
The annotation has no argument of that name, lacks one, or takes another kind of value.

```idl
@rtc(kind="DataFlowComponent", category="Navigation", rate=1000.0)
component RefHardRh3 { };
```
""",
)

KEY_OPTIONAL = Rule(
    "IDL0803",
    "optional key",
    Severity.ERROR,
    """
A member marked `@key` identifies the object, so it cannot be `@optional`.

```idl
// gives this finding
struct S { @key @optional long a; };
```
""",
)

DUPLICATE_ID = Rule(
    "IDL0804",
    "member id given twice",
    Severity.ERROR,
    """
Each id is unique in a struct, its bases included, or in a union. A member without an id has the one
after that of the member before it:

```idl
struct S {
    @id(2) long a;
    @id(1) long b;
    long c;             // has the id 2, too
};
```
""",
)

BAD_BIT_BOUND = Rule(
    "IDL0805",
    "impossible @bit_bound or @position",
    Severity.ERROR,
    """
`@bit_bound` is 1 to 32 for an enum and 1 to 64 for a bitmask; positions are below the bound, and
each
is given once.

```idl
// gives this finding
@bit_bound(65) bitmask M { A };
```
""",
)

BAD_ENUM_VALUE = Rule(
    "IDL0806",
    "impossible value of an enumerator",
    Severity.ERROR,
    """
Values given by `@value` grow from enumerator to enumerator, and fit into the bits of the enum: 32,
or what `@bit_bound` says. An enum with negative values has one bit less for the others.

```idl
// gives this finding
enum E { @value(3) A, @value(3) B };
```
""",
)

EXTENSIBILITY = Rule(
    "IDL0807",
    "conflicting extensibility",
    Severity.ERROR,
    """
A type is final, appendable or mutable; only one of them.

```idl
// gives this finding
@final @mutable struct S { long a; };
```
""",
)

DEFAULT_RANGE = Rule(
    "IDL0808",
    "default or range that does not fit",
    Severity.ERROR,
    """
`@default` lies between `@min` and `@max`, and `@min` is not larger than `@max`.

```idl
// gives this finding
component C { @default(5) @min(6) attribute long a; };
```
""",
)

REPEATED = Rule(
    "IDL0809",
    "annotation given twice",
    Severity.ERROR,
    """
An annotation stands once before what it belongs to (only `@verbatim` may be repeated), and
`@default_literal` once in an enum.

```idl
// gives this finding
enum Mode { @default_literal IDLE, @default_literal AUTO };
```
""",
)

BAD_PORT_TYPE = Rule(
    "IDL0900",
    "impossible type of a port",
    Severity.ERROR,
    """
`consumes`, `publishes` and `emits` take a struct or union (or eventtype); `provides` and `uses`
take
an interface.

```idl
// gives this finding
struct Pose { double x; };
component Follower {
    consumes long number;
    publishes sequence<Pose> poses;
    provides Pose control;
};
```
""",
)

DUPLICATE_PORT = Rule(
    "IDL0901",
    "port declared twice",
    Severity.ERROR,
    """
A component has at most one data port of each name and direction, and each parameter once. An
InPort and an OutPort may share a name. In a service port, each interface instance has its own name.

```idl
// gives this finding
struct S { long a; };
component C { consumes S x; consumes S x; };
```
""",
)

BAD_PARAMETER_TYPE = Rule(
    "IDL0902",
    "impossible type of a configuration parameter",
    Severity.ERROR,
    """
A configuration parameter travels as text, so it is a number, a boolean, a string, an enum, or a
sequence or array of these.

```idl
// gives this finding
component C { attribute any a; };
```
""",
)

BAD_NAME = Rule(
    "IDL0903",
    "impossible outside name",
    Severity.ERROR,
    """
The name given by `@name`, `@port` or `@instance` is not empty and holds no control characters.

```idl
// gives this finding
struct S { long a; };
component C { @name("") consumes S x; };
```
""",
)

BAD_DATE = Rule(
    "IDL0904",
    "malformed date",
    Severity.ERROR,
    """
`created` and `updated` are dates of XML Schema with a time zone: `2011-09-26T10:00:00+09:00`.

```idl
// gives this finding
@rtc(created="today") component C {};
```
""",
)

PASSED_OVER = Rule(
    "IDL0905",
    "construct of components that is read only",
    Severity.WARNING,
    """
Homes, `multiple`, `port`, `mirrorport`, `primarykey` and read-only attributes of components are
read, so that files that hold them can be used, but nothing is made of them.

```idl
// gives this finding
interface I {};
component C { uses multiple I many; };
```
""",
)

RULES = (
    UNKNOWN_ANNOTATION,
    MISPLACED,
    BAD_ARGUMENT,
    KEY_OPTIONAL,
    DUPLICATE_ID,
    BAD_BIT_BOUND,
    BAD_ENUM_VALUE,
    EXTENSIBILITY,
    DEFAULT_RANGE,
    REPEATED,
    BAD_PORT_TYPE,
    DUPLICATE_PORT,
    BAD_PARAMETER_TYPE,
    BAD_NAME,
    BAD_DATE,
    PASSED_OVER,
)
