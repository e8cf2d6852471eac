"""Rules of files, lines, sections and keys (EDS00xx, EDS01xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

MISSING_FILE = Rule(
    "EDS0001",
    "file not found",
    Severity.ERROR,
    """
There is no such file, or the path names a folder.
""",
)

UNREADABLE = Rule(
    "EDS0002",
    "file cannot be read",
    Severity.ERROR,
    """
The system refuses to open or to read the file; mostly its permissions are in the way.
""",
)

BINARY = Rule(
    "EDS0003",
    "not a text file",
    Severity.ERROR,
    """
The file holds a NUL byte, so it is no text: perhaps an archive, or a vendor's own format. EDS and
DCF files are INI text (CiA 306, 4.2).
""",
)

TOO_LARGE = Rule(
    "EDS0004",
    "file too large",
    Severity.ERROR,
    """
The file is larger than 16 MiB, or a line of it longer than 1 MiB. The largest device descriptions
known have about 1 MiB.
""",
)

NOT_ASCII = Rule(
    "EDS0005",
    "not ASCII",
    Severity.WARNING,
    """
CiA 306 asks for ASCII. A file with other characters is read as UTF-8 (with or without byte-order
mark) or UTF-16 if it is that, else as Windows-1252, which most tools of vendors write.

```ini
[DeviceInfo]
VendorName=Gerätebau           ; gives this finding
```
""",
)

A_LINK = Rule(
    "EDS0006",
    "path instead of a description",
    Severity.ERROR,
    """
The file holds one line, which is the path of another file: a symbolic link that was checked out
or downloaded as text. Give the file that it leads to.

```ini
../../common/Drive.dcf
```
""",
)

NO_DEVICE = Rule(
    "EDS0007",
    "no device description",
    Severity.ERROR,
    """
The file has no section that describes an object, such as `[1000]`. It may be empty, or of another
format (XDD, CPJ, an EDS of EtherNet/IP).
""",
)

TOO_MANY_OBJECTS = Rule(
    "EDS0008",
    "too many sub-objects",
    Severity.ERROR,
    """
The description gives more than 15,000 variables. Mostly a count of compact sub-objects
(`CompactSubObj`, `Count`) is wrong.
""",
)

TOO_MANY_FINDINGS = Rule(
    "EDS0009",
    "too many findings",
    Severity.WARNING,
    """
A file gives more findings of one severity than are shown (500). Put right the first ones and run
again.
""",
)

STRAY_LINE = Rule(
    "EDS0100",
    "line that is neither section nor key",
    Severity.WARNING,
    """
A line is `[Section]`, `Key=Value`, or a comment that starts with `;`. Any other line is ignored.

```ini
[2000]
ParameterName=Speed
this line gives the finding
```
""",
)

OUTSIDE = Rule(
    "EDS0101",
    "key outside of sections",
    Severity.WARNING,
    """
A key before the first section belongs to nothing and is ignored.

```ini
FileName=drive.eds             ; gives this finding
[FileInfo]
```
""",
)

BAD_HEADER = Rule(
    "EDS0102",
    "malformed section header",
    Severity.WARNING,
    """
A section's header stands alone on its line, in one pair of brackets. It is read as if it did.

```ini
[2000                          ; gives this finding
ParameterName=Speed
```
""",
)

SAME_SECTION = Rule(
    "EDS0103",
    "section given twice",
    Severity.WARNING,
    """
A section of that name stands above; case does not matter in names. The first one holds, keys that
only the second one has are added to it.

```ini
[2001]
ParameterName=Speed
[2001]                         ; gives this finding
ParameterName=Torque
```
""",
)

SAME_KEY = Rule(
    "EDS0104",
    "key given twice",
    Severity.WARNING,
    """
The key stands in the section already; case does not matter in names. The first one holds.

```ini
[2000]
ParameterName=Speed
DefaultValue=1
DefaultValue=2                 ; gives this finding
```
""",
)

STRAY_COMMENT = Rule(
    "EDS0105",
    "comment where none can stand",
    Severity.WARNING,
    """
Comments are whole lines that start with `;`. A comment behind a number, or one that starts with
`#`, is taken for a comment all the same; other tools may take it for text.

```ini
[2000]
DefaultValue=12 ; the middle   ; gives this finding
# so does this line
```
""",
)

OTHER_SPELLING = Rule(
    "EDS0106",
    "section spelt in another way",
    Severity.WARNING,
    """
The name of the section is not as CiA 306 has it, but it is clear what is meant: `[0x2000]` or
`[A0]` for a name of four digits, `[2000sub0A]` for `[2000subA]`, `[DeviceCommissioning]` for
`[DeviceComissioning]`, which is the standard's own spelling. Many tools pass over such sections.

```ini
[0x2000]                       ; gives this finding
ParameterName=Speed
```
""",
)

UNKNOWN_SECTION = Rule(
    "EDS0107",
    "unknown section",
    Severity.NOTE,
    """
CiA 306 has no section of that name. It is kept, but means nothing here.

```ini
[VendorTool]                   ; gives this finding
Version=3
```
""",
)

UNKNOWN_KEY = Rule(
    "EDS0108",
    "unknown key",
    Severity.NOTE,
    """
CiA 306 has no key of that name in this section. It is ignored.

```ini
[2000]
ParameterName=Speed
Colour=red                     ; gives this finding
```
""",
)

MISSPELT_KEY = Rule(
    "EDS0109",
    "misspelt key",
    Severity.WARNING,
    """
CiA 306 has no key of that name in this section, but one that differs by a letter or two and is not
given. What is written is ignored.

```ini
[2000]
ParameterNmae=Speed            ; gives this finding
```
""",
)

COLON = Rule(
    "EDS0110",
    "colon in place of the equals sign",
    Severity.WARNING,
    """
A key and its value are separated by `=`. Some tools read `:` as well, so it is taken for one.

```ini
[2000]
ParameterName: Speed           ; gives this finding
```
""",
)

RULES = (
    MISSING_FILE,
    UNREADABLE,
    BINARY,
    TOO_LARGE,
    NOT_ASCII,
    A_LINK,
    NO_DEVICE,
    TOO_MANY_OBJECTS,
    TOO_MANY_FINDINGS,
    STRAY_LINE,
    OUTSIDE,
    BAD_HEADER,
    SAME_SECTION,
    SAME_KEY,
    STRAY_COMMENT,
    OTHER_SPELLING,
    UNKNOWN_SECTION,
    UNKNOWN_KEY,
    MISSPELT_KEY,
    COLON,
)
