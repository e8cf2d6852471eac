"""Mistakes in structs, unions, enums and exceptions, and their members."""

from mistake import Mistake, unknown

STRUCTS: dict[str, Mistake] = {
    "struct keyword in type": (
        "struct P { long a; };\nstruct S { §struct P p_; };",
        "IDL0121: a type is named without 'struct'",
        "write P p_",
    ),
    "enum keyword in type": (
        "enum E { A };\nstruct S { §enum E e_; };",
        "IDL0121: a type is named without 'enum'",
        "write E e_",
    ),
    "optional question": (
        "struct S { long§? a; };",
        "IDL0004: the character '?' is not allowed here",
        "IDL has no conditional expressions; an optional member is marked @optional",
    ),
    "initialiser": (
        "struct S { long a §= 1; };",
        "IDL0121: members have no initial values in IDL",
        "leave the value out, or write @default(VALUE) before the member",
    ),
    "bitfield": (
        "struct S { long a §: 3; };",
        "IDL0121: members of a struct have no width in bits",
        "bit fields belong in a bitset: bitfield<3> NAME;",
    ),
    "trailing comma": (
        "enum E { A, B§, };",
        "IDL0115: no comma after the last enumerator",
        "remove the ','",
    ),
    "enum value": (
        "enum E { A = §1, B };",
        "IDL0117: A cannot be given a value so",
        "write @value(...) A",
    ),
    "enum values": (
        "enum E { A = §1, B = 2, C = 3 };",
        "IDL0117: A cannot be given a value so",
        "write @value(...) A",
    ),
    "enum semicolons": (
        "enum E { A§; B; };",
        "IDL0124: a ',' is expected here, not a ';'",
        "enumerators are separated by ','; the last has none",
    ),
    "enum missing comma": (
        "enum E { A§ B };",
        "IDL0124: a ',' is missing here",
        "enumerators are separated by ','",
    ),
    "enum empty": (
        "enum §E {};",
        "IDL0116: E has no members",
        "write at least one name between { and }",
    ),
    "enum class": (
        "§enum class E { A };",
        "IDL0121: IDL has no 'enum class'",
        "leave the word out",
    ),
    "enum quoted": (
        'enum E { §"A" };',
        "IDL0100: '\"A\"' is not allowed here: '}', a name or an annotation was expected",
        "names are allowed here, separated by ','",
    ),
    "enum : type": (
        "enum E §: long { A };",
        "IDL0121: an enum names no type for its values in IDL",
        "leave it out, or write @bit_bound(BITS) before the enum",
    ),
    "missing tag": (
        "typedef struct §{ long a; } S;",
        "IDL0104: the struct has no name",
        "write 'struct Name { ... }'",
    ),
    "anonymous struct member": (
        "struct S { struct §{ long a; } inner; };",
        "IDL0104: the struct has no name",
        "write 'struct Name { ... }'",
    ),
    "anonymous union": (
        "struct S { union §{ long a; } inner; };",
        "IDL0104: the union has no name",
        "write 'union Name { ... }'",
    ),
    "anonymous enum": (
        "typedef enum §{ A, B } E;",
        "IDL0104: the enum has no name",
        "write 'enum Name { ... }'",
    ),
    "c typedef struct": (
        "typedef struct tag { long a; } §tag;",
        "IDL0202: tag is declared twice",
        "write 'struct tag { ... };' without typedef",
    ),
    "public: in struct": (
        "struct S { §public: long a; };",
        "IDL0121: IDL has no 'public:'",
        "remove it: members of structs and interfaces are public",
    ),
    "private member in struct": (
        "struct S { §private long a; };",
        "IDL0122: 'private' is not allowed in a struct",
        "leave it out, or make this a valuetype",
    ),
    "const in struct": (
        "struct S { §const long A = 1; long b; };",
        "IDL0122: a constant is not allowed in a struct",
        "put it before the struct",
    ),
    "const member": (
        "struct S { §const long a; };",
        "IDL0122: a constant is not allowed in a struct",
        "put it before the struct",
    ),
    "method in struct": (
        "struct S { long a; void f§(); };",
        "IDL0122: an operation is not allowed in a struct",
        "put it into an interface",
    ),
    "exception type": (
        "exception E {}; struct S { §E a; };",
        "IDL0210: the exception E can only be raised",
        "put its contents into a struct",
    ),
    "exception sequence": (
        "exception E {}; typedef sequence<§E> Es;",
        "IDL0210: the exception E can only be raised",
        "put its contents into a struct",
    ),
    "duplicate member": (
        "struct S { long a; double §a; };",
        "IDL0202: a is declared twice",
        "rename one of them",
    ),
    "duplicate label": (
        "union U switch (long) { case 1: long a; §case 1: long b; };",
        "IDL0401: this label is given twice",
        "remove one, or correct its value",
    ),
    "duplicate enumerator": (
        "enum E { A, §A };",
        "IDL0202: A is declared twice",
        "rename one of them",
    ),
    "enumerator of other enum": (
        "enum E { OK }; enum F { §OK };",
        "IDL0202: OK is declared twice",
        "enumerators stand beside their enum: rename one, or give each enum a module",
    ),
    "missing case": (
        "union U switch (long) { §1: long a; };",
        "IDL0100: 'case' is missing here",
        "write 'case VALUE: TYPE NAME;'",
    ),
    "case without colon": (
        "union U switch (long) { case 1§ long a; };",
        "IDL0124: a ':' is missing here",
        "put ':' after '1'",
    ),
    "missing switch": (
        "union U§ { case 1: long a; };",
        "IDL0125: 'switch (TYPE)' is missing here",
        "a union selects its branches by a value: union U switch (long) { case 1: ... }",
    ),
    "switch without parens": (
        "union U switch§ long { case 1: long a; };",
        "IDL0124: a '(' is missing here",
        "put '(' after 'switch'",
    ),
    "switch with name": (
        "union U switch (long §d) { case 1: long a; };",
        "IDL0100: the switch of a union has no name",
        "write switch (long)",
    ),
    "default colon": (
        "union U switch (long) { case 1: long a; default§ long b; };",
        "IDL0124: a ':' is missing here",
        "put ':' after 'default'",
    ),
    "union without case": (
        "union U switch (long) { §long a; };",
        "IDL0100: a branch begins with 'case VALUE:'",
        "write 'case VALUE: TYPE NAME;'",
    ),
    "recursive": (
        "struct S { §S next; };",
        "IDL0300: S cannot hold itself",
        "use a sequence: 'struct S;' and 'typedef sequence<S> ...;' before it",
    ),
    "mutual": unknown(
        "struct A { §B b_; };\nstruct B { A a_; };",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "attribute in struct": (
        "struct S { §attribute long a; };",
        "IDL0122: 'attribute' is not allowed in a struct",
        "attributes and operations belong into an interface",
    ),
    "union switch enum literal": (
        "enum E { A }; union U switch (E) { case §1: long a; };",
        "IDL0500: an enumerator is expected here, not an integer",
        "write the name of an enumerator",
    ),
    "union bool label": unknown(
        "union U switch (boolean) { case §true: long a; };",
        "the boolean constants are TRUE and FALSE",
    ),
    "missing type": (
        "struct S { §a; };",
        "IDL0125: a has no type, or no name",
        "write 'TYPE a;' or 'a NAME;'",
    ),
    "missing name": (
        "struct S { long§; };",
        "IDL0125: a name is missing here",
        "a declaration has a type and a name: long count",
    ),
    "dds key": (
        "struct S { §key long a; };",
        "IDL0121: IDL has no 'key'",
        "write @key before the member",
    ),
    "annotation typo": (
        "struct S { §@optionl long a; };",
        "IDL0800: @optionl is not known",
        "did you mean @optional?",
    ),
    "annotation word": (
        "@extensibility(§MUTBLE) struct S { long a; };",
        "IDL0802: @extensibility cannot be MUTBLE",
        "did you mean MUTABLE? It is one of FINAL, APPENDABLE, MUTABLE",
    ),
    "annotation words": (
        "@data_representation(XCDR2 | §XDCR1) struct S { long a; };",
        "IDL0802: @data_representation cannot be XDCR1",
        "did you mean XCDR1? It is one of XCDR, XCDR1, XCDR2, XML",
    ),
    "annotation placement": (
        '@verbatim(placement = §BEGIN_FIL, text = "x") struct S { long a; };',
        "IDL0802: @verbatim cannot be BEGIN_FIL",
        "did you mean BEGIN_FILE? It is one of BEGIN_FILE, BEFORE_DECLARATION,"
        " BEGIN_DECLARATION, END_DECLARATION, AFTER_DECLARATION, END_FILE",
    ),
    "annotation far word": (
        "@autoid(§SOMEHOW) struct S { long a; };",
        "IDL0802: @autoid cannot be SOMEHOW",
        "write one of SEQUENTIAL, HASH",
    ),
    "default enumerator": (
        "enum E { HOT, COLD }; struct S { @default(§CLOD) E a; };",
        "IDL0200: CLOD is unknown",
        "did you mean COLD?",
    ),
    "default truth": (
        "struct S { @default(§TRU) boolean a; };",
        "IDL0200: TRU is unknown",
        "did you mean TRUE?",
    ),
    "annotation []": (
        "struct S { §[Key] long a; };",
        "IDL0121: annotations are not written in brackets",
        "write @name",
    ),
}
