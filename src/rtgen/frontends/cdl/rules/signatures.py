"""Rules of signatures: functions and their parameters (CDL04xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

CONTEXT_UNKNOWN = Rule(
    "CDL0400",
    "unknown context",
    Severity.WARNING,
    """
`context` says where the functions are called: `task` (the default), `non-task` or `any`. tecsgen:
W1001.

```cdl
[context( "interrupt" )] signature sMotor { ER stop( void ); };   // warned of
[context( "non-task" )] signature sMotor { ER stop( void ); };    // right
```
""",
)

SPECIFIER_TWICE = Rule(
    "CDL0401",
    "specifier given twice",
    Severity.ERROR,
    """
`context`, `oneway`, `size_is`, `count_is` and `string` stand once in a bracket. tecsgen: S1001,
S2011, S2012, S2013, G1016.

```cdl
ER put( [in,size_is(2),size_is(3)] const int8_t *p );   // wrong
```
""",
)

NOT_A_FUNCTION = Rule(
    "CDL0402",
    "not a function",
    Severity.ERROR,
    """
A signature holds functions only. tecsgen: G1010, G1011.

```cdl
signature sMotor { int32_t speed; };           // wrong
signature sMotor { int32_t speed( void ); };   // right
```
""",
)

FUNCTION_TWICE = Rule(
    "CDL0403",
    "function declared twice",
    Severity.ERROR,
    """
The functions of a signature have names of their own; there is no overloading. tecsgen: S2001.

```cdl
signature sMotor { ER set( void ); ER set( [in] int8_t a ); };   // wrong
```
""",
)

NO_VOID = Rule(
    "CDL0404",
    "function without void",
    Severity.WARNING,
    """
A function without parameters says so. tecsgen: W5010.

```cdl
ER stop();         // warned of
ER stop( void );   // right
```
""",
)

RETURNS_POINTER = Rule(
    "CDL0405",
    "function returns a pointer",
    Severity.WARNING,
    """
A pointer leads nowhere in another memory. `[deviate]` before the signature silences this.
tecsgen: W3004.

```cdl
signature sMotor { char_t *name( void ); };   // warned of
```
""",
)

NO_BRACKET = Rule(
    "CDL0406",
    "parameter without specifiers",
    Severity.ERROR,
    """
Each parameter says in brackets which way it goes. tecsgen: G1001.

```cdl
ER set( int32_t speed );        // wrong
ER set( [in] int32_t speed );   // right
```
""",
)

NO_NAME = Rule(
    "CDL0407",
    "parameter without a name",
    Severity.ERROR,
    """
Each parameter has a name. Only `(void)` stands for none. tecsgen: G1002, G1003.

```cdl
ER set( [in] int32_t );         // wrong
ER set( [in] int32_t speed );   // right
```
""",
)

NO_DIRECTION = Rule(
    "CDL0408",
    "parameter without a direction",
    Severity.ERROR,
    """
One of `in`, `out`, `inout`, `send` and `receive` says which way a parameter goes. tecsgen: S2014.

```cdl
ER put( [string] const char_t *text );      // wrong
ER put( [in,string] const char_t *text );   // right
```
""",
)

DIRECTION_CONFLICT = Rule(
    "CDL0409",
    "two directions",
    Severity.ERROR,
    """
A parameter has one direction; `inout` goes both ways. tecsgen: S2008.

```cdl
ER move( [in,out] int32_t *x );   // wrong
ER move( [inout] int32_t *x );    // right
```
""",
)

DIRECTION_TWICE = Rule(
    "CDL0410",
    "direction given twice",
    Severity.WARNING,
    """
The direction stands twice in the bracket. tecsgen: W3001.

```cdl
ER set( [in,in] int32_t speed );   // warned of
```
""",
)

ALLOCATOR = Rule(
    "CDL0411",
    "no allocator signature",
    Severity.ERROR,
    """
`send` and `receive` name the signature of the allocator, which is declared before. tecsgen:
S2009.

```cdl
signature sAlloc { ER alloc( [in] int32_t n, [out] void **p ); ER free( [in] const void *p ); };
signature sGive { ER give( [send(sAlloc)] int8_t *p ); };   // right
```
""",
)

STRING_LENGTH = Rule(
    "CDL0412",
    "string without a length",
    Severity.WARNING,
    """
The caller's memory for an `out` or `inout` string has a size: `string(n)`. Real devices cannot be
built without it. tecsgen: W3002.

```cdl
ER name( [out,string] char_t *name );       // warned of
ER name( [out,string(16)] char_t *name );   // right
```
""",
)

TOO_FEW_POINTERS = Rule(
    "CDL0413",
    "parameter is no pointer",
    Severity.ERROR,
    """
Whatever goes outward, has a size or is a string needs a pointer; `receive` one more, and `string`
with `size_is` or `count_is` two. tecsgen: S2014.

```cdl
ER get( [out] int32_t speed );    // wrong
ER get( [out] int32_t *speed );   // right
```
""",
)

TOO_MANY_POINTERS = Rule(
    "CDL0414",
    "pointer to a pointer",
    Severity.WARNING,
    """
More levels of pointers than the specifiers speak of: the inner ones lead nowhere in another
memory. tecsgen: W3003.

```cdl
ER get( [out] int32_t **speed );   // warned of
ER get( [out] int32_t *speed );    // right
```
""",
)

IN_NOT_CONST = Rule(
    "CDL0415",
    "in pointer whose target is not const",
    Severity.ERROR,
    """
The callee must not change what an `in` pointer leads to. tecsgen: S2015.

```cdl
ER put( [in,string] char_t *text );         // wrong
ER put( [in,string] const char_t *text );   // right
```
""",
)

OUT_CONST = Rule(
    "CDL0416",
    "const where something is written",
    Severity.ERROR,
    """
What goes outward, or changes its owner, is not constant. tecsgen: S2016.

```cdl
ER get( [out] const int32_t *speed );   // wrong
ER get( [out] int32_t *speed );         // right
```
""",
)

SIZE_OF_SCALAR = Rule(
    "CDL0417",
    "size of something that is no pointer",
    Severity.ERROR,
    """
`size_is`, `count_is`, `string` and `nullable` are about pointers. tecsgen: T1003.

```cdl
ER put( [in,string] char_t text );          // wrong
ER put( [in,string] const char_t *text );   // right
```
""",
)

SIZE_OF_VOID = Rule(
    "CDL0418",
    "size of a void pointer",
    Severity.ERROR,
    """
The size of what a `void *` leads to is unknown, so it can be neither an array nor a string.
tecsgen: T1040.

```cdl
ER put( [in,size_is(n)] const void *data, [in] int32_t n );      // wrong
ER put( [in,size_is(n)] const uint8_t *data, [in] int32_t n );   // right
```
""",
)

NULLABLE_SIZE = Rule(
    "CDL0419",
    "array that may be NULL",
    Severity.ERROR,
    """
A NULL array has size 0; `nullable` does not go with `size_is`. tecsgen: T9999.

```cdl
ER put( [in,size_is(n),nullable] const int8_t *p, [in] int32_t n );   // wrong
```
""",
)

SIZE_TYPE = Rule(
    "CDL0420",
    "size that is no integer",
    Severity.ERROR,
    """
The argument of `size_is`, `count_is` and `string` is an integer. A pointer to one is written with
its star. tecsgen: S2017, S2020, S2023.

```cdl
ER get( [out,size_is(*n)] int8_t *p, [inout] int32_t *n );   // right
ER get( [out,size_is(n)] int8_t *p, [inout] int32_t *n );    // wrong
```
""",
)

SIZE_SIGN = Rule(
    "CDL0421",
    "size that is not positive",
    Severity.ERROR,
    """
A constant size is above zero. tecsgen: S2018, S2019, S2021, S2022, S2024, S2025.

```cdl
ER put( [in,size_is(0)] const int8_t *p );   // wrong
```
""",
)

MAX_SIZE = Rule(
    "CDL0422",
    "limit that is none",
    Severity.ERROR,
    """
The second argument of `size_is` is a constant above zero. tecsgen: S2028, S2029.

```cdl
ER put( [in,size_is(n,m)] const int8_t *p, [in] int32_t n, [in] int32_t m );   // wrong
ER put( [in,size_is(n,16)] const int8_t *p, [in] int32_t n );                  // right
```
""",
)

SIZE_OVER_MAX = Rule(
    "CDL0423",
    "size above its limit",
    Severity.ERROR,
    """
The first argument of `size_is` is a constant and not smaller than the second. tecsgen: S2030.

```cdl
ER put( [in,size_is(8,4)] const int8_t *p );   // wrong
```
""",
)

SIZE_UNDER_MAX = Rule(
    "CDL0424",
    "limit without effect",
    Severity.WARNING,
    """
The first argument of `size_is` is a constant, so the second says nothing. tecsgen: W3005.

```cdl
ER put( [in,size_is(4,8)] const int8_t *p );   // warned of
```
""",
)

LENGTH_DIRECTION = Rule(
    "CDL0425",
    "length that goes the other way",
    Severity.ERROR,
    """
The length of an array or string must be known where it is needed: in a request for `size_is` and
`string` of `in`, `out`, `inout` and `send`, and for `count_is` of `in`, `inout` and `send`; in a
reply for `count_is` of `out`, `inout` and `receive`, and for all of `receive`. tecsgen: E1015.

```cdl
ER put( [in,size_is(n)] const int8_t *p, [out] int32_t n );   // wrong
ER put( [in,size_is(n)] const int8_t *p, [in] int32_t n );    // right
```
""",
)

ONEWAY_RETURN = Rule(
    "CDL0426",
    "oneway function that returns something",
    Severity.ERROR,
    """
Nobody waits for a oneway function: it returns `void` or `ER`. tecsgen: T1029.

```cdl
[oneway] int32_t stop( void );   // wrong
[oneway] void stop( void );      // right
```
""",
)

ONEWAY_PARAMETER = Rule(
    "CDL0427",
    "oneway function with an outward parameter",
    Severity.ERROR,
    """
Nobody waits for a oneway function: its parameters are `in` or `send`. tecsgen: T1030.

```cdl
[oneway] void get( [out] int32_t *x );   // wrong
```
""",
)

PARAMETER_TWICE = Rule(
    "CDL0428",
    "parameter declared twice",
    Severity.ERROR,
    """
The parameters of a function have names of their own. tecsgen: S2001.

```cdl
ER put( [in] int8_t a, [in] int8_t a );   // wrong
```
""",
)

FUNCTION_PARAMETER = Rule(
    "CDL0429",
    "parameter that is a function",
    Severity.ERROR,
    """
A function cannot be handed over; a pointer to it can, though not to another memory. tecsgen: S2006.

```cdl
ER watch( [in] void notify( void ) );   // wrong
```
""",
)

SIZE_FORM = Rule(
    "CDL0430",
    "size that tecsgen does not understand",
    Severity.WARNING,
    """
tecsgen takes the type of the first operand of a size for the type of the whole, and does not know
that of a number, of parentheses, of a shift or a comparison, or of a member of a struct. The codec
made here works; the board's half cannot be made. tecsgen: S2017, S2020, S2023, E1004, E1005, E1014.

```cdl
ER put( [in,size_is(n * 2)] const int8_t *p, [in] int32_t n );   // right
ER put( [in,size_is(2 * n)] const int8_t *p, [in] int32_t n );   // tecsgen refuses it
```
""",
)

RULES = (
    CONTEXT_UNKNOWN,
    SPECIFIER_TWICE,
    NOT_A_FUNCTION,
    FUNCTION_TWICE,
    NO_VOID,
    RETURNS_POINTER,
    NO_BRACKET,
    NO_NAME,
    NO_DIRECTION,
    DIRECTION_CONFLICT,
    DIRECTION_TWICE,
    ALLOCATOR,
    STRING_LENGTH,
    TOO_FEW_POINTERS,
    TOO_MANY_POINTERS,
    IN_NOT_CONST,
    OUT_CONST,
    SIZE_OF_SCALAR,
    SIZE_OF_VOID,
    NULLABLE_SIZE,
    SIZE_TYPE,
    SIZE_SIGN,
    MAX_SIZE,
    SIZE_OVER_MAX,
    SIZE_UNDER_MAX,
    LENGTH_DIRECTION,
    ONEWAY_RETURN,
    ONEWAY_PARAMETER,
    PARAMETER_TWICE,
    FUNCTION_PARAMETER,
    SIZE_FORM,
)
