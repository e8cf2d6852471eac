"""Rules of FileInfo, DeviceInfo, commissioning and the lists of objects (EDS02xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

MISSING_SECTION = Rule(
    "EDS0200",
    "section missing",
    Severity.WARNING,
    """
CiA 306 asks for `[FileInfo]`, `[DeviceInfo]` and the lists `[MandatoryObjects]`,
`[OptionalObjects]` and `[ManufacturerObjects]`, in a DCF for `[DeviceComissioning]` as well.
""",
)

MISSING_KEYS = Rule(
    "EDS0201",
    "keys missing",
    Severity.NOTE,
    """
Keys that CiA 306 has as mandatory in this section are not given.

```ini
[FileInfo]                     ; gives this finding
FileName=drive.eds
```
""",
)

BAD_INFORMATION = Rule(
    "EDS0202",
    "value that the key cannot have",
    Severity.WARNING,
    """
The value is not of the key's kind, or out of its range: a number, `0` or `1`, a date as
`mm-dd-yyyy`, a time as `hh:mmAM`. It is ignored.

```ini
[DeviceInfo]
NrOfRXPDO=many                 ; gives this finding
```
""",
)

WRONG_COUNT = Rule(
    "EDS0203",
    "wrong count",
    Severity.WARNING,
    """
The count (`SupportedObjects`, `NrOfEntries`, `Lines`) is missing or is not the number of entries
that follow. All entries are read.

```ini
[MandatoryObjects]
SupportedObjects=2             ; gives this finding
1=0x1000
2=0x1001
3=0x1018
```
""",
)

BAD_ENTRY = Rule(
    "EDS0204",
    "entry that is no index",
    Severity.WARNING,
    """
An entry of a list of objects is `number=index`. Anything else is ignored.

```ini
[ManufacturerObjects]
SupportedObjects=1
1=Speed                        ; gives this finding
```
""",
)

NOT_THERE = Rule(
    "EDS0205",
    "listed object is not described",
    Severity.WARNING,
    """
A list names an object that has no section.

```ini
[ManufacturerObjects]
SupportedObjects=1
1=0x2345                       ; gives this finding if there is no [2345]
```
""",
)

NOT_LISTED = Rule(
    "EDS0206",
    "object in no list",
    Severity.WARNING,
    """
The object has a section, but is in none of the lists `[MandatoryObjects]`, `[OptionalObjects]`,
`[ManufacturerObjects]`. It is read; other tools may pass over it.
""",
)

WRONG_LIST = Rule(
    "EDS0207",
    "object in the wrong list",
    Severity.WARNING,
    """
`[MandatoryObjects]` has 1000h, 1001h and 1018h, `[ManufacturerObjects]` 2000h to 5FFFh, and
`[OptionalObjects]` the rest.

```ini
[OptionalObjects]
SupportedObjects=1
1=0x2000                       ; gives this finding
```
""",
)

LISTED_TWICE = Rule(
    "EDS0208",
    "object listed twice",
    Severity.WARNING,
    """
Each object is listed once.

```ini
[ManufacturerObjects]
SupportedObjects=2
1=0x2000
2=0x2000                       ; gives this finding
```
""",
)

MANDATORY_OBJECT = Rule(
    "EDS0209",
    "mandatory object missing",
    Severity.WARNING,
    """
Every CANopen device has the device type (1000h), the error register (1001h) and the identity
object (1018h).
""",
)

PDO_COUNT = Rule(
    "EDS0210",
    "wrong number of PDOs",
    Severity.WARNING,
    """
`NrOfRXPDO` and `NrOfTXPDO` tell how many PDOs of the direction the device has; the file describes
another number of them by communication parameters (1400h and on, 1800h and on).

```ini
[DeviceInfo]
NrOfTXPDO=4                    ; gives this finding if there is only [1800]
```
""",
)

NODE_ID = Rule(
    "EDS0211",
    "impossible node-id",
    Severity.WARNING,
    """
A node-id is 1 to 127. The file's is ignored, so what depends on it stays a formula; give one with
`--node-id`.

```ini
[DeviceComissioning]
NodeID=200                     ; gives this finding
```
""",
)

BIT_RATE = Rule(
    "EDS0212",
    "unusual bit rate",
    Severity.WARNING,
    """
`Baudrate` of a DCF is one of CiA 301's bit rates in kbit/s: 10, 20, 50, 125, 250, 500, 800 or 1000.
One that is a thousand times as high is taken for bit/s.

```ini
[DeviceComissioning]
NodeID=5
Baudrate=500000                ; gives this finding
```
""",
)

OF_A_DCF = Rule(
    "EDS0213",
    "part of a DCF in an EDS",
    Severity.WARNING,
    """
`[DeviceComissioning]`, `ParameterValue`, `Denotation`, `UploadFile`, `DownloadFile` and
`[xxxxValue]` configure one device and belong to a DCF. They hold here as well; rename the file if
it describes a configured device.

```ini
[2000]
ParameterName=Speed
ParameterValue=12              ; gives this finding in drive.eds
```
""",
)

OTHER_IDENTITY = Rule(
    "EDS0214",
    "two identities",
    Severity.WARNING,
    """
`VendorNumber` and `ProductNumber` of `[DeviceInfo]` tell something else than the defaults of the
identity object, 1018h. A manager that compares the device with the file would refuse one of them.

```ini
[DeviceInfo]
VendorNumber=0x123             ; gives this finding
[1018sub1]
ParameterName=Vendor-ID
DefaultValue=0x456
```
""",
)

BAD_DUMMY = Rule(
    "EDS0215",
    "no data type for a gap",
    Severity.WARNING,
    """
The keys of `[DummyUsage]` are `Dummy` and the four digits of a data type of fixed width.

```ini
[DummyUsage]
Dummy0009=1                    ; gives this finding: a string has no fixed width
```
""",
)

RULES = (
    MISSING_SECTION,
    MISSING_KEYS,
    BAD_INFORMATION,
    WRONG_COUNT,
    BAD_ENTRY,
    NOT_THERE,
    NOT_LISTED,
    WRONG_LIST,
    LISTED_TWICE,
    MANDATORY_OBJECT,
    PDO_COUNT,
    NODE_ID,
    BIT_RATE,
    OF_A_DCF,
    OTHER_IDENTITY,
    BAD_DUMMY,
)
