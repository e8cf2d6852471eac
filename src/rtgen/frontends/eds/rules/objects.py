"""Rules of objects and sub-objects (EDS03xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NO_NAME = Rule(
    "EDS0300",
    "object without a name",
    Severity.WARNING,
    """
`ParameterName` is missing or empty. A name is made of the index.

```ini
[2000]                         ; gives this finding
DataType=0x0005
AccessType=rw
```
""",
)

OBJECT_TYPE = Rule(
    "EDS0301",
    "object type taken from the other keys",
    Severity.WARNING,
    """
`ObjectType` is missing where it is no VAR, is none of CiA 301's, or does not agree with the other
keys. An object with sub-objects and without a data type is taken for a RECORD, one with
a data type for a VAR.

```ini
[2000]
ParameterName=Speeds
ObjectType=0x7                 ; gives this finding: a VAR has no sub-objects
SubNumber=2
```
""",
)

WORDS = Rule(
    "EDS0302",
    "type in words",
    Severity.WARNING,
    """
`ObjectType` and `DataType` are numbers. The name of a type is taken for its number.

```ini
[2000]
ParameterName=Speed
ObjectType=VAR                 ; gives this finding
DataType=UNSIGNED8             ; so does this
AccessType=rw
```
""",
)

TYPE_TAKEN = Rule(
    "EDS0303",
    "data type missing, but clear",
    Severity.WARNING,
    """
`DataType` is missing or is no number. It is clear for sub-index 0 (UNSIGNED8), for the
communication objects of CiA 301, for members of an ARRAY whose other members have one, and for a
DOMAIN.

```ini
[1018sub0]                     ; gives this finding
ParameterName=Number of entries
AccessType=ro
```
""",
)

NO_TYPE = Rule(
    "EDS0304",
    "data type missing",
    Severity.ERROR,
    """
`DataType` is missing or is no number, and nothing else tells it. Look it up in the device's manual.

```ini
[2000]                         ; gives this finding
ParameterName=Speed
AccessType=rw
```
""",
)

UNKNOWN_TYPE = Rule(
    "EDS0305",
    "unknown data type",
    Severity.WARNING,
    """
The code is none of CiA 301's basic types, and no section defines it as a range of one. Values of it
are raw octets, and no PDO can carry them.

```ini
[2000]
ParameterName=Speed
DataType=0x0040                ; gives this finding
AccessType=rw
```
""",
)

NO_ACCESS = Rule(
    "EDS0306",
    "access type missing",
    Severity.WARNING,
    """
`AccessType` is missing. The object is taken for one that can only be read.

```ini
[2000]                         ; gives this finding
ParameterName=Speed
DataType=0x0005
```
""",
)

UNKNOWN_ACCESS = Rule(
    "EDS0307",
    "unknown access type",
    Severity.WARNING,
    """
The access types are `ro`, `wo`, `rw`, `rwr`, `rww` and `const`. `r`, `w`, `wr` and the like are
understood; any other word is taken for `ro`.

```ini
[2000]
ParameterName=Speed
DataType=0x0005
AccessType=R                   ; gives this finding
```
""",
)

ORPHAN = Rule(
    "EDS0308",
    "sub-object without its object",
    Severity.WARNING,
    """
There is a section for a sub-object, but none for the object itself. A RECORD is assumed.

```ini
[2002sub1]                     ; gives this finding if there is no [2002]
ParameterName=Speed
DataType=0x0005
AccessType=rw
```
""",
)

OF_A_VAR = Rule(
    "EDS0309",
    "sub-object of a variable",
    Severity.WARNING,
    """
An object of type VAR or DOMAIN has no sub-objects. The sub-object is passed over.

```ini
[2000]
ParameterName=Speed
ObjectType=0x7
DataType=0x0005
AccessType=rw
[2000sub1]                     ; gives this finding
ParameterName=Left
```
""",
)

SUB_NUMBER = Rule(
    "EDS0310",
    "wrong number of sub-objects",
    Severity.WARNING,
    """
`SubNumber` tells how many sub-objects are described, sub-index 0 included. All that are
described are read.

```ini
[2001]
ParameterName=Speeds
ObjectType=0x8
SubNumber=5                    ; gives this finding if there are sub0 to sub2
```
""",
)

NO_SUBS = Rule(
    "EDS0311",
    "object without sub-objects",
    Severity.WARNING,
    """
An ARRAY or RECORD has its values in sub-objects, and none is described.

```ini
[2002]                         ; gives this finding
ParameterName=Speeds
ObjectType=0x8
SubNumber=0
```
""",
)

NO_SUB0 = Rule(
    "EDS0312",
    "sub-index 0 missing",
    Severity.WARNING,
    """
Sub-index 0 of an ARRAY or RECORD holds its highest sub-index (CiA 301, 7.4.3).

```ini
[2002]                         ; gives this finding if only sub1 is described
ParameterName=Speeds
ObjectType=0x9
SubNumber=1
```
""",
)

SUB0_TYPE = Rule(
    "EDS0313",
    "sub-index 0 is no UNSIGNED8",
    Severity.WARNING,
    """
Sub-index 0 of an ARRAY or RECORD is an UNSIGNED8 (CiA 301, 7.4.3).

```ini
[2001sub0]
ParameterName=Highest sub-index
DataType=0x0007                ; gives this finding
AccessType=ro
```
""",
)

SUB0_VALUE = Rule(
    "EDS0314",
    "highest sub-index is another",
    Severity.WARNING,
    """
The default of sub-index 0 is not the highest sub-index described. Objects whose sub-index 0 counts
something else (PDO mappings, error history, consumers) may have less.

```ini
[2001sub0]
ParameterName=Highest sub-index
DataType=0x0005
AccessType=ro
DefaultValue=9                 ; gives this finding if there are sub0 to sub2
```
""",
)

ARRAY_TYPES = Rule(
    "EDS0315",
    "array of several types",
    Severity.WARNING,
    """
All members of an ARRAY but sub-index 0 have one data type. Several types make a RECORD.

```ini
[2001sub2]
ParameterName=Second speed
DataType=0x0008                ; gives this finding if sub1 is an UNSIGNED16
AccessType=rw
```
""",
)

BAD_SUBINDEX = Rule(
    "EDS0316",
    "impossible sub-index",
    Severity.WARNING,
    """
Sub-indices are 0 to FFh. The section is passed over.

```ini
[2001sub100]                   ; gives this finding
ParameterName=Speed
```
""",
)

COMPACT_COUNT = Rule(
    "EDS0317",
    "impossible number of compact sub-objects",
    Severity.WARNING,
    """
`CompactSubObj` is 0 (not compact) to 254, and stands in place of `SubNumber`. A greater number is
taken for 254; beside `SubNumber` sub-objects that are described win.

```ini
[2002]
ParameterName=Speeds
ObjectType=0x8
DataType=0x0006
AccessType=rw
CompactSubObj=300              ; gives this finding
```
""",
)

NOT_COMPACT = Rule(
    "EDS0318",
    "entry for no sub-object",
    Severity.WARNING,
    """
`[xxxxName]`, `[xxxxValue]` and `[xxxxDenotation]` hold a line for each of some sub-objects of an
object with `CompactSubObj`. There is no such object, or no sub-object of that number.

```ini
[2001Name]
NrOfEntries=1
77=Seventy-seventh speed       ; gives this finding
```
""",
)

RESERVED_INDEX = Rule(
    "EDS0319",
    "reserved index",
    Severity.WARNING,
    """
Objects are at 1000h to BFFFh; below are data types, above nothing yet (CiA 301, table 41).

```ini
[C000]                         ; gives this finding
ParameterName=Speed
```
""",
)

RULES = (
    NO_NAME,
    OBJECT_TYPE,
    WORDS,
    TYPE_TAKEN,
    NO_TYPE,
    UNKNOWN_TYPE,
    NO_ACCESS,
    UNKNOWN_ACCESS,
    ORPHAN,
    OF_A_VAR,
    SUB_NUMBER,
    NO_SUBS,
    NO_SUB0,
    SUB0_TYPE,
    SUB0_VALUE,
    ARRAY_TYPES,
    BAD_SUBINDEX,
    COMPACT_COUNT,
    NOT_COMPACT,
    RESERVED_INDEX,
)
