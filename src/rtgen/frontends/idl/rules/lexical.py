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

```text
$ rtgen generate robto.idl
robto.idl:1:1: error[IDL0001]: robto.idl does not exist
  hint: did you mean robot.idl?
```
""",
)

UNREADABLE = Rule(
    "IDL0002",
    "file cannot be read",
    Severity.ERROR,
    """
The file exists, but the system refuses to read it: for lack of a permission, because its name is
too long, or because the disk fails. The message gives the system's reason.

```text
$ chmod a-r robot.idl
$ rtgen generate robot.idl
robot.idl:1:1: error[IDL0002]: robot.idl cannot be read: Permission denied
```
""",
)

BINARY = Rule(
    "IDL0003",
    "not a text file",
    Severity.ERROR,
    """
The file holds a NUL byte, so it is no text: perhaps a compiled file, or UTF-16. Definitions are
read as UTF-8; bytes that are not UTF-8 count as Latin-1.

```text
$ rtgen generate robot.o
$ iconv -f UTF-16 -t UTF-8 robot.idl > robot8.idl     # what helps for UTF-16
```
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

FILE_TOO_LARGE = Rule(
    "IDL0006",
    "file too large",
    Severity.ERROR,
    """
The file is larger than 32 MiB, far beyond any definition. Check whether it is what it should be.

```text
$ ls -l robot.idl
-rw-r--r-- 1 me me 41943040 Jan  1 00:00 robot.idl
```
""",
)

UNCLOSED_COMMENT = Rule(
    "IDL0007",
    "comment that is never closed",
    Severity.ERROR,
    """
A `/*` has no `*/` behind it, so the rest of the file would be a comment. Comments do not nest:
the first `*/` closes, however many `/*` there were.

```idl
/* The wheels /* all of them */    // closed here
struct Wheel { double radius; };   /* never closed
```
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

```idl
#include "Wheel.idl"     // wrong, where the file is called wheel.idl
#include "wheel.idl"     // right
```
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

```idl
#include wheel.idl       // wrong
#include "wheel.idl"     // right
```
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

```idl
#if VERSION >= 2
struct Wheel { double radius; };
#endif
#endif                   // wrong: nothing is open
```
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

```idl
#define 3D 1             // wrong
#define THREE_D 1        // right
```
""",
)

MACRO_REDEFINED = Rule(
    "IDL0017",
    "macro defined again, differently",
    Severity.WARNING,
    """
A macro has two definitions with different texts; from here on the later one counts. If that is
meant, put `#undef NAME` between them.

```idl
#define SIZE 3
#define SIZE 4           // told
#undef SIZE
#define SIZE 5           // meant
```
""",
)

BAD_MACRO_CALL = Rule(
    "IDL0018",
    "macro that cannot be expanded",
    Severity.ERROR,
    """
The call has the wrong number of arguments or no closing parenthesis, `#` or `##` cannot be
applied, or the expansion grows beyond all bounds.

```idl
#define WHEEL(name, radius) const double name = radius;
WHEEL(LEFT)              // wrong
WHEEL(LEFT, 0.1)         // right
```
""",
)

ERROR_DIRECTIVE = Rule(
    "IDL0019",
    "#error",
    Severity.ERROR,
    """
The definition itself refuses to be read: an `#error` line is reached. Its text says why, often a
macro that has to be defined with `-D NAME=VALUE`.

```idl
#ifndef ROBOT
#error define ROBOT, for example by -D ROBOT=1
#endif
```
""",
)

WARNING_DIRECTIVE = Rule(
    "IDL0020",
    "#warning",
    Severity.WARNING,
    """
The definition holds a `#warning` line that is reached. Its text is the message.

```idl
#warning this file is old: include pose2.idl
```
""",
)

UNKNOWN_DIRECTIVE = Rule(
    "IDL0021",
    "unknown directive",
    Severity.ERROR,
    """
A line that begins with `#` is for the preprocessor, which knows `define elif else endif error if
ifdef ifndef include include_next line pragma undef warning`.

```idl
#inclued "wheel.idl"     // wrong
#include "wheel.idl"     // right
```
""",
)

BAD_LINE_MARKER = Rule(
    "IDL0022",
    "malformed line marker",
    Severity.ERROR,
    """
`#line NUMBER "file"`, or `# NUMBER "file" FLAGS` as preprocessors write it, tells where the next
line came from. The number is decimal.

```idl
#line here               // wrong
#line 12 "wheel.idl"     // right
```
""",
)

BAD_MACRO_NAME = Rule(
    "IDL0023",
    "macro that is no identifier",
    Severity.ERROR,
    """
A macro given from outside (`-D NAME=VALUE`, or `define` in `rtgen.toml`) needs an identifier as
its name.

```text
$ rtgen generate -D 3D=1 robot.idl          # wrong
$ rtgen generate -D THREE_D=1 robot.idl     # right
```
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

NAMELESS_CONDITION = Rule(
    "IDL0025",
    "conditional without the name of a macro",
    Severity.WARNING,
    """
`#ifdef` and `#ifndef` ask for one macro, by its name. Without a name nothing is defined: what
stands behind `#ifdef` is left out, what stands behind `#ifndef` is read. An expression needs `#if`.

```idl
#ifdef 1                 // wrong
#if 1                    // right
```
""",
)

PASSED_OVER = Rule(
    "IDL0026",
    "directive of which nothing is made",
    Severity.WARNING,
    """
`#assert` and `#unassert`, an old extension of GNU's preprocessor, are passed over. No condition
can ask for what they state; use macros.

```idl
#assert target(robot)    // passed over
#define TARGET_ROBOT     // what conditions can ask for
```
""",
)

TIME_OF_TRANSLATION = Rule(
    "IDL0027",
    "date or time of translation",
    Severity.WARNING,
    """
The same definitions always give the same code, so `__DATE__` is always "Jan  1 1970" and
`__TIME__` is "00:00:00", unless `define` in `rtgen.toml` or `-D` says otherwise.

```text
$ rtgen generate -D '__DATE__="Nov  3 2025"' robot.idl
```
""",
)

RULES = (
    MISSING_FILE,
    UNREADABLE,
    BINARY,
    BAD_CHARACTER,
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
    NAMELESS_CONDITION,
    PASSED_OVER,
    TIME_OF_TRANSLATION,
)
