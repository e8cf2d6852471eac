"""Missing, wrong and repeated punctuation: semicolons, commas, braces, parentheses."""

from mistake import Mistake

SEMICOLON = ("IDL0101: a ';' is missing here", "put ';' at the end of the declaration")
STRUCT_BRACE = (
    "IDL0105: this '{' of struct S is not closed",
    "put '};' before 'struct'",
)

PUNCTUATION: dict[str, Mistake] = {
    "semicolon: member": ("struct S { long a§ };", *SEMICOLON),
    "semicolon: member before member": (
        "struct S {\n    long a§\n    long b;\n};",
        *SEMICOLON,
    ),
    "semicolon: member of named type before member": (
        "struct P { long x; };\nstruct S {\n    P a§\n    P b;\n};",
        *SEMICOLON,
    ),
    "semicolon: member comment": (
        "struct S {\n    long a§  // first\n    long b;\n};",
        *SEMICOLON,
    ),
    "semicolon: same line": ("struct S { long a§ long b; };", *SEMICOLON),
    "semicolon: struct": ("struct S { long a; }§\nstruct T { long b; };", *SEMICOLON),
    "semicolon: struct end of file": ("struct S { long a; }§\n", *SEMICOLON),
    "semicolon: struct in module": ("module M { struct S { long a; }§ };", *SEMICOLON),
    "semicolon: module": (
        "module M { struct S { long a; }; }§\nmodule N { struct T { long a; }; };",
        *SEMICOLON,
    ),
    "semicolon: typedef": ("typedef sequence<long> L§\nstruct S { L a; };", *SEMICOLON),
    "semicolon: typedef before typedef": (
        "typedef long A§\ntypedef long B;",
        *SEMICOLON,
    ),
    "semicolon: operation": (
        "interface I {\n    void f()§\n    void g();\n};",
        *SEMICOLON,
    ),
    "semicolon: operation named": (
        "struct P { long x; };\ninterface I {\n    void f()§\n    P g();\n};",
        *SEMICOLON,
    ),
    "semicolon: operation raises": (
        "exception E {};\ninterface I {\n    void f() raises (E)§\n    void g();\n};",
        *SEMICOLON,
    ),
    "semicolon: attribute": (
        "interface I {\n    attribute long a§\n    void g();\n};",
        *SEMICOLON,
    ),
    "semicolon: interface": (
        "interface I { void f(); }§\ninterface J { void g(); };",
        *SEMICOLON,
    ),
    "semicolon: forward": (
        "interface I§\ninterface J { void g(); };\ninterface I {};",
        *SEMICOLON,
    ),
    "semicolon: enum": ("enum E { A, B }§\nstruct S { E x; };", *SEMICOLON),
    "semicolon: const": ("const long A = 1§\nconst long B = 2;", *SEMICOLON),
    "semicolon: const text": (
        'const string A = "a"§\nconst string B = "b";',
        *SEMICOLON,
    ),
    "semicolon: union branch": (
        "union U switch (long) {\n    case 1: long a§\n    case 2: long b;\n};",
        *SEMICOLON,
    ),
    "semicolon: union": (
        "union U switch (long) { case 1: long a; }§\nstruct S { U u_; };",
        *SEMICOLON,
    ),
    "semicolon: exception": ("exception E { long a; }§\ninterface I {};", *SEMICOLON),
    "semicolon: before include": (
        'struct S { long a; }§\n#include "wheel.idl"\nstruct T { Wheel w; };',
        *SEMICOLON,
    ),
    "semicolon: valuetype": (
        "valuetype V { public long a; }§\nstruct S { long a; };",
        *SEMICOLON,
    ),
    "semicolon: array": ("struct S {\n  long a[3]§\n  long b;\n};", *SEMICOLON),
    "comma for semicolon": (
        "struct S { long a§, };",
        "IDL0101: a ';' is expected here, not a ','",
        "a ',' separates names of one type; each declaration ends with ';'",
    ),
    "comma for semicolon 2": (
        "struct S {\n long a§,\n long b;\n};",
        "IDL0101: a ';' is expected here, not a ','",
        "a ',' separates names of one type; each declaration ends with ';'",
    ),
    "colon for semicolon": (
        "struct S { long a§: long b; };",
        "IDL0101: a ';' is expected here, not a ':'",
        "each member ends with ';'",
    ),
    "extra semicolon": (
        "struct S { long a;§; };",
        "IDL0110: this ';' ends nothing",
        "remove it",
    ),
    "missing close brace": (
        "module M §{\n    struct S { long a; };\n",
        "IDL0105: this '{' of module M is never closed",
        "put '};' where it ends",
    ),
    "missing close brace struct": (
        "struct S §{\n    long a;\nstruct T { long b; };",
        *STRUCT_BRACE,
    ),
    "missing close brace struct module": (
        "module M {\nstruct S §{\n    long a;\nstruct T { long b; };\n};",
        *STRUCT_BRACE,
    ),
    "missing close brace struct, interface follows": (
        "struct S §{\n    long a;\ninterface I { void f(); };",
        "IDL0105: this '{' of struct S is not closed",
        "put '};' before 'interface'",
    ),
    "missing close brace interface": (
        "interface I §{\n    void f();\ninterface J { void g(); };",
        "IDL0105: this '{' of interface I is not closed",
        "put '};' before 'interface'",
    ),
    "missing close brace interface in module": (
        "module M {\n interface I §{\n    void f();\n interface J { void g(); };\n};",
        "IDL0105: this '{' of interface I is not closed",
        "put '};' before 'interface'",
    ),
    "missing open brace": (
        "struct S§\n    long a;\n};",
        "IDL0124: a '{' is missing here",
        "put '{' after 'S'",
    ),
    "missing open brace interface": (
        "interface I§\n    void f();\n};",
        "IDL0124: a '{' is missing here",
        "put '{' after 'I'",
    ),
    "extra brace": (
        "struct S { long a; };\n§};",
        "IDL0106: this '}' closes nothing",
        "remove it, or add the '{' that is missing before it",
    ),
    "missing paren": (
        "interface I { void f(in long a§; };",
        "IDL0124: a ')' is missing here",
        "close the list of parameters",
    ),
    "missing open paren": (
        "interface I { void f§ in long a); };",
        "IDL0124: a '(' is missing here",
        "put '(' after 'f'",
    ),
    "missing >": (
        "typedef sequence<long§ L;",
        "IDL0124: a '>' is missing here",
        "put '>' after 'long'",
    ),
    "extra >": (
        "typedef sequence<long>§> L;",
        "IDL0100: this '>' closes nothing",
        "remove it",
    ),
    "missing <": (
        "typedef sequence§ long> L;",
        "IDL0124: a '<' is missing here",
        "put '<' after 'sequence'",
    ),
    "semicolon after brace": (
        "struct S {§; long a; };",
        "IDL0110: this ';' ends nothing",
        "remove it",
    ),
    "semicolon before brace": (
        "struct S§; { long a; };",
        "IDL0100: this ';' cuts the body off",
        "remove it",
    ),
    "double comma": (
        "struct S { long a,§, b; };",
        "IDL0125: a name is missing here",
        "remove one ',', or write a name",
    ),
    "comma leading": (
        "interface I { void f(in long a, §); };",
        "IDL0125: a parameter is missing here",
        "remove the ',', or write a parameter after it",
    ),
    "annotation unclosed": (
        "struct S { @id(3§ long a; };",
        "IDL0124: a ')' is missing here",
        "close the parenthesis",
    ),
    "end without brace": (
        "module M {\n    struct S { long a; };\n§;\nstruct T { long b; };",
        "IDL0124: a '}' is missing before this ';'",
        "write '};'",
    ),
    "end of an enum without brace": (
        "enum E {\n    A,\n    B\n§;\nstruct T { E b; };",
        "IDL0124: a '}' is missing before this ';'",
        "write '};'",
    ),
    "opening brace twice": (
        "struct S {§{ long a; };\nstruct T { S b; };",
        "IDL0100: this '{' is one too many",
        "remove it",
    ),
    "closing brace twice": (
        "struct S { long a; }§};\nstruct T { S b; };",
        "IDL0100: this '}' is one too many",
        "remove it",
    ),
    "closing brace twice in module": (
        "module M { struct S { long a; }§}; struct T { S b; }; };",
        "IDL0100: this '}' is one too many",
        "remove it",
    ),
    "word twice": (
        "struct S { long a §a; };",
        "IDL0100: 'a' is repeated",
        "remove one",
    ),
    "type twice": (
        "struct S { double §double a; };",
        "IDL0100: 'double' is repeated",
        "remove one",
    ),
    "enumerator twice": (
        "enum E { A §A, B };",
        "IDL0100: 'A' is repeated",
        "remove one",
    ),
    "missing close brace struct, semicolon left": (
        "module M {\nstruct S §{\n    long a;\n;\nstruct T { long b; };\n};",
        *STRUCT_BRACE,
    ),
    "missing comma in typedef": (
        "typedef long A §B, C;\nstruct S { A x; };",
        "IDL0100: 'B' is not allowed here: A is the name already",
        "write A_B if that is one name",
    ),
    "missing open brace of annotated": (
        "@nested\nstruct S§\n    long a;\n};",
        "IDL0124: a '{' is missing here",
        "put '{' after 'S'",
    ),
}
