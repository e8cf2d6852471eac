"""Rules of types and declarations (CDL03xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_TYPE = Rule(
    "CDL0300",
    "unknown type",
    Severity.ERROR,
    """
A type must be declared, or imported from a C header, before it is used. Of C's types CDL has
`void`, `char`, `short`, `int`, `long` (with `signed` or `unsigned`) and those with sizes; `float`,
`double`, `bool`, `long long` and `union` are not among them. tecsgen: G1016.

```cdl
signature sMotor { ER set( [in] float speed ); };       // wrong
signature sMotor { ER set( [in] float32_t speed ); };   // right
```
""",
)

DECLARED_TWICE = Rule(
    "CDL0301",
    "name declared twice",
    Severity.ERROR,
    """
A name stands for one thing in its name space; struct tags have a name space of their own.
Name spaces and regions may be opened again. tecsgen: S2001.

```cdl
const int32_t LENGTH = 4;
signature LENGTH { ER get( void ); };   // wrong
```
""",
)

UNKNOWN_STRUCT = Rule(
    "CDL0302",
    "unknown struct",
    Severity.ERROR,
    """
A struct is used, by itself or behind a pointer, that is not declared before. Only a member of a
struct may point to one that comes later. tecsgen: T1022.

```cdl
signature sPose { ER put( [in] const struct tagPose *pose ); };   // wrong: the next line goes first
struct tagPose { float32_t x, y; };
```
""",
)

SIGN_OF_SIZED = Rule(
    "CDL0303",
    "sign of a type with a size",
    Severity.WARNING,
    """
`signed int8_t` and `unsigned int8_t` are an old way to write `int8_t` and `uint8_t`.
tecsgen: W2001, W2002.
""",
)

SIGN_TWICE = Rule(
    "CDL0304",
    "sign given twice",
    Severity.ERROR,
    """
The type says already whether it has a sign. tecsgen: T1008.

```cdl
const signed uint8_t N = 1;   // wrong
```
""",
)

ARRAY_SIZE = Rule(
    "CDL0305",
    "array size that is none",
    Severity.ERROR,
    """
The size of an array is a constant integer above zero.

```cdl
struct tagPose { float32_t w[0]; };   // wrong
struct tagPose { float32_t w[4]; };   // right
```
""",
)

VOID_VALUE = Rule(
    "CDL0306",
    "nothing can be of type void",
    Severity.ERROR,
    """
`void` stands for no value: it is the return type of a function, or what an unknown pointer leads
to. tecsgen: T1007, S2027.

```cdl
struct tagPose { void x; };    // wrong
struct tagPose { void *x; };   // right
```
""",
)

MEMBER_TWICE = Rule(
    "CDL0307",
    "member declared twice",
    Severity.ERROR,
    """
A struct has two members of one name. tecsgen: S2001.
""",
)

ENUM_TYPE = Rule(
    "CDL0308",
    "enum not usable in calls",
    Severity.WARNING,
    """
tecsgen reads enums, but enters neither tags nor values anywhere, and cannot make code for a
parameter or an attribute of such a type. Use an integer and constants.

```cdl
enum Gear { LOW, HIGH };
signature sGear { ER set( [in] enum Gear gear ); };   // tecsgen makes no code for it
```
""",
)

MEMBER_SIZE = Rule(
    "CDL0309",
    "size of a member that is no pointer",
    Severity.ERROR,
    """
`size_is`, `count_is` and `string` say how much a pointer leads to. tecsgen: T1003.

```cdl
struct tagNote { [string] char_t text[16]; };   // wrong
struct tagNote { [string] char_t *text; };      // right
```
""",
)

UNKNOWN_NAME = Rule(
    "CDL0310",
    "nothing of that name",
    Severity.ERROR,
    """
No name space of those around declares the name. A plain name is looked for from the current name
space outwards; `::a::b` begins at the top.
""",
)

WRONG_KIND = Rule(
    "CDL0311",
    "name of something else",
    Severity.ERROR,
    """
The name is known, but stands for a thing of another kind than what is wanted here.

```cdl
celltype tMotor { entry sMotor eMotor; };
celltype tWheel { call tMotor cMotor; };   // wrong: a port wants a signature
```
""",
)

GUESSED_TYPE = Rule(
    "CDL0312",
    "type of a missing file",
    Severity.WARNING,
    """
A C header or an imported file is missing, so a word where a type stands is taken for one of its
types. Nothing is known of it: rtgen can make nothing for a function that uses it.

```cdl
import_C( "board_types.h" );                            // not found
signature sMotor { void set( [in] BoardSpeed a ); };    // warned of
```
""",
)

RULES = (
    UNKNOWN_TYPE,
    DECLARED_TWICE,
    UNKNOWN_STRUCT,
    SIGN_OF_SIZED,
    SIGN_TWICE,
    ARRAY_SIZE,
    VOID_VALUE,
    MEMBER_TWICE,
    ENUM_TYPE,
    MEMBER_SIZE,
    UNKNOWN_NAME,
    WRONG_KIND,
    GUESSED_TYPE,
)
