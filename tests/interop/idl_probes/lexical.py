"""Section 1 of the language: text, identifiers, keywords, literals, operators."""

from idl_probes.probe import alone, better, refused, same
from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED

_S = "struct S { long a; };"

PROBES = [
    # Text
    same("utf-8 in a comment", "// größe 日本\n" + _S),
    same("euc-jp in a comment", b"// \xc6\xfc\xcb\xdc\xb8\xec\n" + _S.encode()),
    same("shift-jis in a comment", b"// \x93\xfa\x96{\x8c\xea\n" + _S.encode()),
    # omniidl reads the second byte of the character as a continuation: then T is a comment
    alone(
        "shift-jis that ends in a backslash",
        "// 表\nstruct T { long b; };\n".encode("shift-jis"),
        "TXT0002",
        T="struct T; b: long",
    ),
    same(
        "shift-jis with a full stop behind it",
        "// 表.\nstruct T { long b; };\n".encode("shift-jis"),
    ),
    alone(
        "shift-jis before other members",
        "struct T { long a; // X座標の表\n long b; // Y\n};".encode("shift-jis"),
        "TXT0002",
        T="struct T; a: long; b: long",
    ),
    alone(
        "shift-jis in a string",
        'const string A = "能力";'.encode("shift-jis"),
        "TXT0005",
        A='const A: string = "能力"',
    ),
    # omniidl reads the comment up to the line feed
    alone(
        "lone cr after a comment",
        b"// a\rstruct T { long b; };\n",
        "TXT0004",
        T="struct T; b: long",
    ),
    same(
        "shift-jis in a block comment", "/* ソ表 */\n".encode("shift-jis") + _S.encode()
    ),
    same("latin-1 in a string", b'const string A = "gr\xf6\xdfe";', "TXT0001"),
    # omniidl reads nothing from such a file
    alone("byte-order mark", b"\xef\xbb\xbf" + _S.encode(), S="struct S; a: long"),
    alone(
        "byte-order mark before a comment",
        b"\xef\xbb\xbf// x\n" + _S.encode(),
        S="struct S; a: long",
    ),
    alone(
        "byte-order mark before a directive",
        b"\xef\xbb\xbf#define X long\nstruct S { X a; };",
        S="struct S; a: long",
    ),
    same("cr lf", "struct S {\r\n  long a;\r\n};\r\n"),
    same("lone lf", "struct S {\n  long a;\n};\n"),
    same("mixed line ends", "// a\r\nstruct S {\n  long a;\r\n};"),
    better(
        "cr lf after a backslash", "str\\\r\nuct S { long a; };", S="struct S; a: long"
    ),
    same("tab", "struct\tS\t{\tlong\ta;\t};"),
    same("vertical tab and form feed", "struct S\v{ long\fa; };"),
    refused("other control character", "struct S { long\x01a; };", "IDL0004"),
    same("empty file", ""),
    same("only comments", "// a\n/* b */\n"),
    same("only white space", " \t\n\n"),
    same("joined lines in a word", "str\\\nuct S { lo\\\nng a; };"),
    same("joined lines in a comment", "// a \\\n still a\n" + _S, "TXT0003"),
    same("joined lines in a string", 'const string A = "a\\\nb";'),
    same("joined lines in a number", "const long A = 1\\\n2;"),
    refused("backslash before a blank", "str\\ \nuct S { long a; };", "IDL01"),
    same("line comment at the end of the file", _S + " // end"),
    same("block comment over lines", "/* a\n b */ " + _S),
    same("comment between words", "struct/* a */S{long/**/a;};"),
    same("line marks in a block comment", "/* // */ " + _S),
    same("block mark in a line comment", "// /*\n" + _S),
    same("comment mark in a string", 'const string A = "/* // */";'),
    refused("nested comment", "/* a /* b */ c */ " + _S, "IDL01"),
    refused("unclosed comment", _S + " /* a", "IDL0007"),
    same("doc comments", "/** a */\nstruct S { /// b\n long a; ///< c\n};"),
    # Identifiers
    same("letters, digits, underscores", "struct a1_B2__ { long x_9; };"),
    refused("digit first", "struct 1a { long x; };", "IDL01"),
    same("escaped keyword", "struct _struct { long _long; };"),
    same("escaped plain name", "struct _A { long b; };\nstruct B { A c; _A d; };"),
    same(
        "escape leaves the repository id",
        "module _module { interface _interface { void _in(); }; };",
    ),
    refused(
        "escaped name is the same name",
        "struct A { long x; }; struct _A { long x; };",
        "IDL0202",
    ),
    refused(
        "escaped member is the same name", "struct S { long a; short _a; };", "IDL0202"
    ),
    refused("two leading underscores", "struct __A { long x; };", "IDL0207"),
    refused("underscore alone", "struct _ { long x; };", "IDL0207"),
    refused("underscore and digit", "struct _1 { long x; };", "IDL0207"),
    refused("non-ascii letter, utf-8", "struct Größe { long x; };", "IDL0207"),
    refused(
        "non-ascii letter, latin-1", b"struct Gr\xf6 { long x; };", "IDL0207", "TXT0001"
    ),
    refused("full-width digit", "struct A\uff11 { long x; };", "IDL0207"),
    refused(
        "differ in case only",
        "struct Aa { long x; }; struct aA { long x; };",
        "IDL0203",
    ),
    refused("keyword in other case", "struct Struct { long x; };", "IDL0206"),
    refused("keyword in capitals", "struct S { long OBJECT; };", "IDL0206"),
    refused("boolean in other case", "struct S { long True; };", "IDL0206"),
    refused("valuebase in other case", "interface valuebase {};", "IDL0206"),
    same("escaped keyword in other case", "struct _Struct { long _OBJECT; };"),
    same(
        "word that begins like a keyword",
        "struct structure { long inout_; long longer; };",
    ),
    # CORBA 3 words: identifiers, with a warning
    *(
        same(f"CORBA 3 word {word}", f"struct {word} {{ long a; }};", "IDL0208")
        for word in [
            "component",
            "consumes",
            "emits",
            "eventtype",
            "finder",
            "getraises",
            "home",
            "import",
            "multiple",
            "primarykey",
            "provides",
            "publishes",
            "setraises",
            "typeid",
            "typeprefix",
            "uses",
        ]
    ),
    same("CORBA 3 word escaped", "struct _component { long _uses; };"),
    same("manages is an ordinary word", "struct manages { long a; };", "IDL0208"),
    # IDL 4 words: identifiers without a warning
    *(
        same(
            f"IDL 4 word {word}", f"struct {word} {{ long a; }}; typedef {word} Other;"
        )
        for word in [
            "map",
            "bitset",
            "bitmask",
            "bitfield",
            "int8",
            "uint8",
            "int16",
            "uint16",
            "int32",
            "uint32",
            "int64",
            "uint64",
            "alias",
            "port",
            "porttype",
            "mirrorport",
            "connector",
            "typename",
        ]
    ),
    same(
        "keywords, as far as they are names of others",
        'interface I { void f(in string a) context("context"); };',
    ),
    *(
        refused(
            f"reserved word {word}",
            f"typedef long T; struct S {{ T {word}; }};",
            "IDL01",
        )
        for word in sorted(RESERVED)
    ),
    # Integers
    same("decimal", "const long A = 10; const long B = 0;"),
    same("octal", "const long A = 017; const long B = 00;"),
    same("hexadecimal", "const long A = 0xfF; const long B = 0X1a;"),
    refused("bad octal", "const long A = 089;", "IDL0109"),
    refused("hexadecimal without digits", "const long A = 0x;", "IDL0109"),
    refused("bad hexadecimal", "const long A = 0xg;", "IDL0109"),
    refused("number with letters", "const long A = 12ab;", "IDL0109"),
    refused("suffix l", "const long A = 12L;", "IDL0109"),
    same("largest", "const unsigned long long A = 18446744073709551615;"),
    refused(
        "larger than the largest",
        "const unsigned long long A = 18446744073709551616;",
        "IDL0109",
    ),
    refused(
        "larger, hexadecimal",
        "const unsigned long long A = 0x10000000000000000;",
        "IDL0109",
    ),
    refused(
        "larger, octal",
        "const unsigned long long A = 02000000000000000000000;",
        "IDL0109",
    ),
    # Floating-point
    same("point at the end", "const double A = 1.;"),
    same("point at the start", "const double A = .5;"),
    same(
        "exponent",
        "const double A = 1e10; const double B = 1.5E-3; const double C = .5e+2;",
    ),
    same("leading zero", "const double A = 012.5; const double B = 09e1;"),
    refused("suffix f", "const float A = 1.0f;", "IDL0109"),
    refused("exponent without digits", "const double A = 1e;", "IDL0109"),
    refused("two points", "const double A = 1.2.3;", "IDL0109"),
    # Fixed
    same(
        "fixed",
        "const fixed A = 12.5d; const fixed B = 3D; const fixed C = .5d; const fixed E = 4.d;",
    ),
    same(
        "zeros are dropped",
        "const fixed A = 0012.340d; const fixed B = 100d; const fixed C = 0.0d;",
    ),
    same("31 digits", "const fixed A = 1234567890123456789012345678901d;"),
    refused(
        "32 digits", "const fixed A = 12345678901234567890123456789012d;", "IDL0109"
    ),
    same(
        "zeros do not count as digits",
        "const fixed A = 0001234567890123456789012345678901.000d;",
    ),
    # Characters
    same("character", "const char A = 'x'; const char B = ' '; const char C = '\"';"),
    same(
        "escapes",
        r"const char A = '\n'; const char B = '\t'; const char C = '\v'; const char D = '\b'; const char E = '\r';",
    ),
    same(
        "more escapes",
        r"const char F = '\f'; const char G = '\a'; const char H = '\\'; const char I = '\?'; const char J = '\''; const char K = '\"';",
    ),
    same(
        "octal characters",
        r"const char A = '\1'; const char B = '\12'; const char C = '\101';",
    ),
    same(
        "hexadecimal characters",
        r"const char A = '\x1'; const char B = '\x41'; const char C = '\xfF';",
    ),
    same("unknown escape", r"const char A = '\q';", "IDL0113"),
    same(
        "unknown escape in a string", r'const string A = "\q\d";', "IDL0113", "IDL0113"
    ),
    refused("two characters", "const char A = 'ab';", "IDL0109"),
    refused("no character", "const char A = '';", "IDL0109"),
    refused("too large an octal", r"const char A = '\777';", "IDL0109"),
    refused("three hexadecimal digits", r"const char A = '\x123';", "IDL0109"),
    refused(
        "hexadecimal without digits in a character", r"const char A = '\xg';", "IDL0109"
    ),
    refused("\\u in a narrow character", r"const char A = '\u0041';", "IDL0109"),
    refused("\\u in a narrow string", r'const string A = "\u0041";', "IDL0109"),
    same(
        "\\u in a wide character", r"const wchar A = L'\u1'; const wchar B = L'\u3042';"
    ),
    same("\\u in a wide string", r'const wstring A = L"\u3042\u41x";'),
    refused("nul for a wide string", r'const wstring A = L"\x0";', "IDL0109"),
    # Wide
    same("wide", "const wchar A = L'x'; const wstring B = L\"abc\";"),
    refused("narrow character for a wide one", "const wchar A = 'x';", "IDL0500"),
    refused("wide character for a narrow one", "const char A = L'x';", "IDL0500"),
    refused("narrow string for a wide one", 'const wstring A = "x";', "IDL0500"),
    refused("wide string for a narrow one", 'const string A = L"x";', "IDL0500"),
    refused("narrow l", "const wchar A = l'x';", "IDL01"),
    # Strings
    same("adjacent strings", 'const string A = "a" "b"\n"c";'),
    same("adjacent wide strings", 'const wstring A = L"a" L"b";'),
    refused("narrow after wide", 'const wstring A = L"a" "b";', "IDL0109"),
    refused("wide after narrow", 'const string A = "a" L"b";', "IDL0109"),
    same(
        "escape ends at the join",
        r'const string A = "\x41" "B"; const string C = "\1" "1";',
    ),
    same("empty string", 'const string A = ""; const wstring B = L"";'),
    same("quotes in a string", r'const string A = "\"\'" "\'";'),
    refused("nul in a string", r'const string A = "a\0b";', "IDL0109"),
    refused("nul in a wide string", r'const wstring A = L"a\0b";', "IDL0109"),
    refused("hexadecimal nul", r'const string A = "\x0";', "IDL0109"),
    same("raw line end in a string", 'const string A = "a\nb";', "IDL0114"),
    refused(
        "unclosed string", 'const string A = "a;\nstruct S { long a; };\n', "IDL0108"
    ),
    # Booleans
    same("booleans", "const boolean A = TRUE; const boolean B = FALSE;"),
    refused("true", "const boolean A = true;", "IDL0200"),
    refused("False", "const boolean A = False;", "IDL0200"),
    refused("1 for TRUE", "const boolean A = 1;", "IDL0500"),
    # Operators and punctuation
    same(
        "all operators",
        "const long A = ((1 | 2) ^ (3 & 4)) << 1 >> (1 + 2 - 3 * 4 / 6 % 3); const unsigned long B = ~0;",
    ),
    better(
        "two closers",
        "typedef sequence<sequence<long>> A;",
        A="typedef A = sequence<sequence<long>>",
    ),
    better(
        "two closers, bounded",
        "typedef sequence<sequence<long, 2>> A;",
        A="typedef A = sequence<sequence<long,2>>",
    ),
    better(
        "two closers in a member",
        "struct S { sequence<string<4>> a; };",
        S="struct S; a: sequence<string<4>>",
    ),
    alone(
        "three closers",
        "typedef sequence<sequence<sequence<long>>> A;",
        A="typedef A = sequence<sequence<sequence<long>>>",
    ),
    alone(
        "four closers",
        "typedef map<string, sequence<sequence<string<3>>>> A;",
        A="typedef A = map<string,sequence<sequence<string<3>>>>",
    ),
    same("shift in a bound", "typedef sequence<long, 16 >> 3> A;"),
    same("shift in an inner bound", "typedef sequence<sequence<long, 16 >> 3> > A;"),
    same("shift in brackets in a bound", "typedef sequence<long, (16 >> 3)> A;"),
    better(
        "shift, then closers",
        "typedef sequence<sequence<long, 16 >> 3>> A;",
        A="typedef A = sequence<sequence<long,2>>",
    ),
    refused("question mark", "const long A = 1 ? 2 : 3;", "IDL0004"),
    refused("dollar", "struct $S { long a; };", "IDL0004"),
    refused("logical and", "const boolean A = TRUE && FALSE;", "IDL01"),
    refused("assignment in a struct", "struct S { long a = 1; };", "IDL01"),
]
