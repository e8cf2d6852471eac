"""Rules of PDOs (EDS05xx). A PDO that breaks one is read as it stands."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

HALF = Rule(
    "EDS0500",
    "PDO without one of its two objects",
    Severity.WARNING,
    """
A PDO has a communication parameter (1400h, 1800h and on) and a mapping parameter 200h above it
(1600h, 1A00h and on). Without the mapping it carries nothing, without the communication parameter
there is no PDO.

```ini
[1801]                         ; gives this finding if there is no [1A01]
ParameterName=TPDO communication parameter
```
""",
)

NO_OBJECT = Rule(
    "EDS0501",
    "mapped object does not exist",
    Severity.WARNING,
    """
The mapping names an object that the file does not describe.

```ini
[1A00sub1]
DefaultValue=0x23450008        ; gives this finding if there is no [2345]
```
""",
)

NOT_MAPPABLE = Rule(
    "EDS0502",
    "mapped object cannot be mapped",
    Severity.WARNING,
    """
The object has no `PDOMapping=1`, so the device would refuse the mapping.

```ini
[1A00sub1]
DefaultValue=0x20000008        ; gives this finding if [2000] has PDOMapping=0
```
""",
)

OTHER_LENGTH = Rule(
    "EDS0503",
    "mapped length is not the type's",
    Severity.WARNING,
    """
The last two digits of an entry are the length in bits, which is that of the object's data type.

```ini
[1A00sub1]
DefaultValue=0x60000110        ; gives this finding: 16 bits of an UNSIGNED8
```
""",
)

TOO_LONG = Rule(
    "EDS0504",
    "PDO too long",
    Severity.WARNING,
    """
A PDO has up to 64 bits of data (CiA 301, 7.3.3). No codec can be made for a longer one.
""",
)

WRONG_WAY = Rule(
    "EDS0505",
    "access does not fit the PDO",
    Severity.WARNING,
    """
A TPDO carries objects that can be read (`ro`, `rw`, `rwr`, `const`), an RPDO those that can be
written (`wo`, `rw`, `rww`).

```ini
[1600sub1]
DefaultValue=0x60000108        ; gives this finding if [6000sub1] is ro
```
""",
)

BAD_NUMBER = Rule(
    "EDS0506",
    "wrong number of mapped objects",
    Severity.WARNING,
    """
Sub-index 0 of a mapping parameter is the number of entries in use: 0 to 64, and no more than are
described. Without a value it counts as 0.

```ini
[1A00sub0]
DefaultValue=9                 ; gives this finding if there are 8 entries
```
""",
)

BAD_COB_ID = Rule(
    "EDS0507",
    "COB-ID that a PDO cannot have",
    Severity.WARNING,
    """
The COB-ID is missing, or is one that CiA 301 keeps for other services: 000h to 07Fh, 101h to 180h,
581h to 5FFh, 601h to 67Fh, 6E0h to 6FFh, 701h and above (CiA 301, table 40).

```ini
[1800sub1]
DefaultValue=$NODEID+0x580     ; gives this finding: that is the SDO server's
```
""",
)

BAD_TRANSMISSION = Rule(
    "EDS0508",
    "reserved transmission type",
    Severity.WARNING,
    """
Transmission types are 0 to 240 (with SYNC), 252 and 253 (on request, TPDO only), 254 and 255
(event).

```ini
[1800sub2]
DefaultValue=250               ; gives this finding
```
""",
)

BAD_GAP = Rule(
    "EDS0509",
    "gap that is not allowed",
    Severity.WARNING,
    """
An RPDO may have gaps: entries with the index of a data type that `[DummyUsage]` allows, and the
length of that type. A TPDO has none.

```ini
[1A00sub1]
DefaultValue=0x00050008        ; gives this finding
```
""",
)

SAME_COB_ID = Rule(
    "EDS0510",
    "two PDOs with one COB-ID",
    Severity.WARNING,
    """
Two valid PDOs of the device have the same COB-ID, so a receiver cannot tell them apart.
""",
)

GRANULARITY = Rule(
    "EDS0511",
    "finer than the granularity",
    Severity.WARNING,
    """
`Granularity` of `[DeviceInfo]` is the smallest unit of a mapping in bits: 1 for bits, 8 for
bytes, and so on; 0 means that no mapping can be changed. An entry of another length is mapped.

```ini
[DeviceInfo]
Granularity=8                  ; gives this finding if a BOOLEAN is mapped
```
""",
)

MAPPED_TWICE = Rule(
    "EDS0512",
    "object mapped twice",
    Severity.WARNING,
    """
The PDO carries the same object twice.
""",
)

EMPTY_ENTRY = Rule(
    "EDS0513",
    "empty entry in use",
    Severity.WARNING,
    """
An entry in use has no object or a length of 0 bits.

```ini
[1A00sub1]
DefaultValue=0                 ; gives this finding
```
""",
)

RULES = (
    HALF,
    NO_OBJECT,
    NOT_MAPPABLE,
    OTHER_LENGTH,
    TOO_LONG,
    WRONG_WAY,
    BAD_NUMBER,
    BAD_COB_ID,
    BAD_TRANSMISSION,
    BAD_GAP,
    SAME_COB_ID,
    GRANULARITY,
    MAPPED_TWICE,
    EMPTY_ENTRY,
)
