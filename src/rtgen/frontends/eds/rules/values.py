"""Rules of values and limits (EDS04xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

BAD_VALUE = Rule(
    "EDS0400",
    "value that its type does not have",
    Severity.WARNING,
    """
The text is no value of the data type: no number, no formula with `$NODEID`, no hexadecimal octets.
It is ignored.

```ini
[2000]
ParameterName=Speed
DataType=0x0005
AccessType=rw
DefaultValue=fast              ; gives this finding
```
""",
)

OCTAL = Rule(
    "EDS0401",
    "number that may be octal",
    Severity.WARNING,
    """
By CiA 306 a number with a leading 0 is octal, but hardly any tool writes octal numbers. It is taken
for a decimal number with zeros in front.

```ini
[2000]
DefaultValue=010               ; gives this finding: taken for 10, not for 8
```
""",
)

FORMULA = Rule(
    "EDS0402",
    "formula in another form",
    Severity.WARNING,
    """
A number that depends on the node-id is `$NODEID+number` (CiA 306, 4.6.3.2). Another order, other
case, spaces and further terms are understood, but not by all tools.

```ini
[1800sub1]
DefaultValue=0x180 + $NodeID   ; gives this finding
```
""",
)

OUT_OF_RANGE = Rule(
    "EDS0403",
    "value out of its type's range",
    Severity.WARNING,
    """
The data type cannot hold the value or limit. It is ignored.

```ini
[2000]
DataType=0x0005
DefaultValue=256               ; gives this finding: an UNSIGNED8 ends at 255
```
""",
)

OUTSIDE_LIMITS = Rule(
    "EDS0404",
    "value outside the limits",
    Severity.WARNING,
    """
The value is below `LowLimit` or above `HighLimit` of the same object.

```ini
[2000]
DataType=0x0005
LowLimit=1
DefaultValue=0                 ; gives this finding
```
""",
)

LIMITS_CROSSED = Rule(
    "EDS0405",
    "limits exchanged",
    Severity.WARNING,
    """
`LowLimit` is above `HighLimit`. Both are ignored.

```ini
[2000]
LowLimit=100
HighLimit=10                   ; gives this finding
```
""",
)

NO_LIMIT = Rule(
    "EDS0406",
    "limit for a type without order",
    Severity.WARNING,
    """
Strings, octets, domains and times have no limits. The limit is ignored.

```ini
[2000]
DataType=0x0009
HighLimit=10                   ; gives this finding
```
""",
)

ODD_NUMBER = Rule(
    "EDS0407",
    "number in an unusual form",
    Severity.WARNING,
    """
Numbers are decimal or start with `0x`; a REAL is a decimal number; octets are hexadecimal digits
without `0x`; a Boolean is `0` or `1`. Other forms whose meaning is clear are understood: `1A00h`,
`0.5f`, the bits of a REAL as a hexadecimal number, `0x0102` for octets, `true`.

```ini
[2000]
DataType=0x0008
DefaultValue=0.5f              ; gives this finding
```
""",
)

RULES = (
    BAD_VALUE,
    OCTAL,
    FORMULA,
    OUT_OF_RANGE,
    OUTSIDE_LIMITS,
    LIMITS_CROSSED,
    NO_LIMIT,
    ODD_NUMBER,
)
