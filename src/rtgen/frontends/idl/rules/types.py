"""Rules of types and unions (IDL03xx, IDL04xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

INCOMPLETE = Rule(
    "IDL0300",
    "type used before it is complete",
    Severity.ERROR,
    """
The type is declared in advance, or stands within its own definition, so its size is not known here.
Until it is complete only `sequence<T>` of it can be used, and only inside its own body:

```idl
struct Node;
typedef sequence<Node> Nodes;
struct Node { long id; Nodes children; };   // right
struct List { List next; };                 // wrong
```
""",
)

BAD_BASE = Rule(
    "IDL0301",
    "not a possible base",
    Severity.ERROR,
    """
A declaration inherits from declarations of its own kind only: interfaces from interfaces, structs
from structs, valuetypes from valuetypes, components from components.

```idl
// gives this finding
struct S { long a; };
interface I : S {};
```
""",
)

READ_ONLY = Rule(
    "IDL0302",
    "construct that is read only",
    Severity.WARNING,
    """
Template modules, port types, connectors, module aliases and annotation declarations are read, so
that
files that hold them can be used, but nothing is made of them.

```idl
// gives this finding
module M { struct S { long a; }; };
alias M N;
@annotation unit_of { string value; };
```
""",
)

LEFT_OUT = Rule(
    "IDL0309",
    "declaration that is left out",
    Severity.WARNING,
    """
The declaration, operation, attribute or port needs something of which nothing is made, such as a
type of a template module, so nothing is made of it either.

```idl
// gives this finding
module Lists<typename T> { typedef sequence<T> List; };
module Lists<long> Longs;
struct Row { Longs::List values; };
```
""",
)

VOID = Rule(
    "IDL0303",
    "void that is no return type",
    Severity.ERROR,
    """
`void` says that an operation returns nothing. It is no type for anything else.

```idl
// gives this finding
struct S { void a; };
```
""",
)

BAD_BOUND = Rule(
    "IDL0304",
    "bound or dimension that is not positive",
    Severity.ERROR,
    """
Bounds of strings, sequences and maps, and dimensions of arrays, are integers from 1 to 4294967295.

```idl
// gives this finding
typedef string<0> A;
typedef sequence<long, -1> B;
typedef long C[0];
```
""",
)

BAD_FIXED = Rule(
    "IDL0305",
    "impossible fixed-point type",
    Severity.ERROR,
    """
`fixed<digits,scale>` has 1 to 31 digits, of which 0 to `digits` stand behind the point. Only a
constant
may be plain `fixed`.

```idl
// gives this finding
typedef fixed<32, 2> A;
typedef fixed<3, 4> B;
```
""",
)

ANONYMOUS = Rule(
    "IDL0306",
    "anonymous type where a name is needed",
    Severity.ERROR,
    """
Sequences, maps, arrays, fixed-point types and declarations in place cannot be the type of a
parameter, a result or an attribute; declarations in place cannot be an element of a sequence or
map, either. Give the type a name:

```idl
typedef sequence<double> Angles;
interface Arm { void move(in Angles angles); };
```
""",
)

RECURSIVE_SEQUENCE = Rule(
    "IDL0307",
    "anonymous recursive sequence",
    Severity.WARNING,
    """
`sequence<S>` directly inside `S` is deprecated since CORBA 2.4. Declare the struct in advance and
give the sequence a name.

```idl
// gives this finding
struct S { sequence<S> a; };
```
""",
)

LOCAL_TYPE = Rule(
    "IDL0308",
    "local type in a remote interface",
    Severity.ERROR,
    """
A local interface, and what holds one, cannot leave its process, so an interface that is not local
cannot mention it in operations, attributes and `raises`.

```idl
// gives this finding
local interface L {};
struct S { L l_; };
interface I { void f(in S s_); };
```
""",
)

BAD_CONST_TYPE = Rule(
    "IDL0310",
    "type that no constant can have",
    Severity.ERROR,
    """
Constants are integers, octets, characters, strings, booleans, floating- or fixed-point numbers, or
enumerators, also through a typedef.

```idl
// gives this finding
struct S { long a; };
const S A = 1;
const any B = 1;
```
""",
)

BAD_MAP_KEY = Rule(
    "IDL0311",
    "impossible key of a map",
    Severity.ERROR,
    """
Keys of a map are integers, characters, booleans, enums or strings.

```idl
// gives this finding
typedef map<double, long> M;
```
""",
)

BAD_BITFIELD = Rule(
    "IDL0312",
    "impossible bit field",
    Severity.ERROR,
    """
A bit field has 1 to 64 bits, at most as many as its type (a boolean has 1), its type is an integer,
octet or boolean, and all fields of a bitset, inherited ones too, have at most 64 bits together.

```idl
// gives this finding
bitset B { bitfield<9, octet> a; };
```
""",
)

LONG_DOUBLE = Rule(
    "IDL0313",
    "long double in a constant",
    Severity.WARNING,
    """
The constant is kept with the precision of a double.

```idl
// gives this finding
const long double A = 1.0;
```
""",
)

TOO_DEEP = Rule(
    "IDL0314",
    "declarations that refer to each other too deep",
    Severity.ERROR,
    """
From a declaration to a type of its members, a base, an exception, and on from there, it is at most
100 steps. Declarations that hold each other through sequences count each.

```idl
struct S0 { long x; };
struct S1 { S0 inner; };
struct S2 { S1 inner; };   // and on to S101
```

Merge some of them, or leave out names that stand only for another name.
""",
)

BAD_SWITCH = Rule(
    "IDL0400",
    "impossible switch of a union",
    Severity.ERROR,
    """
A union switches on an integer, a character, an octet, a boolean or an enum.

```idl
union U switch (double) { case 1: long a; };    // wrong
union V switch (long) { case 1: long a; };      // right
```
""",
)

DUPLICATE_LABEL = Rule(
    "IDL0401",
    "label given twice",
    Severity.ERROR,
    """
Each value of the switch selects one branch, so no two labels of a union have one value.

```idl
// gives this finding
union U switch (long) { case 1: long a; case 2: case 1: long b; };
```
""",
)

SECOND_DEFAULT = Rule(
    "IDL0402",
    "second default",
    Severity.ERROR,
    """
A union has at most one `default` branch.

```idl
// gives this finding
union U switch (long) { default: long a; default: long b; };
```
""",
)

SUPERFLUOUS_DEFAULT = Rule(
    "IDL0403",
    "default that can never be chosen",
    Severity.ERROR,
    """
The labels name every value of the switch, so nothing is left for `default`.

```idl
// gives this finding
union U switch (boolean) { case TRUE: long a; case FALSE: long b; default: long c; };
```
""",
)

EMPTY_UNION = Rule(
    "IDL0404",
    "union without branches",
    Severity.ERROR,
    """
A union has at least one branch.

```idl
// gives this finding
union U switch (long) {};
```
""",
)

RULES = (
    INCOMPLETE,
    BAD_BASE,
    READ_ONLY,
    LEFT_OUT,
    VOID,
    BAD_BOUND,
    BAD_FIXED,
    ANONYMOUS,
    RECURSIVE_SEQUENCE,
    LOCAL_TYPE,
    BAD_CONST_TYPE,
    BAD_MAP_KEY,
    BAD_BITFIELD,
    LONG_DOUBLE,
    TOO_DEEP,
    BAD_SWITCH,
    DUPLICATE_LABEL,
    SECOND_DEFAULT,
    SUPERFLUOUS_DEFAULT,
    EMPTY_UNION,
)
