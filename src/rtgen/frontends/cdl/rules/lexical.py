"""Rules of the words and marks of CDL (CDL01xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

BAD_CHARACTER = Rule(
    "CDL0100",
    "character that cannot stand here",
    Severity.ERROR,
    """
Outside comments and strings a CDL file is ASCII. Wide blanks and marks that a Japanese input
method writes look much like ASCII ones.
""",
)

UNCLOSED_COMMENT = Rule(
    "CDL0101",
    "comment that is never closed",
    Severity.ERROR,
    """
A comment begins with `/*`, and the file ends before `*/`. Comments do not nest.
""",
)

UNCLOSED_TEXT = Rule(
    "CDL0102",
    "string that is never closed",
    Severity.ERROR,
    """
A string ends on its line, unless a backslash stands before the line end. Long plug-in arguments
are better written as several strings, which are joined:

```cdl
[through( RTCPlugin, "address=192.168.0.7,"
                     "port=9000" )]
cMotor = Motor.eMotor;
```
""",
)

DIRECTIVE = Rule(
    "CDL0103",
    "preprocessor directive",
    Severity.ERROR,
    """
CDL has no preprocessor: `#include`, `#define` and `#if` are syntax errors. `import` reads another
CDL file, `import_C` the types of a C header, and `const` declares a constant.

```cdl
import_C( "tecs.h" );
const int32_t LENGTH = 16;
```
""",
)

ANGLE = Rule(
    "CDL0104",
    "text between < and > taken for a file name",
    Severity.ERROR,
    """
Where a `>` follows a `<` on the same line, all between them is one name, as in `import( <file> )`,
also where shifts or comparisons were meant. Put them on two lines.

```cdl
const int32_t A = 1 << 2;  const bool_t B = 3 > 2;   // wrong

const int32_t A = 1 << 2;                            // right
const bool_t B = 3 > 2;
```
""",
)

NUMBER = Rule(
    "CDL0105",
    "number that CDL does not know",
    Severity.ERROR,
    """
Integers are decimal (`12`), octal (`014`) or hexadecimal with a small x (`0x0C`), without suffixes.
Floating-point numbers need a dot (`1.5`, `1.`, `1.e5`).

```cdl
const uint32_t N = 10U;     // wrong
const uint32_t N = 10;      // right
```
""",
)

RULES = (
    BAD_CHARACTER,
    UNCLOSED_COMMENT,
    UNCLOSED_TEXT,
    DIRECTIVE,
    ANGLE,
    NUMBER,
)
