"""Rules of syntax (IDL01xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNEXPECTED = Rule(
    "IDL0100",
    "syntax error",
    Severity.ERROR,
    """
The text does not follow the grammar of IDL at this place. Where only few things could have stood
here, the message names them. The broken declaration is passed over and reading goes on behind it,
so other mistakes are reported in the same run.

```idl
struct Wheel { long max speed; };    // wrong: a name has one word
struct Wheel { long max_speed; };    // right
```
""",
)

MISSING_SEMICOLON = Rule(
    "IDL0101",
    "missing semicolon",
    Severity.ERROR,
    """
Every declaration and member ends with `;`, also behind a closing brace. The place shown is the end
of the declaration that lacks it.

```idl
struct Wheel { double radius; }    // wrong
struct Wheel { double radius; };   // right
```
""",
)

MISSPELT_KEYWORD = Rule(
    "IDL0102",
    "misspelt keyword",
    Severity.ERROR,
    """
A word stands where only a keyword can, and it is like one. Keywords are written exactly as the
language has them, upper and lower case included: `struct`, `Object`, `TRUE`.

```idl
strcut Wheel { double radius; };     // wrong
struct Wheel { double radius; };     // right
```
""",
)

KEYWORD_AS_NAME = Rule(
    "IDL0103",
    "keyword used as a name",
    Severity.ERROR,
    """
A keyword cannot name anything. With a leading underscore, which is not part of the name, it can:

```idl
struct Event { long local; };    // wrong: local is a keyword
struct Event { long _local; };   // right: the member is called local
```
""",
)

MISSING_NAME = Rule(
    "IDL0104",
    "declaration without a name",
    Severity.ERROR,
    """
Structs, unions, enums, interfaces and so on need a name, also where they are declared in place
inside another declaration.

```idl
typedef struct { long x; } Point;    // wrong
struct Point { long x; };            // right
```
""",
)

UNCLOSED_BRACE = Rule(
    "IDL0105",
    "brace that is never closed",
    Severity.ERROR,
    """
The file ends, but a `{` is still open. The place shown is the innermost such brace.

```idl
struct Wheel {           // never closed
    double radius;

struct Axle { double length; };
```
""",
)

STRAY_BRACE = Rule(
    "IDL0106",
    "brace that closes nothing",
    Severity.ERROR,
    """
A `}` stands where no brace is open. Remove it, or look for the missing `{` before it.

```idl
struct Wheel { double radius; };
};                       // wrong
```
""",
)

UNEXPECTED_END = Rule(
    "IDL0107",
    "file ends too early",
    Severity.ERROR,
    """
The file ends in the middle of a declaration.

```idl
const double RADIUS =
```
""",
)

UNCLOSED_TEXT = Rule(
    "IDL0108",
    "string that is never closed",
    Severity.ERROR,
    """
A `"` has no partner on its line. Long strings are written in pieces, which are joined:

```idl
const string GREETING = "Hello, "
                        "world";
```
""",
)

BAD_LITERAL = Rule(
    "IDL0109",
    "malformed literal",
    Severity.ERROR,
    """
A number, character or string is not written as IDL wants it. Octal numbers begin with 0 and have
no 8 or 9; numbers have no suffix but `d` for fixed-point; a character literal holds exactly one
character; strings hold no NUL character; `\\u` stands in wide literals only.

```idl
const long   MASK  = 089;     // wrong: write 89
const float  LIMIT = 1.0f;    // wrong: write 1.0
const char   LETTER = 'ab';   // wrong
```
""",
)

EXTRA_SEMICOLON = Rule(
    "IDL0110",
    "semicolon too many",
    Severity.WARNING,
    """
A `;` ends nothing here. It is passed over, but other IDL compilers refuse it.

```idl
struct Wheel { double radius;; };    // one too many
```
""",
)

TOO_MANY = Rule(
    "IDL0111",
    "too many syntax errors",
    Severity.ERROR,
    """
After 50 syntax errors in one file the rest is not read: the file is probably no IDL at all.

```text
robot.idl:51:10: error[IDL0111]: 50 syntax errors: the rest is not read
```
""",
)

TOO_DEEP = Rule(
    "IDL0112",
    "nested too deeply",
    Severity.ERROR,
    """
Modules, types and parentheses may nest 256 levels deep each, far more than definitions need.

```idl
typedef sequence<sequence<sequence<long> > > Cube;    // 3 deep: far from the limit
```
""",
)

UNKNOWN_ESCAPE = Rule(
    "IDL0113",
    "unknown escape",
    Severity.WARNING,
    """
A backslash in a literal is followed by a character that is no escape; the character itself is
taken. IDL knows `\\n \\t \\v \\b \\r \\f \\a \\\\ \\? \\' \\"`, octal `\\123`, hexadecimal
`\\x7f`, and in wide
literals `\\u12ab`.

```idl
const string PATH = "a\\q";    // a backslash before q means nothing
const string PATH2 = "a\\\\q";  // right
```
""",
)

BROKEN_STRING = Rule(
    "IDL0114",
    "string over several lines",
    Severity.WARNING,
    """
A string holds a line break as it stands. It is taken, but other compilers refuse it: write `\\n`,
and split the string into pieces.

```idl
// gives this finding
const string A = "a
b";
```
""",
)

TRAILING_COMMA = Rule(
    "IDL0115",
    "comma behind the last enumerator",
    Severity.ERROR,
    """
Enumerators are separated by commas; there is none behind the last.

```idl
enum Colour { RED, GREEN, };   // wrong
enum Colour { RED, GREEN };    // right
```
""",
)

EMPTY_ENUM = Rule(
    "IDL0116",
    "enum without enumerators",
    Severity.ERROR,
    """
An enum or bitmask needs at least one member.

```idl
enum Mode { };               // wrong
enum Mode { MANUAL };        // right
```
""",
)

ENUMERATOR_VALUE = Rule(
    "IDL0117",
    "enumerator with a value",
    Severity.ERROR,
    """
Enumerators are numbered from 0 in their order; IDL has no `NAME = 3`. Where a number has to be
kept, IDL 4 has an annotation:

```idl
enum Mode { @value(1) MANUAL, @value(4) AUTOMATIC };
```
""",
)

MISSING_DIRECTION = Rule(
    "IDL0118",
    "parameter without direction",
    Severity.ERROR,
    """
Each parameter says which way it goes: `in`, `out` or `inout`.

```idl
void move(double distance);      // wrong
void move(in double distance);   // right
```
""",
)

EMPTY_RAISES = Rule(
    "IDL0119",
    "empty list of exceptions",
    Severity.ERROR,
    """
`raises()` names no exception. Leave the clause out if the operation raises none.

```idl
// gives this finding
interface I { void f() raises(); };
```
""",
)

TOO_MANY_FINDINGS = Rule(
    "IDL0120",
    "too many findings",
    Severity.WARNING,
    """
More than 1000 findings of one severity are not shown. Put right those that are, and run rtgen
again.

```text
robot.idl:1003:13: warning[IDL0120]: more than 1000 errors: the rest is not shown
```
""",
)

FOREIGN = Rule(
    "IDL0121",
    "construct of another language",
    Severity.ERROR,
    """
The word or mark belongs to C++, Java or another language; the hint says what IDL has instead.

```idl
struct Robot { std::string name; int count = 0; };   // wrong
struct Robot { string name; long count; };           // right
```

IDL declares data and interfaces only: it has no classes, bodies of operations, pointers, default
arguments, initial values, or access words. A struct holds data, an interface operations.
""",
)

MISPLACED = Rule(
    "IDL0122",
    "declaration that cannot stand here",
    Severity.ERROR,
    """
The body does not take declarations of this kind. Members belong into structs, unions and
exceptions; operations and attributes into interfaces; constants and typedefs into modules and
interfaces.

```idl
struct Arm { const long JOINTS = 6; double angle[JOINTS]; };       // wrong
const long JOINTS = 6;
struct Arm { double angle[JOINTS]; };                              // right
```
""",
)

BAD_ARRAY = Rule(
    "IDL0123",
    "array written another way",
    Severity.ERROR,
    """
Each dimension of an array stands in brackets of its own behind the name, and is a constant. A list
whose length varies is a sequence.

```idl
struct Pose { double[3] position; double cloud[]; };                 // wrong
struct Pose { double position[3]; sequence<double> cloud; };         // right
```
""",
)

MISSING_MARK = Rule(
    "IDL0124",
    "missing mark",
    Severity.ERROR,
    """
A parenthesis, a brace, a comma, or another mark is missing at the place shown, or another one
stands there.

```idl
enum Mode { MANUAL AUTOMATIC };                       // wrong
enum Mode { MANUAL, AUTOMATIC };                      // right
interface Arm { void stop() raises Failure; };        // wrong
interface Arm { void stop() raises (Failure); };      // right
```
""",
)

MISSING_WORD = Rule(
    "IDL0125",
    "missing name, type or value",
    Severity.ERROR,
    """
The declaration ends before it is whole: its name, its type or its value is missing.

```idl
struct Wheel { double; };          // wrong
struct Wheel { double radius; };   // right
```
""",
)

OTHER_LANGUAGE = Rule(
    "IDL0126",
    "another interface language",
    Severity.ERROR,
    """
Several languages are called IDL. The file holds what only another one has: Microsoft's or DCE's
(`[uuid(...)]`, `coclass`, `cpp_quote`), Web IDL (`dictionary`, `partial interface`, `Promise<T>`),
XPIDL (`[scriptable]`), or UNO's (`published`, `singleton`, `[attribute]`). Nothing else is told of
the file, and nothing is made of it. rtgen reads the IDL of OMG, which CORBA and DDS use; declare
the types there:

```idl
[uuid(5a3e9c1e-0000-4b5e-8d2a-000000000001)]
interface IArm { HRESULT Move([in] double angle); };    // Microsoft's IDL

interface Arm { void move(in double angle); };          // OMG's IDL
```
""",
)

RULES = (
    UNEXPECTED,
    MISSING_SEMICOLON,
    MISSPELT_KEYWORD,
    KEYWORD_AS_NAME,
    MISSING_NAME,
    UNCLOSED_BRACE,
    STRAY_BRACE,
    UNEXPECTED_END,
    UNCLOSED_TEXT,
    BAD_LITERAL,
    EXTRA_SEMICOLON,
    TOO_MANY,
    TOO_DEEP,
    UNKNOWN_ESCAPE,
    BROKEN_STRING,
    TRAILING_COMMA,
    EMPTY_ENUM,
    ENUMERATOR_VALUE,
    MISSING_DIRECTION,
    EMPTY_RAISES,
    TOO_MANY_FINDINGS,
    FOREIGN,
    MISPLACED,
    BAD_ARRAY,
    MISSING_MARK,
    MISSING_WORD,
    OTHER_LANGUAGE,
)
