"""Rules of C headers (CDL09xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

MISSING_HEADER = Rule(
    "CDL0900",
    "C header not found",
    Severity.ERROR,
    """
What `import_C` names is not in the working folder, in the folder of the file, or in one of the
folders of `-I`. tecsgen: S1142.

```cdl
import_C( "motor_types.h" );   // rtgen check -I include board.cdl
```
""",
)

UNREADABLE_HEADER = Rule(
    "CDL0901",
    "C header that is not understood",
    Severity.ERROR,
    """
The header was preprocessed (with `TECSGEN` defined), but what came out is not C as the parser
knows it. Hide what TECS need not see behind `#ifndef TECSGEN`. tecsgen: B1001 to B1004.

```c
#ifndef TECSGEN
static inline void wait(void) { asm volatile("wfi"); }
#endif
```
""",
)

HEADER_TWICE = Rule(
    "CDL0902",
    "C header imported with other definitions",
    Severity.ERROR,
    """
A header is read once, so a second `import_C` cannot have other definitions. tecsgen: S1143.

```cdl
import_C( "motor_types.h" );
import_C( "motor_types.h", "WHEELS=4" );   // wrong
```
""",
)

MISSING_INCLUDE = Rule(
    "CDL0903",
    "file included by a C header not found",
    Severity.WARNING,
    """
A header includes a file that is in none of the folders of `-I`. Standard headers such as
`stdint.h` are known without their files. Types that the file would declare are unknown.
""",
)

HEADER_LIMIT = Rule(
    "CDL0904",
    "C header too large",
    Severity.ERROR,
    """
With what it includes a header may come to 8 MiB of text after preprocessing; 500,000 tokens may go
through its macros, and 1000 files be included.
""",
)

HEADER_REDEFINES = Rule(
    "CDL0905",
    "C type declared differently",
    Severity.WARNING,
    """
Two C headers, or a header and a CDL file, declare a type or a struct of the same name differently.
The first declaration counts.
""",
)

HEADER_DEFINITION = Rule(
    "CDL0906",
    "definition that is none",
    Severity.ERROR,
    """
The second argument of `import_C` is a list of macros, separated by commas: `A=1,B`.

```cdl
import_C( "motor_types.h", "WHEELS=4,STRICT" );
```
""",
)

RULES = (
    MISSING_HEADER,
    UNREADABLE_HEADER,
    HEADER_TWICE,
    MISSING_INCLUDE,
    HEADER_LIMIT,
    HEADER_REDEFINES,
    HEADER_DEFINITION,
)
