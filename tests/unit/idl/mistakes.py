"""The commonest errors: each gives one message, at the place marked §, and a hint.

Beside each definition lie `wheel.idl`, which declares Wheel, and `axle.idl`, whose last `;` is
missing.
"""

MISTAKES: dict[str, tuple[str, str, str]] = {
    "semicolon: member": (
        "struct S { long a§ };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: member before member": (
        "struct S {\n    long a§\n    long b;\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: member of named type before member": (
        "struct P { long x; };\nstruct S {\n    P a§\n    P b;\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: member comment": (
        "struct S {\n    long a§  // first\n    long b;\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: same line": (
        "struct S { long a§ long b; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: struct": (
        "struct S { long a; }§\nstruct T { long b; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: struct end of file": (
        "struct S { long a; }§\n",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: struct in module": (
        "module M { struct S { long a; }§ };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: module": (
        "module M { struct S { long a; }; }§\nmodule N { struct T { long a; }; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: typedef": (
        "typedef sequence<long> L§\nstruct S { L a; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: typedef before typedef": (
        "typedef long A§\ntypedef long B;",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: operation": (
        "interface I {\n    void f()§\n    void g();\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: operation named": (
        "struct P { long x; };\ninterface I {\n    void f()§\n    P g();\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: operation raises": (
        "exception E {};\ninterface I {\n    void f() raises (E)§\n    void g();\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: attribute": (
        "interface I {\n    attribute long a§\n    void g();\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: interface": (
        "interface I { void f(); }§\ninterface J { void g(); };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: forward": (
        "interface I§\ninterface J { void g(); };\ninterface I {};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: enum": (
        "enum E { A, B }§\nstruct S { E x; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: const": (
        "const long A = 1§\nconst long B = 2;",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: const text": (
        'const string A = "a"§\nconst string B = "b";',
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: union branch": (
        "union U switch (long) {\n    case 1: long a§\n    case 2: long b;\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: union": (
        "union U switch (long) { case 1: long a; }§\nstruct S { U u_; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: exception": (
        "exception E { long a; }§\ninterface I {};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: before include": (
        'struct S { long a; }§\n#include "wheel.idl"\nstruct T { Wheel w; };',
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: valuetype": (
        "valuetype V { public long a; }§\nstruct S { long a; };",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "semicolon: array": (
        "struct S {\n  long a[3]§\n  long b;\n};",
        "IDL0101: a ';' is missing here",
        "put ';' at the end of the declaration",
    ),
    "comma for semicolon": (
        "struct S { long a§, };",
        "IDL0101: a ';' is wanted here, not a ','",
        "a ',' separates names of one type; each declaration ends with ';'",
    ),
    "comma for semicolon 2": (
        "struct S {\n long a§,\n long b;\n};",
        "IDL0101: a ';' is wanted here, not a ','",
        "a ',' separates names of one type; each declaration ends with ';'",
    ),
    "colon for semicolon": (
        "struct S { long a§: long b; };",
        "IDL0101: a ';' is wanted here, not a ':'",
        "each member ends with ';'",
    ),
    "extra semicolon": (
        "struct S { long a;§; };",
        "IDL0110: this ';' ends nothing",
        "remove it",
    ),
    "direction": (
        "interface I { void f(§long a); };",
        "IDL0118: the parameter a has no direction",
        "put in, out or inout before its type",
    ),
    "direction second": (
        "interface I { void f(in long a, §long b); };",
        "IDL0118: the parameter b has no direction",
        "put in, out or inout before its type",
    ),
    "direction after": (
        "interface I { void f(long §in a); };",
        "IDL0100: 'in' belongs before the type of the parameter",
        "write 'in TYPE NAME'",
    ),
    "direction ref": (
        "interface I { void f(in long §&a); };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "direction const ref": (
        "interface I { void f(in §const string a); };",
        "IDL0121: IDL has no 'const' here",
        "leave the word out: IDL passes values",
    ),
    "in out": (
        "interface I { void f(in §out long a); };",
        "IDL0100: 'in' and 'out' cannot be combined",
        "a parameter has one direction: in, out or inout",
    ),
    "parameter without name": (
        "interface I { void f(in long§); };",
        "IDL0125: the name of the parameter is missing here",
        "parameters have a direction, a type and a name: in long count",
    ),
    "void parameter": (
        "interface I { void f(§void); };",
        "IDL0125: an operation without parameters has nothing between ( and )",
        "write ()",
    ),
    "strcut": (
        "§strcut S { long a; };",
        "IDL0102: 'strcut' is not known here",
        "did you mean 'struct'?",
    ),
    "interace": (
        "§interace I { void f(); };",
        "IDL0102: 'interace' is not known here",
        "did you mean 'interface'?",
    ),
    "modul": (
        "§modul M { struct S { long a; }; };",
        "IDL0102: 'modul' is not known here",
        "did you mean 'module'?",
    ),
    "sequnce": (
        "typedef §sequnce<long> L;",
        "IDL0102: 'sequnce' is not known here",
        "did you mean 'sequence'?",
    ),
    "sequnce member": (
        "struct S { §sequnce<long> l; };",
        "IDL0102: 'sequnce' is not known here",
        "did you mean 'sequence'?",
    ),
    "unsinged": (
        "struct S { §unsinged long a; };",
        "IDL0102: 'unsinged' is not known here",
        "did you mean 'unsigned'?",
    ),
    "unsinged typedef": (
        "typedef §unsinged long A;",
        "IDL0102: 'unsinged' is not known here",
        "did you mean 'unsigned'?",
    ),
    "typdef": (
        "§typdef long A;",
        "IDL0102: 'typdef' is not known here",
        "did you mean 'typedef'?",
    ),
    "exeption": (
        "§exeption E { string why; };",
        "IDL0102: 'exeption' is not known here",
        "did you mean 'exception'?",
    ),
    "enumm": (
        "§enumm E { A };",
        "IDL0102: 'enumm' is not known here",
        "did you mean 'enum'?",
    ),
    "attribut": (
        "interface I { §attribut long a; };",
        "IDL0102: 'attribut' is not known here",
        "did you mean 'attribute'?",
    ),
    "readonly": (
        "interface I { §readony attribute long a; };",
        "IDL0102: 'readony' is not known here",
        "did you mean 'readonly'?",
    ),
    "oneway misspelt": (
        "interface I { §onway void f(); };",
        "IDL0102: 'onway' is not known here",
        "did you mean 'oneway'?",
    ),
    "rises": (
        "exception E {}; interface I { void f() §rises (E); };",
        "IDL0102: 'rises' is not known here",
        "did you mean 'raises'?",
    ),
    "raise": (
        "exception E {}; interface I { void f() §raise (E); };",
        "IDL0102: 'raise' is not known here",
        "did you mean 'raises'?",
    ),
    "throws": (
        "exception E {}; interface I { void f() §throws (E); };",
        "IDL0121: IDL has no 'throws'",
        "write raises (NAME)",
    ),
    "inn": (
        "interface I { void f(§inn long a); };",
        "IDL0102: 'inn' is not known here",
        "did you mean 'in'?",
    ),
    "swich": (
        "union U §swich (long) { case 1: long a; };",
        "IDL0102: 'swich' is not known here",
        "did you mean 'switch'?",
    ),
    "cas": (
        "union U switch (long) { §cas 1: long a; };",
        "IDL0102: 'cas' is not known here",
        "did you mean 'case'?",
    ),
    "defalt": (
        "union U switch (long) { case 1: long a; §defalt: long b; };",
        "IDL0102: 'defalt' is not known here",
        "did you mean 'default'?",
    ),
    "cnst": (
        "§cnst long A = 1;",
        "IDL0102: 'cnst' is not known here",
        "did you mean 'const'?",
    ),
    "abstrct": (
        "§abstrct interface I {};",
        "IDL0102: 'abstrct' is not known here",
        "did you mean 'abstract'?",
    ),
    "valuetyp": (
        "§valuetyp V { public long a; };",
        "IDL0102: 'valuetyp' is not known here",
        "did you mean 'valuetype'?",
    ),
    "typo type": (
        "struct S { §duoble a; };",
        "IDL0200: duoble is unknown",
        "did you mean double?",
    ),
    "typo type strng": (
        "struct S { §strng a; };",
        "IDL0200: strng is unknown",
        "did you mean string?",
    ),
    "typo type bolean": (
        "struct S { §bolean a; };",
        "IDL0200: bolean is unknown",
        "did you mean boolean?",
    ),
    "type like a parameter": (
        "interface I { void f(in §B b); };",
        "IDL0200: B is unknown",
        "declare it before its use, or include the file that declares it",
    ),
    "typo user": (
        "struct Position { long a; };\nstruct S { §Positon p; };",
        "IDL0200: Positon is unknown",
        "did you mean Position?",
    ),
    "case keyword Struct": (
        "§Struct S { long a; };",
        "IDL0102: 'Struct' is not known here",
        "did you mean 'struct'?",
    ),
    "case MODULE": (
        "§MODULE M { struct S { long a; }; };",
        "IDL0102: 'MODULE' is not known here",
        "did you mean 'module'?",
    ),
    "case Long": (
        "struct S { §Long a; };",
        "IDL0200: Long is unknown",
        "did you mean the keyword 'long'?",
    ),
    "case String": (
        "struct S { §String a; };",
        "IDL0200: String is unknown",
        "did you mean the keyword 'string'?",
    ),
    "case Boolean": (
        "struct S { §Boolean a; };",
        "IDL0200: Boolean is unknown",
        "did you mean the keyword 'boolean'?",
    ),
    "case object": (
        "interface I { void f(in §object o); };",
        "IDL0200: object is unknown",
        "did you mean the keyword 'Object'?",
    ),
    "case type": (
        "struct Position { long a; };\nstruct S { §position p; };",
        "IDL0201: position is declared as Position",
        "write Position",
    ),
    "case Void": (
        "interface I { §Void f(); };",
        "IDL0200: Void is unknown",
        "did you mean the keyword 'void'?",
    ),
    "case In": (
        "interface I { void f(§In long a); };",
        "IDL0102: 'In' is not known here",
        "did you mean 'in'?",
    ),
    "case Any": (
        "struct S { §Any a; };",
        "IDL0200: Any is unknown",
        "did you mean the keyword 'any'?",
    ),
    "1.0f": (
        "const float A = §1.0f;",
        "IDL0109: 1.0f ends with 'f'",
        "write 1.0",
    ),
    "10L": (
        "const long A = §10L;",
        "IDL0109: 10L ends with 'L'",
        "write 10",
    ),
    "0x10u": (
        "const long A = §0x10u;",
        "IDL0109: 0x10u ends with 'u'",
        "write 0x10",
    ),
    "1'000": (
        "const long A = 1§'000;",
        "IDL0109: this character literal is not closed",
        "a character literal is enclosed in ', as in 'x'",
    ),
    "true": (
        "const boolean A = §true;",
        "IDL0200: true is unknown",
        "the boolean constants are TRUE and FALSE",
    ),
    "True": (
        "const boolean A = §True;",
        "IDL0200: True is unknown",
        "the boolean constants are TRUE and FALSE",
    ),
    "false": (
        "const boolean A = §false;",
        "IDL0200: false is unknown",
        "the boolean constants are TRUE and FALSE",
    ),
    "0b1": (
        "const long A = §0b101;",
        "IDL0109: 0b101 is not a number",
        "write 5 or 0x5",
    ),
    "089": (
        "const long A = §089;",
        "IDL0109: 089 begins with 0, so it is octal, but holds an 8 or a 9",
        "write 89",
    ),
    "unclosed comment inside a struct": (
        "module M {\nstruct S { long a; §/* the first\n long b; };\n};",
        "IDL0007: this comment is never closed",
        "comments do not nest; close it with */",
    ),
    "missing endif inside a struct": (
        "struct S {\n§#ifdef X\n    long a;\n};\nstruct T { S a; };",
        "IDL0013: this conditional is never closed",
        "add #endif at the end of the file",
    ),
    "unclosed comment": (
        "struct S { long a; };\n§/* never",
        "IDL0007: this comment is never closed",
        "comments do not nest; close it with */",
    ),
    "unclosed string": (
        'const string A = §"abc;',
        "IDL0108: this string is never closed",
        'put " at its end',
    ),
    "unclosed char": (
        "const char A = §'a;",
        "IDL0109: this character literal is not closed",
        "a character literal is enclosed in ', as in 'x'",
    ),
    "long char": (
        "const char A = §'ab';",
        "IDL0109: a character literal holds one character, not 2 characters",
        'strings are written as "..."',
    ),
    "string for char": (
        'const char A = §"a";',
        "IDL0500: a character is wanted here, not a string",
        "write one character in single quotes, such as 'x'",
    ),
    "char for string": (
        "const string A = §'a';",
        "IDL0500: a string is wanted here, not a character",
        'write text in double quotes, such as "text"',
    ),
    "string for wstring": (
        'const wstring A = §"a";',
        "IDL0500: a wide string is wanted here, not a string",
        "wide literals begin with L, others do not",
    ),
    "wstring for string": (
        'const string A = §L"a";',
        "IDL0500: a string is wanted here, not a wide string",
        "wide literals begin with L, others do not",
    ),
    "char for wchar": (
        "const wchar A = §'a';",
        "IDL0500: a wide character is wanted here, not a character",
        "wide literals begin with L, others do not",
    ),
    "int for float": (
        "const double A = §1;",
        "IDL0507: a floating-point number is wanted here",
        "write 1.0",
    ),
    "float for int": (
        "const long A = §1.5;",
        "IDL0500: an integer is wanted here, not a floating-point number",
        "write a number without point, or make the type double",
    ),
    "int for boolean": (
        "const boolean A = §1;",
        "IDL0500: a boolean is wanted here, not an integer",
        "write TRUE or FALSE",
    ),
    "string for long": (
        'const long A = §"1";',
        "IDL0500: an integer is wanted here, not a string",
        "write a number without point and quotes, such as 10",
    ),
    "null": (
        "const string A = §NULL;",
        "IDL0200: NULL is unknown",
        'IDL has no null; an empty string is ""',
    ),
    "nullptr": (
        "const long A = §{1};",
        "IDL0121: a constant holds a single value in IDL",
        "constants are numbers, characters, strings, booleans and enumerators",
    ),
    "plus string": (
        'const string A = §"a" + "b";',
        "IDL0500: a string has no operators",
        "adjacent strings are joined",
    ),
    "const range": (
        "const octet A = §256;",
        "IDL0501: 256 is out of the range of octet: 0 to 255",
        "short holds it",
    ),
    "const without type": (
        "const §A = 1;",
        "IDL0125: the constant has no type, or no name",
        "write const TYPE NAME = VALUE;",
    ),
    "const without value": (
        "const long A§;",
        "IDL0124: the value of the constant is missing here",
        "write '= VALUE' after the name",
    ),
    "define as const": (
        "#define N 10;\nstruct S { long a[§N]; };",
        "IDL0100: the text of this macro holds a ';', which is not allowed here",
        "remove the ';' from its #define",
    ),
    "missing endif": (
        "§#ifndef A\n#define A\nstruct S { long a; };\n",
        "IDL0013: this conditional is never closed",
        "add #endif at the end of the file",
    ),
    "extra endif": (
        "struct S { long a; };\n§#endif",
        "IDL0014: #endif without #if",
        "remove it, or add the #if that is missing before it",
    ),
    "missing include": (
        '§#include "gone.idl"\nstruct S { Gone a; };',
        "IDL0010: the file gone.idl was not found",
        "searched: .",
    ),
    "include typo": (
        '§#include "whel.idl"\nstruct S { Wheel a; };',
        "IDL0010: the file whel.idl was not found",
        "did you mean wheel.idl? searched: .",
    ),
    "include case": (
        '§#include "Wheel.idl"\nstruct S { Wheel a; };',
        "IDL0010: the file Wheel.idl was not found",
        "did you mean wheel.idl? (only the case differs) searched: .",
    ),
    "include no quotes": (
        "§#include wheel.idl\nstruct S { Wheel a; };",
        'IDL0012: #include needs "file" or <file> after it',
        'write #include "wheel.idl"',
    ),
    "include one quote": (
        '§#include "wheel.idl\nstruct S { Wheel a; };',
        'IDL0012: #include needs "file" or <file> after it',
        'write #include "wheel.idl"',
    ),
    "include angle": (
        "§#include <wheel.idl>\nstruct S { Wheel a; };",
        "IDL0010: the file wheel.idl was not found",
        "searched: no folder (use -I)",
    ),
    "inclued": (
        '§#inclued "wheel.idl"\nstruct S { Wheel a; };',
        "IDL0021: '#inclued' is not a directive",
        "did you mean #include?",
    ),
    "import": (
        '§import "wheel.idl";\nstruct S { Wheel a; };',
        "IDL0012: import of a text: nothing is read",
        'write #include "file.idl" for a file, import NAME; for a module',
    ),
    "import no quotes": (
        "§import wheel.idl;\nstruct S { Wheel a; };",
        "IDL0100: 'import' does not accept a file name",
        'write #include "file.idl" for a file; import takes a name and a semicolon',
    ),
    "include without hash": (
        '§include "wheel.idl"\nstruct S { Wheel a; };',
        "IDL0121: IDL has no 'include'",
        'write #include "file.idl"',
    ),
    "pragma prefix": (
        "§#pragma prefix omg.org\nstruct S { long a; };",
        "IDL0700: malformed pragma",
        'write #pragma prefix "text"',
    ),
    "using namespace": (
        "§using namespace std;\nstruct S { long a; };",
        "IDL0121: IDL has no 'using'",
        "IDL has no using: write typedef for a type, or scoped names such as A::B",
    ),
    "namespace": (
        "§namespace N { struct S { long a; }; };",
        "IDL0121: IDL has no 'namespace'",
        "write module",
    ),
    "package": (
        "§package N;\nstruct S { long a; };",
        "IDL0121: IDL has no 'package'",
        "write module NAME { ... };",
    ),
    "unsigned double": (
        "struct S { §unsigned double a; };",
        "IDL0121: 'unsigned double' is not a type",
        "write double: floating-point numbers have a sign",
    ),
    "unsigned char": (
        "struct S { §unsigned char a; };",
        "IDL0121: 'unsigned char' is not a type",
        "write octet for a byte without sign",
    ),
    "unsigned int": (
        "struct S { §unsigned int a; };",
        "IDL0121: 'unsigned int' is not a type",
        "write unsigned long (32 bits)",
    ),
    "unsigned": (
        "struct S { §unsigned a; };",
        "IDL0121: 'unsigned' is not a type",
        "write unsigned short, unsigned long or unsigned long long",
    ),
    "signed": (
        "struct S { §signed long a; };",
        "IDL0121: IDL has no 'signed'",
        "IDL's integers have a sign: leave the word out",
    ),
    "int": (
        "struct S { §int a; };",
        "IDL0200: int is unknown",
        "write long (32 bits) or short (16 bits)",
    ),
    "int parameter": (
        "interface I { void f(in §int a); };",
        "IDL0200: int is unknown",
        "write long (32 bits) or short (16 bits)",
    ),
    "int result": (
        "interface I { §int f(); };",
        "IDL0200: int is unknown",
        "write long (32 bits) or short (16 bits)",
    ),
    "const int": (
        "const §int A = 1;",
        "IDL0200: int is unknown",
        "write long (32 bits) or short (16 bits)",
    ),
    "long int": (
        "struct S { §long int a; };",
        "IDL0121: 'long int' is not a type",
        "write long",
    ),
    "long float": (
        "struct S { §long float a; };",
        "IDL0121: 'long float' is not a type",
        "write double",
    ),
    "short int": (
        "struct S { §short int a; };",
        "IDL0121: 'short int' is not a type",
        "write short",
    ),
    "long long long": (
        "struct S { §long long long a; };",
        "IDL0121: 'long long long' is not a type",
        "write long long",
    ),
    "bool": (
        "struct S { §bool a; };",
        "IDL0200: bool is unknown",
        "write boolean",
    ),
    "byte": (
        "struct S { §byte a; };",
        "IDL0200: byte is unknown",
        "write octet",
    ),
    "uint32_t": (
        "struct S { §uint32_t a; };",
        "IDL0200: uint32_t is unknown",
        "write unsigned long",
    ),
    "int64_t": (
        "struct S { §int64_t a; };",
        "IDL0200: int64_t is unknown",
        "write long long",
    ),
    "size_t": (
        "struct S { §size_t a; };",
        "IDL0200: size_t is unknown",
        "write unsigned long (32 bits) or unsigned long long (64 bits)",
    ),
    "float64": (
        "struct S { §float64 a; };",
        "IDL0200: float64 is unknown",
        "write double",
    ),
    "float32": (
        "struct S { §float32 a; };",
        "IDL0200: float32 is unknown",
        "write float",
    ),
    "std::string": (
        "struct S { §std::string a; };",
        "IDL0121: IDL has no 'std::string'",
        "write string",
    ),
    "std::vector": (
        "struct S { §std::vector<long> a; };",
        "IDL0121: IDL has no 'std::vector'",
        "write sequence<T>",
    ),
    "vector": (
        "struct S { §vector<long> a; };",
        "IDL0121: IDL has no 'vector'",
        "write sequence<T>",
    ),
    "list": (
        "struct S { §list<long> a; };",
        "IDL0121: IDL has no 'list'",
        "write sequence<T>",
    ),
    "array type": (
        "struct S { §array<long, 3> a; };",
        "IDL0121: IDL has no 'array'",
        "write T name[n] for an array, sequence<T> for a list",
    ),
    "char*": (
        "struct S { char §*a; };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "reference": (
        "struct P { long a; }; struct S { P §&p_; };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "string[]": (
        "struct S { string §[] a; };",
        "IDL0123: the size of an array follows the name",
        "write TYPE NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "array before name": (
        "struct S { long§[3] a; };",
        "IDL0123: the size of an array follows the name",
        "write TYPE NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "array before name typedef": (
        "typedef long§[3] A;",
        "IDL0123: the size of an array follows the name",
        "write TYPE NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "open array": (
        "struct S { long a§[]; };",
        "IDL0123: an array has a size",
        "write NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "array comma": (
        "struct S { long a[2§,3]; };",
        "IDL0123: each dimension has its own brackets",
        "write NAME[2][3]",
    ),
    "array parens": (
        "struct S { long a§(3); };",
        "IDL0123: the size of an array is written in brackets",
        "write a[3]",
    ),
    "auto/var": (
        "struct S { §var a; };",
        "IDL0200: var is unknown",
        "name the type: IDL does not infer types",
    ),
    "ros array": (
        "struct S { sequence<long§ a; };",
        "IDL0124: a '>' is missing here",
        "put '>' after 'long'",
    ),
    "sequence without type": (
        "struct S { sequence§ a; };",
        "IDL0124: a '<' is missing here",
        "put '<' after 'sequence'",
    ),
    "sequence parens": (
        "struct S { sequence§(long) a; };",
        "IDL0124: 'sequence' requires '<' and '>', not '(' and ')'",
        "write sequence<...>",
    ),
    "sequence bound first": (
        "struct S { sequence<§10, long> a; };",
        "IDL0100: the type comes first, then the bound",
        "write sequence<TYPE, BOUND>",
    ),
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
    "time": (
        "struct S { §Time tm; };",
        "IDL0200: Time is unknown",
        "declare it before its use, or include the file that declares it",
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
        "IDL0124: a ',' is wanted here, not a ';'",
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
    "missing close brace": (
        "module M §{\n    struct S { long a; };\n",
        "IDL0105: this '{' of module M is never closed",
        "put '};' where it ends",
    ),
    "missing close brace struct": (
        "struct S §{\n    long a;\nstruct T { long b; };",
        "IDL0105: this '{' of struct S is not closed",
        "put '};' before 'struct'",
    ),
    "missing close brace struct module": (
        "module M {\nstruct S §{\n    long a;\nstruct T { long b; };\n};",
        "IDL0105: this '{' of struct S is not closed",
        "put '};' before 'struct'",
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
    "parens missing": (
        "interface I { void f§; };",
        "IDL0124: '()' is missing here",
        "write f() for an operation, attribute TYPE f for a value",
    ),
    "class": (
        "§class C { long a; };",
        "IDL0121: IDL has no 'class'",
        "write struct for data, interface for operations, valuetype for both",
    ),
    "virtual": (
        "interface I { §virtual void f(); };",
        "IDL0121: IDL has no 'virtual'",
        "operations can always be overridden: leave the word out",
    ),
    "static": (
        "interface I { §static void f(); };",
        "IDL0121: IDL has no 'static'",
        "leave the word out: operations belong to objects",
    ),
    "public:": (
        "interface I { §public: void f(); };",
        "IDL0121: IDL has no 'public:'",
        "remove it: members of structs and interfaces are public",
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
    "public in interface": (
        "interface I { §public void f(); };",
        "IDL0122: 'public' is not allowed in an interface",
        "remove it: members of an interface are public",
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
    "method body": (
        "interface I { void f() §{ } };",
        "IDL0121: operations have no body in IDL",
        "end the declaration with ';'",
    ),
    "method body 2": (
        "interface I {\n void f() §{ return 1; }\n void g();\n};",
        "IDL0121: operations have no body in IDL",
        "end the declaration with ';'",
    ),
    "const method": (
        "interface I { void f() §const; };",
        "IDL0121: operations are not const in IDL",
        "leave the word out",
    ),
    "pure virtual": (
        "interface I { void f() §= 0; };",
        "IDL0121: operations are not defined in IDL",
        "leave the '= ...' out",
    ),
    "default argument": (
        "interface I { void f(in long a §= 1); };",
        "IDL0121: parameters have no default values in IDL",
        "leave the value out",
    ),
    "overloaded": (
        "interface I { void f(); void §f(in long a); };",
        "IDL0202: f is declared twice",
        "operations cannot be overloaded: give each a name of its own",
    ),
    "constructor": (
        "interface I { §I(in long a); };",
        "IDL0125: the operation I has no result type",
        "write void before the name if it returns nothing; IDL has no constructors",
    ),
    "raises without parenthesis": (
        "exception E {}; interface I { void f() raises §E; };",
        "IDL0124: a '(' is missing after 'raises'",
        "write raises (E)",
    ),
    "raises empty": (
        "interface I { void f() §raises (); };",
        "IDL0119: no exception is named",
        "name an exception, or leave raises out",
    ),
    "raises before": (
        "exception E {};\ninterface I { void §raises (E) f(); };",
        "IDL0100: 'raises' follows the parameters",
        "write TYPE NAME(...) raises (EXCEPTION)",
    ),
    "oneway result": (
        "interface I { oneway §long f(); };",
        "IDL0607: f is oneway, so it returns void",
        "write void, or leave oneway out",
    ),
    "oneway out": (
        "interface I { oneway void f(out long §a); };",
        "IDL0607: f is oneway, so its parameters are in",
        "write in, or leave oneway out",
    ),
    "oneway raises": (
        "exception E {}; interface I { oneway void f() §raises (E); };",
        "IDL0607: f is oneway, so it raises nothing",
        "leave raises or oneway out",
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
    "raises struct": (
        "struct E { long a; }; interface I { void f() raises (§E); };",
        "IDL0605: the struct E is not an exception",
        "declare it as exception E { ... };",
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
    "redefinition": (
        "struct S { long a; };\nstruct §S { long b; };",
        "IDL0202: S is declared twice",
        "rename one of them",
    ),
    "redefinition kinds": (
        "struct S { long a; };\nenum §S { A };",
        "IDL0202: S is declared twice",
        "rename one of them",
    ),
    "foo": (
        "struct Foo { long a; };\nstruct S { Foo §foo; };",
        "IDL0204: foo clashes with Foo, which is used in this scope",
        "write ::Foo there, or rename this",
    ),
    "keyword name": (
        "struct S { long §in; };",
        "IDL0103: 'in' is a keyword and cannot be a name",
        "'_in' is the escaped form of in",
    ),
    "keyword name type": (
        "struct §object { long a; };",
        "IDL0206: object differs from the keyword 'Object' in case only",
        "'_object' is the escaped form of object",
    ),
    "keyword parameter": (
        "interface I { void f(in string §context); };",
        "IDL0103: 'context' is a keyword and cannot be a name",
        "'_context' is the escaped form of context",
    ),
    "keyword enumerator": (
        "enum E { §default, other };",
        "IDL0103: 'default' is a keyword and cannot be a name",
        "'_default' is the escaped form of default",
    ),
    "keyword operation": (
        "interface I { void §local(); };",
        "IDL0103: 'local' is a keyword and cannot be a name",
        "'_local' is the escaped form of local",
    ),
    "keyword module": (
        "module §public { struct S { long a; }; };",
        "IDL0103: 'public' is a keyword and cannot be a name",
        "'_public' is the escaped form of public",
    ),
    "single colon": (
        "module M { struct P { long a; }; };\nstruct S { M§:P a; };",
        "IDL0100: one ':' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "dot": (
        "module M { struct P { long a; }; };\nstruct S { M§.P a; };",
        "IDL0004: the character '.' is not allowed here",
        "parts of a name are joined by ::",
    ),
    "arrow": (
        "module M { struct P { long a; }; };\nstruct S { M§->P a; };",
        "IDL0100: '-' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "slash": (
        "module M { struct P { long a; }; };\nstruct S { M§/P a; };",
        "IDL0100: '/' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "before declaration": (
        "struct S { §T a; };\nstruct T { long b; };",
        "IDL0200: T is unknown",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "before declaration module": (
        "module M { struct S { §T a; }; };\nmodule M { struct T { long b; }; };",
        "IDL0200: T is unknown",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "other module": (
        "module M { struct T { long b; }; };\nstruct S { §T a; };",
        "IDL0200: T is unknown",
        "did you mean M::T?",
    ),
    "forward never": (
        "struct §S;\ntypedef sequence<S> Ss;",
        "IDL0215: the struct S is declared, but never defined",
        "define it, or remove the declaration",
    ),
    "forward interface never": (
        "interface §I;\nstruct S { I a; };",
        "IDL0216: the interface I is declared, but never defined",
        "define it, or remove the declaration",
    ),
    "recursive": (
        "struct S { §S next; };",
        "IDL0300: S cannot hold itself",
        "use a sequence: 'struct S;' and 'typedef sequence<S> ...;' before it",
    ),
    "mutual": (
        "struct A { §B b_; };\nstruct B { A a_; };",
        "IDL0200: B is unknown",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "bound zero": (
        "typedef sequence<long, §0> L;",
        "IDL0304: 0 is not from 1 to 4294967295",
        "a bound is positive; without a bound, sequences and strings hold any number",
    ),
    "bound text": (
        'typedef string<§"10"> L;',
        "IDL0500: an integer is wanted here, not a string",
        "write a number without point and quotes, such as 10",
    ),
    "bound unknown": (
        "typedef string<§N> L;",
        "IDL0200: N is unknown",
        "declare it before its use, or include the file that declares it",
    ),
    "bound float": (
        "typedef string<§1.5> L;",
        "IDL0500: an integer is wanted here, not a floating-point number",
        "write a number without point, or make the type double",
    ),
    "array zero": (
        "typedef long A[§0];",
        "IDL0304: 0 is not from 1 to 4294967295",
        "a bound is positive; without a bound, sequences and strings hold any number",
    ),
    "array parameter": (
        "interface I { void f(in long §a[3]); };",
        "IDL0306: an array needs a name here",
        "use a typedef",
    ),
    "sequence parameter": (
        "interface I { void f(in §sequence<long> a); };",
        "IDL0306: a type declared in place is not allowed here",
        "give it a name before: use a typedef",
    ),
    "sequence result": (
        "interface I { §sequence<long> f(); };",
        "IDL0306: a type declared in place is not allowed here",
        "give it a name before: use a typedef",
    ),
    "typedef =": (
        "typedef A §= long;",
        "IDL0121: '=' is not allowed in a typedef",
        "write typedef TYPE NAME;",
    ),
    "typedef = 2": (
        "typedef long A §= 3;",
        "IDL0121: '=' is not allowed in a typedef",
        "write typedef TYPE NAME;",
    ),
    "using =": (
        "§using A = long;",
        "IDL0121: IDL has no 'using'",
        "IDL has no using: write typedef for a type, or scoped names such as A::B",
    ),
    "typedef reversed": (
        "typedef Size §long;",
        "IDL0100: 'long' is not allowed here: the type comes first",
        "write typedef long Size;",
    ),
    "smart quotes": (
        "const string A = §\u201cabc\u201d;",
        "IDL0004: the character '\u201c' is not allowed here",
        'write "',
    ),
    "nbsp": (
        "struct S {§\xa0long a; };",
        "IDL0004: the no-break space, U+00A0, is not allowed here",
        "write a plain space",
    ),
    "fullwidth semicolon": (
        "struct S { long a§\uff1b};",
        "IDL0004: the character '\uff1b' is not allowed here",
        "write ;",
    ),
    "ideographic space": (
        "struct S {§\u3000long a; };",
        "IDL0004: the ideographic space, U+3000, is not allowed here",
        "write a plain space",
    ),
    "minus sign": (
        "const long A = §\u22121;",
        "IDL0004: the character '\u2212' is not allowed here",
        "write -",
    ),
    "zero width": (
        "struct S { long §\u200ba; };",
        "IDL0004: the zero width space, U+200B, is not allowed here",
        "remove it; nothing is seen of it",
    ),
    "bom in the middle": (
        "struct S { long §\ufeffa; };",
        "IDL0004: the zero width no-break space, U+FEFF, is not allowed here",
        "remove it; nothing is seen of it",
    ),
    "hyphen name": (
        "struct S { long max§-speed; };",
        "IDL0100: '-' is not allowed in a name",
        "write max_speed",
    ),
    "digit name": (
        "struct S { long §2nd; };",
        "IDL0100: '2nd' is not a name: it begins with a digit",
        "a name begins with a letter",
    ),
    "dollar name": (
        "struct S { long §$a; };",
        "IDL0004: the character '$' is not allowed here",
        "names hold ASCII letters, digits and underscores",
    ),
    "space name": (
        "struct S { long max §speed; };",
        "IDL0100: 'speed' is not allowed here: max is the name already",
        "write max_speed if that is one name",
    ),
    "space name struct": (
        "struct My §Struct { long a; };",
        "IDL0100: 'Struct' is not allowed here: My is the name already",
        "write My_Struct if that is one name",
    ),
    "accents": (
        "struct S { long §größe; };",
        "IDL0207: the identifier größe has other than ASCII letters",
        "names hold the letters a to z, digits and underscores",
    ),
    "leading underscores": (
        "struct S { long §__a; };",
        "IDL0207: the identifier _a has more than one leading underscore",
        "write a",
    ),
    "hash comment": (
        "§# this is a comment\nstruct S { long a; };",
        "IDL0021: '#this' is not a directive",
        "a comment begins with //, a pragma with #pragma",
    ),
    "dash comment": (
        "§-- this is a comment\nstruct S { long a; };",
        "IDL0121: this is not a comment in IDL",
        "write // ... or /* ... */",
    ),
    "xml comment": (
        "§<!-- this is a comment -->\nstruct S { long a; };",
        "IDL0121: this is not a comment in IDL",
        "write // ... or /* ... */",
    ),
    "inheritance extends": (
        "interface A {};\ninterface B §extends A {};",
        "IDL0121: IDL has no 'extends'",
        "write ':' before the base",
    ),
    "inheritance public": (
        "interface A {};\ninterface B : §public A {};",
        "IDL0121: IDL has no 'public' here",
        "leave the word out: bases are public",
    ),
    "inheritance paren": (
        "interface A {};\ninterface B§(A) {};",
        "IDL0100: a base follows ':'",
        "write interface B : A",
    ),
    "inherit struct": (
        "struct A { long x; };\ninterface B : §A {};",
        "IDL0301: the struct A cannot be a base of an interface",
        "a base of an interface is an interface",
    ),
    "inherit forward": (
        "interface A;\ninterface B : §A {};\ninterface A {};",
        "IDL0300: A is not defined before this place",
        "put its definition before",
    ),
    "inherit struct by class": (
        "§class A {};",
        "IDL0121: IDL has no 'class'",
        "write struct for data, interface for operations, valuetype for both",
    ),
    "template": (
        "§template<typename T> struct S { T a; };",
        "IDL0121: IDL has no 'template'",
        "IDL has no templates of types: write out each struct",
    ),
    "attribute =": (
        "interface I { attribute long a §= 1; };",
        "IDL0121: attributes have no initial values in IDL",
        "leave the value out",
    ),
    "property": (
        "interface I { §property long a; };",
        "IDL0121: IDL has no 'property'",
        "write attribute",
    ),
    "readonly without attribute": (
        "interface I { readonly §long a; };",
        "IDL0125: 'attribute' is missing after 'readonly'",
        "write readonly attribute TYPE NAME;",
    ),
    "attribute in struct": (
        "struct S { §attribute long a; };",
        "IDL0122: 'attribute' is not allowed in a struct",
        "attributes and operations belong into an interface",
    ),
    "operation in module": (
        "module M { §void f(); };",
        "IDL0122: an operation is not allowed in a module",
        "put it into an interface",
    ),
    "operation at top": (
        "§void f();",
        "IDL0122: an operation is not allowed at file scope",
        "put it into an interface",
    ),
    "member at top": (
        "§long a;",
        "IDL0122: a member is not allowed at file scope",
        "put it into a struct; or write typedef for a type, const for a constant",
    ),
    "member in interface": (
        "interface I { long a§; };",
        "IDL0124: '()' is missing here",
        "write a() for an operation, attribute TYPE a for a value",
    ),
    "enum used as scope": (
        "enum E { A };\nconst E X = E::§A;",
        "IDL0213: A is declared beside the enum, not inside it",
        "write A",
    ),
    "module lowercase end": (
        "module M { struct S { long a; } ; } §end;",
        "IDL0121: IDL has no 'end'",
        "a body ends with '};'",
    ),
    "string array C": (
        "struct S { char name§[]; };",
        "IDL0123: an array has a size",
        "write NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "nothing between templates": (
        "typedef sequence<§> L;",
        "IDL0125: a type is missing here",
        "write the type of its elements: sequence<long>",
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
    "union switch enum literal": (
        "enum E { A }; union U switch (E) { case §1: long a; };",
        "IDL0500: an enumerator is wanted here, not an integer",
        "write the name of an enumerator",
    ),
    "union bool label": (
        "union U switch (boolean) { case §true: long a; };",
        "IDL0200: true is unknown",
        "the boolean constants are TRUE and FALSE",
    ),
    "raises unknown": (
        "interface I { void f() raises (§Faliure); };\nexception Failure {};",
        "IDL0200: Faliure is unknown",
        "did you mean Failure?",
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
    "missing name in typedef": (
        "typedef long§;",
        "IDL0125: a name is missing here",
        "a declaration has a type and a name: long count",
    ),
    "const in module ok but =": (
        "module M { const long A§ 1; };",
        "IDL0124: a '=' is missing here",
        "put '=' after 'A'",
    ),
    "==": (
        "const long A §== 1;",
        "IDL0100: '==' is not allowed here",
        "write one '='",
    ),
    ":=": (
        "const long A §:= 1;",
        "IDL0124: a '=' is wanted here, not ':='",
        "write '='",
    ),
    "ternary": (
        "const long A = 1 §? 2 : 3;",
        "IDL0004: the character '?' is not allowed here",
        "IDL has no conditional expressions; an optional member is marked @optional",
    ),
    "logical and": (
        "const boolean A = TRUE &§& FALSE;",
        "IDL0121: IDL has no logical operators",
        "boolean constants are TRUE or FALSE",
    ),
    "not": (
        "const boolean A = §!TRUE;",
        "IDL0004: the character '!' is not allowed here",
        "IDL has no logical operators; complement is ~",
    ),
    "power": (
        "const double A = 2.0 *§* 3.0;",
        "IDL0121: IDL has no powers",
        "write the number, or a product",
    ),
    "cast": (
        "const long A = (§long) 3.5;",
        "IDL0121: IDL has no casts",
        "write a value of the type of the constant",
    ),
    "dds key": (
        "struct S { §key long a; };",
        "IDL0121: IDL has no 'key'",
        "write @key before the member",
    ),
    "annotation unclosed": (
        "struct S { @id(3§ long a; };",
        "IDL0124: a ')' is missing here",
        "close the parenthesis",
    ),
    "annotation typo": (
        "struct S { §@optionl long a; };",
        "IDL0800: @optionl is not known",
        "did you mean @optional?",
    ),
    "annotation []": (
        "struct S { §[Key] long a; };",
        "IDL0121: annotations are not written in brackets",
        "write @name",
    ),
    "name ending": (
        "struct S { CORBA§:: ; };",
        "IDL0125: a name is missing after '::'",
        "'::' separates the parts of a scoped name",
    ),
    "name ending 2": (
        "struct S { sequence<CORBA§::> a; };",
        "IDL0125: a name is missing after '::'",
        "'::' separates the parts of a scoped name",
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
        "IDL0105: this '{' of struct S is not closed",
        "put '};' before 'struct'",
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
