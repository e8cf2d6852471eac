"""Section 2 of the language, first half: directives, macros, includes, line markers."""

from idl_probes.probe import alone, better, refused, same

_S = "struct S { long a; };"
_T = "struct T { long b; };"
_UNSIGNED = (
    *("-1 > 0u", "-1 > 0", "0xffffffffffffffff > 0", "(1 ? -1 : 0u) > 0"),
    *("-1 / 2u > 0", "-1 >> 1u < 0", "18446744073709551615 > 0", "(0u < 1) - 2 < 0"),
    *("!0u - 2 < 0", "~0u > 0", "-1u > 0", "9223372036854775808 > 0", "-1 % 2u == 1"),
)

PROBES = [
    same(
        "include in quotes",
        '#include "t.idl"\nstruct S { T t_; };',
        files={"t.idl": _T},
    ),
    same(
        "include between comments",
        '/* a */ #include "t.idl" /* b */\nstruct S { T t_; };',
        files={"t.idl": _T},
    ),
    same(
        "blanks in a directive",
        ' \t# \t include \t"t.idl"\nstruct S { T t_; };',
        files={"t.idl": _T},
    ),
    same(
        "include beside the including file",
        '#include "d/u.idl"\nstruct S { T t_; };',
        files={"d/u.idl": '#include "t.idl"\n', "d/t.idl": _T},
    ),
    same(
        "include in a folder",
        '#include "t.idl"\nstruct S { T t_; };',
        files={"inc/t.idl": _T},
        folders=("inc",),
    ),
    same(
        "include in brackets",
        "#include <t.idl>\nstruct S { T t_; };",
        files={"inc/t.idl": _T},
        folders=("inc",),
    ),
    same(
        "own folder goes first",
        '#include "t.idl"\nstruct S { T t_; };',
        files={"t.idl": _T, "inc/t.idl": "struct X { long y; };"},
        folders=("inc",),
    ),
    same(
        "folders in order",
        "#include <t.idl>\nstruct S { T t_; };",
        files={"b/t.idl": _T, "a/t.idl": "struct T { short c; };"},
        folders=("a", "b"),
    ),
    refused(
        "brackets do not look beside the file",
        "#include <t.idl>\nstruct S { T t_; };",
        "IDL0010",
        files={"t.idl": _T},
    ),
    refused("include not found", '#include "no.idl"\n', "IDL0010"),
    refused("include without a name", "#include\n" + _S, "IDL0012"),
    refused("include of a word", "#include t.idl\n" + _S, "IDL0012"),
    same(
        "include by a macro",
        '#define F "t.idl"\n#include F\nstruct S { T t_; };',
        files={"t.idl": _T},
    ),
    same("object-like macro", "#define N 3\nconst long A = N;"),
    same("empty macro", "#define EXPORT\nEXPORT struct S { long a; EXPORT };"),
    same("macro of several words", "#define D long a; long b\nstruct S { D; };"),
    same("macro in a macro", "#define N M\n#define M 4\nconst long A = N;"),
    same("macro that names itself", "#define a a\nstruct S { long a; };"),
    same(
        "function-like macro",
        "#define F(x, y) x y;\nstruct S { F(long, a) F(short, b) };",
    ),
    same("macro without parameters", "#define F() long a;\nstruct S { F() };"),
    same("function-like name without a call", "#define F(x) x\nstruct F { long a; };"),
    same("call over lines", "#define F(x, y) x y;\nstruct S { F(long,\n a) };"),
    same("brackets in an argument", "#define F(x) x\nconst long A = F((1 + 2));"),
    same("stringed", "#define Q(x) #x\nconst string A = Q(a b);"),
    same("stringed quotes", '#define Q(x) #x\nconst string A = Q("a");'),
    same("pasted", "#define J(x, y) x ## y\nstruct J(S, 1) { long J(a, b); };"),
    same("pasted object", "#define J a ## b\nstruct S { long J; };"),
    same(
        "argument expanded first", "#define N 5\n#define F(x) x\nconst long A = F(N);"
    ),
    same(
        "argument of paste is not expanded",
        "#define N 5\n#define J(x) N ## x\nconst long N1 = 1; const long A = J(1);",
    ),
    same("expanded to a call", "#define F(x) long x;\n#define G F\nstruct S { G(a) };"),
    refused("too few arguments", "#define F(x, y) x\nconst long A = F(1);", "IDL0018"),
    refused("too many arguments", "#define F(x) x\nconst long A = F(1, 2);", "IDL0018"),
    refused("unclosed call", "#define F(x) x\nconst long A = F(1;\n", "IDL0018"),
    same("undef", "#define N 3\n#undef N\nconst long N = 4;"),
    same("undef of nothing", "#undef N\n" + _S),
    same("redefined alike", "#define N 3\n#define N 3\nconst long A = N;"),
    same(
        "redefined otherwise", "#define N 3\n#define N 4\nconst long A = N;", "IDL0017"
    ),
    same("macro not in a string", '#define N 3\nconst string A = "N";'),
    same("macro not in a comment", "#define N */\n// N\n" + _S),
    same("macro not in a longer word", "#define N 3\nconst long NN = 1;"),
    same("if", "#if 1\n" + _S + "\n#endif"),
    same("if not", "#if 0\n junk { ( ;\n#endif\n" + _S),
    better(
        "odd quote in what is left out",
        "#if 0\n don't\n#endif\n" + _S,
        S="struct S; a: long",
    ),
    same(
        "defined",
        "#define X\n#if defined(X) && defined X && !defined(Y)\n" + _S + "\n#endif",
    ),
    same(
        "arithmetic in if",
        "#if 2 + 3 * 4 == 14 && (7 / 2 == 3) && 7 % 4 == 3 && -1 < 0\n"
        + _S
        + "\n#endif",
    ),
    same(
        "bits in if",
        "#if (5 & 4) == 4 && (1 | 2) == 3 && (1 ^ 3) == 2 && 1 << 3 == 8 && ~0 == -1\n"
        + _S
        + "\n#endif",
    ),
    same(
        "comparison in if",
        "#if 1 < 2 && 2 <= 2 && 3 > 2 && 3 >= 3 && 1 != 2 || 0\n" + _S + "\n#endif",
    ),
    same("choice in if", "#if 0 ? 0 : 1\n" + _S + "\n#endif"),
    same(
        "what is not chosen cannot be wrong",
        "#if (1 ? 2 : 1 / 0) && (1 || 1 % 0)\n" + _S + "\n#endif",
    ),
    same(
        "defined by a macro",
        "#define X\n#define HAS_X defined(X)\n#define HAS_Y defined Y\n"
        "#if HAS_X && !HAS_Y\n" + _S + "\n#endif",
    ),
    same(
        "hexadecimal and suffixes in if",
        "#if 0x10 == 16L && 010 == 8\n" + _S + "\n#endif",
    ),
    same("unknown word in if is 0", "#if NOTHING\njunk\n#else\n" + _S + "\n#endif"),
    same("macro in if", "#define V 3\n#if V >= 3\n" + _S + "\n#endif"),
    alone("character in if", "#if 'a' == 97\n" + _S + "\n#endif"),
    same("ifdef", "#define X\n#ifdef X\n" + _S + "\n#endif\n#ifdef Y\njunk\n#endif"),
    same("ifndef", "#ifndef X\n" + _S + "\n#endif"),
    same(
        "elif", "#if 0\njunk\n#elif 1\n" + _S + "\n#elif 1\njunk\n#else\njunk\n#endif"
    ),
    same("else", "#if 0\njunk\n#else\n" + _S + "\n#endif"),
    same(
        "nested conditionals",
        "#if 0\n#if 1\njunk\n#else\njunk\n#endif\njunk\n#else\n#if 1\n"
        + _S
        + "\n#endif\n#endif",
    ),
    same(
        "comment behind endif", "#ifdef X\n#endif /* X */\n#ifdef X\n#endif // X\n" + _S
    ),
    same("word behind endif", "#ifndef X\n#define X\n" + _S + "\n#endif X\n"),
    same("word behind else", "#if 0\n#else X\n" + _S + "\n#endif\n"),
    same(
        "error in a branch not taken",
        '#if 0\n#error no\n#include "no.idl"\n#endif\n' + _S,
    ),
    refused("error", "#error stop\n" + _S, "IDL0019"),
    same("warning", "#warning careful\n" + _S, "IDL0020"),
    refused("unclosed if", "#if 1\n" + _S, "IDL0013"),
    refused("unclosed ifdef", "#ifdef X\n" + _S, "IDL0013"),
    refused("unclosed ifndef", "#ifndef X\n#define X\n" + _S, "IDL0013"),
    refused(
        "unclosed in an include",
        '#include "t.idl"\n' + _S,
        "IDL0013",
        files={"t.idl": "#ifndef T_\n#define T_\n" + _T},
    ),
    refused("else without if", "#else\n" + _S, "IDL0014"),
    refused("elif without if", "#elif 1\n" + _S, "IDL0014"),
    refused("endif without if", _S + "\n#endif", "IDL0014"),
    refused("second else", "#if 1\n#else\n#else\n#endif\n" + _S, "IDL0014"),
    refused("elif after else", "#if 1\n#else\n#elif 1\n#endif\n" + _S, "IDL0014"),
    refused("bad condition", "#if 1 +\n#endif\n" + _S, "IDL0015"),
    refused("empty condition", "#if\n#endif\n" + _S, "IDL0015"),
    refused("division by zero in if", "#if 1 / 0\n#endif\n" + _S, "IDL0015"),
    same(
        "empty argument of ##",
        "#define J(a, b) typedef unsigned a##b a##N;\nJ(, long)\nJ(short, )\n" + _S,
    ),
    better(
        "variadic macro",
        "#define BODY(name, ...) struct name { __VA_ARGS__ };\n#define REST(...) __VA_ARGS__\n"
        "BODY(R, REST(sequence<long, 3>) a; long b;)\n" + _S,
        R="struct R; a: sequence<long,3>; b: long",
    ),
    better(
        "variadic macro without arguments",
        "#define BODY(name, ...) struct name { long a; __VA_ARGS__ };\nBODY(R)\n" + _S,
        R="struct R; a: long",
    ),
    same(
        "comma before no arguments",
        "#define LIST(n, rest...) typedef sequence<n, ## rest> n##s;\nLIST(long)\nLIST(short, 3)\n"
        + _S,
        gives={
            "longs": "typedef longs = sequence<long>",
            "shorts": "typedef shorts = sequence<short,3>",
        },
    ),
    refused(
        "use of a malformed macro",
        "#define T(3) long\n#define U ## short\nstruct R { T(1) a; U b; };\n" + _S,
        *("IDL0016", "IDL0016"),
    ),
    refused(
        "variadic parameter in the middle",
        "#define T(..., a) long\nstruct R { T(1, 2) a; };\n" + _S,
        "IDL0016",
    ),
    refused("define without a name", "#define\n" + _S, "IDL0016"),
    refused("define of a number", "#define 3 4\n" + _S, "IDL0016"),
    same("ifdef without a name", "#ifdef\njunk\n#endif\n" + _S, "IDL0025"),
    same("ifndef without a name", "#ifndef\n" + _S + "\n#endif\n", "IDL0025"),
    same("ifdef of a number", "#ifdef 1\njunk\n#endif\n" + _S, "IDL0025"),
    same("assert", "#assert a(b)\n#unassert a\n" + _S, *["IDL0026"] * 2),
    same(
        "include_next",
        "#include <a.idl>\n",
        files={
            "one/a.idl": "#include_next <a.idl>\n" + _S,
            "two/a.idl": "struct T { long a; };\n",
        },
        folders=("one", "two"),
    ),
    same(
        "include_next in the main file", '#include_next "a.idl"\n', files={"a.idl": _S}
    ),
    same("digraph", "%:define A 5\n%: if A == 5\n" + _S + "\n%:endif\n"),
    same(
        "unsigned numbers",
        "\n".join(
            f"#if {condition}\nstruct S{number} {{ long a; }};\n#endif"
            for number, condition in enumerate(_UNSIGNED)
        )
        + "\n"
        + _S,
    ),
    same("__TIME__ is defined", "#ifdef __TIME__\n" + _S + "\n#endif"),
    alone(
        "__DATE__",
        "const string D = __DATE__;",
        "IDL0027",
        D='const D: string = "Jan  1 1970"',
    ),
    same("long line", " " * 300_000 + _S),
    refused("unknown directive", "#inclde <x>\n" + _S, "IDL0021"),
    same("null directive", "#\n # \n#/* a */\n" + _S),
    same(
        "line",
        '#line 12\nstruct S { long a; };\n#line 3 "other.idl"\nstruct T { long b; };',
    ),
    same("line marker", '# 12 "other.idl"\nstruct S { long a; };'),
    same(
        "enter and return",
        '# 1 "a.idl" 1\nstruct T { long b; };\n# 2 "input.idl" 2\nstruct S { T t_; };',
    ),
    refused("line without a number", "#line x\n" + _S, "IDL0022"),
    same("__OMNIIDL__", "#ifdef __OMNIIDL__\n" + _S + "\n#endif"),
    same("value of __OMNIIDL__", "const long A = __OMNIIDL__;"),
    same("__STDC__", "#if __STDC_VERSION__ > 0\nconst long A = __STDC__;\n#endif"),
    same("__LINE__", "\n\nconst long A = __LINE__;"),
    same("__FILE__", "const string A = __FILE__;"),
    same(
        "include guard",
        '#include "t.idl"\n#include "t.idl"\nstruct S { T t_; };',
        files={"t.idl": "#ifndef T_\n#define T_\n" + _T + "\n#endif\n"},
    ),
    same(
        "repeated without a guard",
        '#include "t.idl"\n#include "t.idl"\n' + _S,
        files={"t.idl": "#define X long\n"},
    ),
    better(
        "repeated declarations",
        '#include "t.idl"\n#include "t.idl"\nstruct S { T t_; };',
        "IDL0024",
        files={"t.idl": _T},
        S="struct S; t_: T",
    ),
    refused(
        "include cycle",
        '#include "t.idl"\n',
        "IDL0011",
        files={"t.idl": '#include "t.idl"\n'},
    ),
    same(
        "include cycle with guards",
        '#ifndef I_\n#define I_\n#include "t.idl"\nstruct S { T t_; };\n#endif\n',
        files={
            "t.idl": '#ifndef T_\n#define T_\n#include "input.idl"\n'
            + _T
            + "\n#endif\n"
        },
    ),
    same(
        "pragma once",
        '#include "t.idl"\n#include "t.idl"\nstruct S { T t_; };',
        files={"t.idl": "#pragma once\n" + _T},
    ),
    same(
        "include in a module",
        'module M {\n#include "t.idl"\nstruct S { T t_; };\n};',
        files={"t.idl": _T},
    ),
    same(
        "include in a struct",
        'struct S {\n#include "t.inc"\n};',
        files={"t.inc": "long a;\n"},
    ),
    same(
        "include in an expression",
        'const long A =\n#include "t.inc"\n;',
        files={"t.inc": "1 + 2\n"},
    ),
    same(
        "macro of an included file",
        '#include "t.idl"\nstruct S { N a; };',
        files={"t.idl": "#define N long\n"},
    ),
    same(
        "macro for an included file",
        '#define N long\n#include "t.idl"\n',
        files={"t.idl": "struct T { N a; };"},
    ),
    refused(
        "included declarations clash",
        '#include "t.idl"\nstruct T { long a; };',
        "IDL0202",
        files={"t.idl": _T},
    ),
    same(
        "no line end at the end of an included file",
        '#include "t.idl"\n' + _S,
        files={"t.idl": _T},
    ),
    alone("__RTGEN__", "#ifdef __RTGEN__\n" + _S + "\n#endif", S="struct S; a: long"),
]
