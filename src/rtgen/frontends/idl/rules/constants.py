"""Rules of constant expressions (IDL05xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

WRONG_KIND = Rule(
    "IDL0500",
    "value of the wrong kind",
    Severity.ERROR,
    """
The type of a constant decides how its whole expression is evaluated; kinds are not mixed. Integers
come from integers, floating-point numbers from floating-point numbers, and so on; booleans,
characters, strings and enumerators have no operators.

```idl
const long   COUNT = 2.5;          // wrong
const string NAME  = "a" + "b";    // wrong: write "a" "b"
```
""",
)

OUT_OF_RANGE = Rule(
    "IDL0501",
    "value out of range",
    Severity.ERROR,
    """
The value does not fit its type, or a step of its calculation does not fit into 32 bits (64 bits
if the
type has 64). The message shows the value and the range.

```idl
// gives this finding
const short A = 40000;
const octet B = 256;
const long C = 2147483647 + 1;
const float D = 1e39;
const double E = 1e400;
typedef fixed<3, 1> F;
const F G = 123.4d;
```
""",
)

DIVISION_BY_ZERO = Rule(
    "IDL0502",
    "division by zero",
    Severity.ERROR,
    """
The right operand of `/` or `%` is zero.

```idl
// gives this finding
const long A = 1 / 0;
const double B = 1.0 / 0.0;
```
""",
)

BAD_SHIFT = Rule(
    "IDL0503",
    "impossible shift",
    Severity.ERROR,
    """
A number is shifted by 0 to 31 bits, or by 0 to 63 if the type has 64 bits.

```idl
// gives this finding
const long A = 1 << 32;
```
""",
)

PRECISION = Rule(
    "IDL0504",
    "fraction cut off",
    Severity.WARNING,
    """
A fixed-point value has more digits behind the point than its type; the rest is cut off.

```idl
// gives this finding
typedef fixed<4, 1> F;
const F A = 1.25d;
```
""",
)

TEXT_TOO_LONG = Rule(
    "IDL0505",
    "string longer than its bound",
    Severity.ERROR,
    """
The constant's type is a bounded string, and the value has more characters.

```idl
// gives this finding
typedef string<2> T; const T A = "abc";
```
""",
)

WRONG_ENUM = Rule(
    "IDL0506",
    "enumerator of another enum",
    Severity.ERROR,
    """
A constant or label of an enum is an enumerator of exactly that enum.

```idl
// gives this finding
enum E { A };
enum F { B };
union U switch (E) { case B: long a; };
```
""",
)

INTEGER_AS_FLOAT = Rule(
    "IDL0507",
    "integer where a floating-point number is wanted",
    Severity.WARNING,
    """
The integer is taken as a floating-point number, but other IDL compilers refuse it: write `1.0`.

```idl
// gives this finding
const double A = 1;
```
""",
)

NEGATIVE_REMAINDER = Rule(
    "IDL0508",
    "remainder of a negative number",
    Severity.WARNING,
    """
The remainder has the sign of the left operand here, as in C99; older compilers differ.

```idl
// gives this finding
const long A = -7 % 2;
```
""",
)

INFINITE = Rule(
    "IDL0509",
    "number so large that it is infinite",
    Severity.WARNING,
    """
A literal beyond the range of its type becomes infinite, as with other IDL compilers.

```idl
// gives this finding
const double A = 1e999;
```
""",
)

RULES = (
    WRONG_KIND,
    OUT_OF_RANGE,
    DIVISION_BY_ZERO,
    BAD_SHIFT,
    PRECISION,
    TEXT_TOO_LONG,
    WRONG_ENUM,
    INTEGER_AS_FLOAT,
    NEGATIVE_REMAINDER,
    INFINITE,
)
