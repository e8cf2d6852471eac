"""Rules of constants, expressions and initialisers (CDL08xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NO_INITIALISER = Rule(
    "CDL0800",
    "constant without a value",
    Severity.ERROR,
    """
A constant needs an initialiser. tecsgen: S1097.

```cdl
const int32_t LENGTH;        // wrong
const int32_t LENGTH = 16;   // right
```
""",
)

CONSTANT_TYPE = Rule(
    "CDL0801",
    "type that a constant cannot have",
    Severity.ERROR,
    """
Constants are integers, floating-point numbers, truth values or pointers. tecsgen: S1096.
""",
)

NOT_CONST = Rule(
    "CDL0802",
    "declaration outside celltypes that is not const",
    Severity.ERROR,
    """
What is declared at the top or in a name space is constant, and says so; a pointer has its `const`
behind the star. tecsgen: S1095, S1094.

```cdl
int32_t LENGTH = 16;                 // wrong
const char_t *NAME = "beego";        // wrong: the pointer could change
const int32_t LENGTH = 16;           // right
const char_t *const NAME = "beego";  // right
```
""",
)

NOT_CONSTANT = Rule(
    "CDL0803",
    "value that is not constant",
    Severity.ERROR,
    """
The value must be known when the file is read. tecsgen: T1010 and others.
""",
)

UNKNOWN_NAME = Rule(
    "CDL0804",
    "unknown name in an expression",
    Severity.ERROR,
    """
An expression may use constants that are declared before it; in `size_is` and the like also the
other parameters of the function or members of the struct, and in a celltype its attributes.
Macros of C headers are not known. tecsgen: E1001.

```cdl
ER put( [in,size_is(lenght)] const uint8_t *data, [in] int32_t length );   // wrong
ER put( [in,size_is(length)] const uint8_t *data, [in] int32_t length );   // right
```
""",
)

CANNOT_EVALUATE = Rule(
    "CDL0805",
    "operator that cannot be evaluated here",
    Severity.ERROR,
    """
Subscripts, members and addresses have no value before the program runs. tecsgen: E1004 to E1010.

```cdl
const int32_t N = &LENGTH;   // wrong
```
""",
)

OPERATOR_KIND = Rule(
    "CDL0806",
    "operator does not fit its operands",
    Severity.ERROR,
    """
Integers, floating-point numbers, truth values, strings and pointers do not mix freely: `%`, shifts
and bit operators want integers, `&&`, `||` and `!` integers or truth values, and a truth value is
compared with a truth value only. A cast may help. tecsgen: V1001 to V1025.

```cdl
const int32_t N = 1.5 << 2;            // wrong
const int32_t N = (int32_t)1.5 << 2;   // right
```
""",
)

DIVISION = Rule(
    "CDL0807",
    "division by zero",
    Severity.ERROR,
    """
The right side of `/` or `%` is zero. tecsgen: V1009 to V1012, V1017, V1018.
""",
)

RANGE = Rule(
    "CDL0808",
    "value out of range",
    Severity.ERROR,
    """
The value does not fit the type. tecsgen: T1013 to T1016.

```cdl
const uint8_t N = 256;   // wrong: 0 to 255
```
""",
)

NEEDS_CAST = Rule(
    "CDL0809",
    "floating-point number for an integer",
    Severity.ERROR,
    """
A floating-point value needs a cast to become an integer. tecsgen: T1011.

```cdl
const int32_t N = 1.5;            // wrong
const int32_t N = (int32_t)1.5;   // right
```
""",
)

SHAPE = Rule(
    "CDL0810",
    "initialiser of another shape",
    Severity.ERROR,
    """
Arrays and structs take `{ ... }`, scalars a single value, `void` none. tecsgen: T1007, T1017,
T1020, T1024, T1031.

```cdl
attr { int32_t gain = { 1, 2 }; };      // wrong
attr { int32_t gain[2] = { 1, 2 }; };   // right
```
""",
)

POINTER_VALUE = Rule(
    "CDL0811",
    "value that a pointer cannot have",
    Severity.ERROR,
    """
A pointer takes a string (if it leads to characters), a number by a cast to its very type, or
`C_EXP`. tecsgen: T1032 to T1036.

```cdl
const int32_t *const P = "beego";    // wrong
const char_t *const NAME = "beego";  // right
```
""",
)

SURPLUS = Rule(
    "CDL0812",
    "more values than a struct has members",
    Severity.WARNING,
    """
The values behind the last member are left out; tecsgen does not look at them.

```cdl
struct Point { int32_t x; int32_t y; };
attr { struct Point origin = { 0, 0, 0 }; };   // the third value is for nothing
```
""",
)

RULES = (
    NO_INITIALISER,
    CONSTANT_TYPE,
    NOT_CONST,
    NOT_CONSTANT,
    UNKNOWN_NAME,
    CANNOT_EVALUATE,
    OPERATOR_KIND,
    DIVISION,
    RANGE,
    NEEDS_CAST,
    SHAPE,
    POINTER_VALUE,
    SURPLUS,
)
