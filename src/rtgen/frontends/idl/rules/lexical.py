"""Rules of files, characters and the preprocessor (IDL00xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

MISSING_FILE = Rule(
    "IDL0001",
    "file not found",
    Severity.ERROR,
    """
A file that was to be read does not exist, or is a folder. Check its spelling, upper and lower case
included, and the folder from which rtgen was started.
""",
)

UNREADABLE = Rule(
    "IDL0002",
    "file cannot be read",
    Severity.ERROR,
    """
The file exists, but the system refuses to read it: for lack of a permission, because its name is
too long, or because the disk fails. The message gives the system's reason.
""",
)

BINARY = Rule(
    "IDL0003",
    "not a text file",
    Severity.ERROR,
    """
The file holds a NUL byte, so it is no text: perhaps a compiled file, or UTF-16. Definitions are
read as UTF-8; bytes that are not UTF-8 count as Latin-1.
""",
)

BAD_CHARACTER = Rule(
    "IDL0004",
    "character that cannot stand here",
    Severity.ERROR,
    """
Outside comments and strings IDL knows letters, digits, white space and its own punctuation only.
Typographic quotes, full-width marks and ideographic spaces are the usual culprits:

```idl
const string NAME = “rover”;   // wrong
const string NAME = "rover";   // right
```
""",
)

LINE_TOO_LONG = Rule(
    "IDL0005",
    "line too long",
    Severity.ERROR,
    """
A line of more than 262144 characters is no definition that somebody wrote. Break it into
lines, or check whether the file is what it should be.
""",
)

FILE_TOO_LARGE = Rule(
    "IDL0006",
    "file too large",
    Severity.ERROR,
    """
The file is larger than 32 MiB, far beyond any definition. Check whether it is what it should be.
""",
)

UNCLOSED_COMMENT = Rule(
    "IDL0007",
    "comment that is never closed",
    Severity.ERROR,
    """
A `/*` has no `*/` behind it, so the rest of the file would be a comment. Comments do not nest:
the first `*/` closes, however many `/*` there were.
""",
)

INCLUDE_NOT_FOUND = Rule(
    "IDL0010",
    "included file not found",
    Severity.ERROR,
    """
`#include "file"` is looked for beside the including file, then in the include folders in their
order; `#include <file>` in the include folders only. They are given by `-I DIR` or
`include` in `rtgen.toml`. The hint lists the folders that were searched, and a file of a similar
name if there is one. Upper and lower case count on every system.
""",
)

INCLUDE_CYCLE = Rule(
    "IDL0011",
    "includes without end",
    Severity.ERROR,
    """
Files include each other in a circle, so reading them would never end. Give each file a guard, and
break the circle:

```idl
#ifndef WHEEL_IDL
#define WHEEL_IDL
// ...
#endif
```
""",
)

BAD_INCLUDE = Rule(
    "IDL0012",
    "malformed #include",
    Severity.ERROR,
    """
`#include` needs a file name in `"..."` or `<...>`, or a macro that expands to one.
""",
)

UNCLOSED_CONDITIONAL = Rule(
    "IDL0013",
    "conditional that is never closed",
    Severity.ERROR,
    """
An `#if`, `#ifdef` or `#ifndef` has no `#endif` in the same file. Mostly it is an include guard
whose last line was lost:

```idl
#ifndef WHEEL_IDL
#define WHEEL_IDL
struct Wheel { double radius; };
#endif                            // often forgotten
```
""",
)

STRAY_CONDITIONAL = Rule(
    "IDL0014",
    "#else, #elif or #endif in the wrong place",
    Severity.ERROR,
    """
`#elif`, `#else` and `#endif` belong to an `#if`, `#ifdef` or `#ifndef` before them in the same
file, and nothing but `#endif` may follow an `#else`.
""",
)

BAD_CONDITION = Rule(
    "IDL0015",
    "condition that cannot be evaluated",
    Severity.ERROR,
    """
`#if` and `#elif` take an integer expression of C: numbers, `defined NAME`, macros, and operators.
Names that are no macros count as 0. The condition counts as false.

```idl
#if VERSION >= 2 && !defined(SMALL)
```
""",
)

BAD_DEFINITION = Rule(
    "IDL0016",
    "malformed #define",
    Severity.ERROR,
    """
`#define NAME text` or `#define NAME(a, b) text`. The name and the parameters are identifiers, the
parenthesis follows the name directly, and `##` stands between two tokens.
""",
)

MACRO_REDEFINED = Rule(
    "IDL0017",
    "macro defined again, differently",
    Severity.WARNING,
    """
A macro has two definitions with different texts; from here on the later one counts. If that is
meant, put `#undef NAME` between them.
""",
)

BAD_MACRO_CALL = Rule(
    "IDL0018",
    "macro that cannot be expanded",
    Severity.ERROR,
    """
The call has the wrong number of arguments or no closing parenthesis, `#` or `##` cannot be
applied, or the expansion grows beyond all bounds.
""",
)

ERROR_DIRECTIVE = Rule(
    "IDL0019",
    "#error",
    Severity.ERROR,
    """
The definition itself refuses to be read: an `#error` line is reached. Its text says why, often a
macro that has to be defined with `-D NAME=VALUE`.
""",
)

WARNING_DIRECTIVE = Rule(
    "IDL0020",
    "#warning",
    Severity.WARNING,
    """
The definition holds a `#warning` line that is reached. Its text is the message.
""",
)

UNKNOWN_DIRECTIVE = Rule(
    "IDL0021",
    "unknown directive",
    Severity.ERROR,
    """
A line that begins with `#` is for the preprocessor, which knows `define elif else endif error if
ifdef ifndef include line pragma undef warning`.
""",
)

BAD_LINE_MARKER = Rule(
    "IDL0022",
    "malformed line marker",
    Severity.ERROR,
    """
`#line NUMBER "file"`, or `# NUMBER "file" FLAGS` as preprocessors write it, tells where the next
line came from. The number is decimal.
""",
)

BAD_MACRO_NAME = Rule(
    "IDL0023",
    "macro that is no identifier",
    Severity.ERROR,
    """
A macro given from outside (`-D NAME=VALUE`, or `define` in `rtgen.toml`) needs an identifier as
its name.
""",
)

INCLUDED_AGAIN = Rule(
    "IDL0024",
    "file included again without a guard",
    Severity.NOTE,
    """
The file has no include guard, and was taken in before. Its declarations are not read again, so
nothing is declared twice; ROS 2, for one, generates such files. CORBA compilers refuse them. If
the file is your own, give it a guard:

```idl
#ifndef WHEEL_IDL
#define WHEEL_IDL
// ...
#endif
```
""",
)

RULES = (
    MISSING_FILE,
    UNREADABLE,
    BINARY,
    BAD_CHARACTER,
    LINE_TOO_LONG,
    FILE_TOO_LARGE,
    UNCLOSED_COMMENT,
    INCLUDE_NOT_FOUND,
    INCLUDE_CYCLE,
    BAD_INCLUDE,
    UNCLOSED_CONDITIONAL,
    STRAY_CONDITIONAL,
    BAD_CONDITION,
    BAD_DEFINITION,
    MACRO_REDEFINED,
    BAD_MACRO_CALL,
    ERROR_DIRECTIVE,
    WARNING_DIRECTIVE,
    UNKNOWN_DIRECTIVE,
    BAD_LINE_MARKER,
    BAD_MACRO_NAME,
    INCLUDED_AGAIN,
)
