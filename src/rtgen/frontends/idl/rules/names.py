"""Rules of names and scopes (IDL02xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_NAME = Rule(
    "IDL0200",
    "unknown name",
    Severity.ERROR,
    """
The name is declared nowhere before this place. IDL reads from top to bottom: declare a type
before it is used, or include the file that does. What depends on the unknown name is not
checked further, so one mistake gives one message.

```idl
struct Robot { Wheel left; };        // wrong: Wheel is declared later
struct Wheel { double radius; };
struct Robot2 { Wheel left; };       // right
```
""",
)

WRONG_CASE = Rule(
    "IDL0201",
    "name in the wrong case",
    Severity.ERROR,
    """
The name exists, but with other upper and lower case letters. Every use is spelt as the declaration
is (CORBA 2.6, 3.2.3).

```idl
// gives this finding
struct Position { long a; };
typedef position Place;
```
""",
)

REDECLARED = Rule(
    "IDL0202",
    "name declared twice",
    Severity.ERROR,
    """
A scope has each name once. Modules may be opened again; nothing else may. Attributes, operations
and types of an interface share one name space, and operations cannot be overloaded.

```idl
// gives this finding
struct S { long a; };
enum S { A };
```
""",
)

CASE_CLASH = Rule(
    "IDL0203",
    "names that differ in case only",
    Severity.ERROR,
    """
Two names of one scope may not differ in upper and lower case alone, since languages that
definitions
are compiled to may not tell them apart (CORBA 2.6, 3.2.3).

```idl
struct Pose { double x; double X; };   // wrong
```
""",
)

INTRODUCED = Rule(
    "IDL0204",
    "name already used in this scope with another meaning",
    Severity.ERROR,
    """
Using a name from an outer scope introduces it into the scope where it is used. Declaring the
same name there afterwards, in whatever case, is an error (CORBA 2.6, 3.15.3):

```idl
struct Path { long n; };
struct Plan { Path path; };           // wrong: Path is introduced into Plan, path clashes
struct Plan2 { ::Path path; };        // right: absolute names introduce nothing
```
""",
)

SAME_AS_SCOPE = Rule(
    "IDL0205",
    "name of the scope around it",
    Severity.ERROR,
    """
A name cannot be declared again directly inside the scope of that name (CORBA 2.6, 3.15.2).

```idl
interface Motor { void motor(); };   // wrong
```
""",
)

KEYWORD_CASE = Rule(
    "IDL0206",
    "name like a keyword",
    Severity.ERROR,
    """
An identifier may not differ from a keyword in upper and lower case alone. With a leading
underscore, which is not part of the name, it may:

```idl
struct S { long Object_; long _Struct; };
```
""",
)

BAD_IDENTIFIER = Rule(
    "IDL0207",
    "malformed identifier",
    Severity.ERROR,
    """
An identifier is an ASCII letter, then ASCII letters, digits and underscores. One leading underscore
escapes it; two are too many.

```idl
// gives this finding
struct __S { long größe; };
```
""",
)

CORBA_3_WORD = Rule(
    "IDL0208",
    "keyword of CORBA 3 as a name",
    Severity.WARNING,
    """
The name is a keyword of CORBA 3. It is taken as a name here, but a compiler for CORBA 3 refuses it.
With a leading underscore, which is not part of the name, every compiler takes it.

```idl
// gives this finding
struct component { long a; };
```
""",
)

NOT_A_SCOPE = Rule(
    "IDL0209",
    "not a scope",
    Severity.ERROR,
    """
Only modules, interfaces, valuetypes, structs, unions and exceptions have names inside them that can
be reached with `::`.

```idl
// gives this finding
typedef long T;
struct S { T::U a; };
```
""",
)

NOT_A_TYPE = Rule(
    "IDL0210",
    "not a type",
    Severity.ERROR,
    """
The name stands for something that cannot be a type: a module, a constant, an operation, or an
exception, which can only be raised.

```idl
// gives this finding
exception E {};
struct S { E a; };
```
""",
)

NOT_A_VALUE = Rule(
    "IDL0211",
    "not a constant",
    Severity.ERROR,
    """
A constant expression takes constants and enumerators. The name stands for something else.

```idl
// gives this finding
struct S { long a; };
const long A = S;
```
""",
)

AMBIGUOUS = Rule(
    "IDL0212",
    "ambiguous inherited name",
    Severity.ERROR,
    """
Two bases declare the name, so it has two meanings here. Say which is meant: `Base::Name`.

```idl
// gives this finding
interface A { typedef long T; };
interface B { typedef long T; };
interface C : A, B { attribute T t; };
```
""",
)

ENUM_SCOPE = Rule(
    "IDL0213",
    "enumerator with the name of its enum",
    Severity.WARNING,
    """
Enumerators live in the scope that holds the enum: write `RED`, not `Colour::RED`. It is taken,
since
it is clear what is meant, but other compilers refuse it.

```idl
// gives this finding
enum E { A };
const E X = E::A;
```
""",
)

FORWARD_MISMATCH = Rule(
    "IDL0214",
    "declarations that do not agree",
    Severity.ERROR,
    """
A forward declaration and the definition are of one kind (struct, union, interface ...), agree in
`abstract` and `local`, and lie under one `#pragma prefix`.

```idl
abstract interface Motor;
interface Motor { void start(); };              // wrong: abstract above, not here
abstract interface Arm;
abstract interface Arm { void move(); };        // right
```
""",
)

NEVER_DEFINED = Rule(
    "IDL0215",
    "declared, but never defined",
    Severity.ERROR,
    """
A struct or union is declared in advance, and nothing defines it.

```idl
// gives this finding
struct S;
```
""",
)

NEVER_DEFINED_INTERFACE = Rule(
    "IDL0216",
    "interface declared, but never defined",
    Severity.WARNING,
    """
An interface or valuetype is declared in advance, and nothing that was read defines it. It can be
used as a reference only.

```idl
// gives this finding
interface I;
```
""",
)

TWO_DEFINITIONS = Rule(
    "IDL0217",
    "two definitions of one name in a project",
    Severity.ERROR,
    """
Files that do not include each other declare the same name differently. What is made from all of
them together would hold the name once. Rename one, or move the declaration to a file that both
include. Where both say the same, the first one counts.

```idl
struct Pose { double x; };           // in a.idl
struct Pose { double x, y; };        // in b.idl, which does not include a.idl
```
""",
)

DECLARED_ALIKE = Rule(
    "IDL0218",
    "type declared alike in two files",
    Severity.NOTE,
    """
Two files give one name to one type, as the files that ROS 2 generates do for their arrays
(`typedef double double__36[36];`). The first declaration counts. CORBA compilers refuse the
second.

```idl
// gives this finding
#include "first.idl"
module Robot {
    typedef double Matrix[2][3];
    typedef long Row[3];
    struct Frame { Matrix axes; Row labels; };
};
```
""",
)

CONSTANT_AS_TYPE = Rule(
    "IDL0219",
    "constant used as a type",
    Severity.WARNING,
    """
A constant stands where a type is wanted. omniidl takes the type of the constant, and so does
rtgen; other compilers refuse it. Name the type itself.

```idl
const long SIZE = 3;
struct Frame { SIZE data; };         // odd: a long
struct Frame { long data[SIZE]; };   // right, if an array was meant
```
""",
)

RULES = (
    UNKNOWN_NAME,
    WRONG_CASE,
    REDECLARED,
    CASE_CLASH,
    INTRODUCED,
    SAME_AS_SCOPE,
    KEYWORD_CASE,
    BAD_IDENTIFIER,
    CORBA_3_WORD,
    NOT_A_SCOPE,
    NOT_A_TYPE,
    NOT_A_VALUE,
    AMBIGUOUS,
    ENUM_SCOPE,
    FORWARD_MISMATCH,
    NEVER_DEFINED,
    NEVER_DEFINED_INTERFACE,
    TWO_DEFINITIONS,
    DECLARED_ALIKE,
    CONSTANT_AS_TYPE,
)
