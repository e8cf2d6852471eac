"""Words and punctuation of IDL, valid and nearly valid, for both fuzzers."""

from __future__ import annotations

from rtgen.compiler.frontends.idl.syntax.keywords import CORBA_3, RESERVED

KEYWORDS = sorted(RESERVED)
CONTEXTUAL = sorted(CORBA_3 | set("""
        alias bitfield bitmask bitset connector int16 int32 int64 int8 map mirrorport port
        porttype typename uint16 uint32 uint64 uint8
        """.split()))
NEAR = """
    Struct struc strcut structs sequense sequnce interace interfce modul unsinged double_ flaot
    integer int bool byte true false NULL const_ typdef enumeration void* String WString OBJECT
    object valueType char8 unsigned_long longlong final virtual class public: static
    """.split()
MARKS = """
    { } ( ) [ ] < > << >> , ; : :: = | ^ & + - * / % ~ @ # ## \\ ? ! $ . .. -> == && || " ' `
    // /* */
    """.split()
NAMES = """
    A B C a b Foo foo FOO Bar T S E I V X Y M N Data data Time tm _A _struct _ __x RED GREEN
    Object_ ValueBase_ self None class import from print type CORBA TypeCode Inc Once
    """.split()
NUMBERS = """
    0 1 2 3 7 8 16 31 32 63 64 127 128 255 256 32767 32768 65535 2147483647 2147483648 4294967295
    4294967296 9223372036854775807 18446744073709551615 18446744073709551616 00 017 089 0x 0x1F
    0XFFFFFFFF 0x1g 1. .5 1.5 1e10 1E-3 1e400 1e-400 1e 1.5.5 1.0f 1.0L 12d 12.5d 0.0001d 1d.5
    1234567890123456789012345678901d 12345678901234567890123456789012d 1_000 1u 0b1
    """.split()
TEXTS = [
    *(
        '"text"',
        '""',
        'L"wide"',
        'L""',
        '"\\x41" "B"',
        'L"\\u00e9\\uD83D"',
        '"\\0"',
        '"\\q"',
    ),
    *(
        '"open',
        "'c'",
        "L'c'",
        "''",
        "'ab'",
        "'\\''",
        "'\\x4'",
        "'\\377'",
        "'\\400'",
        "'\\u41'",
    ),
    *(
        "L'\\u41'",
        "L'\\uFFFFF'",
        "'",
        '"\\',
        '"a\\\nb"',
        '"a\nb"',
        '"\u00e9"',
        "L'\u3042'",
        "'\u00e9'",
    ),
]
LINES = [
    *(
        "#",
        "#if 1",
        "#if 0",
        "#ifdef A",
        "#ifndef A",
        "#elif 1",
        "#else",
        "#endif",
        "#undef A",
    ),
    *(
        "#define A",
        "#define A B",
        "#define B A",
        "#define F(x) x",
        "#define F(x, y) x ## y",
    ),
    *(
        "#define S(x) #x",
        "#define V(...) __VA_ARGS__",
        "#define A A A",
        "#define F(",
        "#define 1",
    ),
    *(
        "#if defined A && !defined(B)",
        "#if 1 / 0",
        "#if (1 + 2) * 3 == 9",
        "#if 'a' < 1 || A",
    ),
    *("#if 1 ? 2 : 3", "#if", "#if (", "#if 18446744073709551616", "#if __LINE__ > 3"),
    *(
        '#include "guarded.idl"',
        "#include <once.idl>",
        '#include "members.idl"',
        "#include",
    ),
    *(
        '#include "broken.idl"',
        '#include "loop.idl"',
        '#include "input.idl"',
        "#include A",
    ),
    *('#include "absent.idl"', '#include "."', '#include ""', '#include "Guarded.idl"'),
    *(
        "#pragma once",
        '#pragma prefix "p.org"',
        '#pragma prefix ""',
        "#pragma prefix",
        "#pragma",
    ),
    *(
        '#pragma ID A "IDL:a/A:1.0"',
        '#pragma ID A "DCE:1"',
        '#pragma ID A::B "x"',
        "#pragma ID",
    ),
    *(
        "#pragma version A 2.3",
        "#pragma version A x",
        "#pragma keylist T a b",
        "#pragma a b c",
    ),
    *(
        '# 12 "other.idl" 1',
        '#line 7 "input.idl"',
        "#line 0",
        "#line 999999999",
        "#line A",
    ),
    *(
        "#error no",
        "#warning hm",
        "#import",
        "#inlcude <a>",
        "#ident x",
        "# define A 1",
    ),
]
ANNOTATIONS = [
    *(
        "@key",
        "@optional",
        "@id(1)",
        "@id(-1)",
        "@id(0x0FFFFFFF)",
        "@position(0)",
        "@position(64)",
    ),
    *(
        "@value(1)",
        "@final",
        "@appendable",
        "@mutable",
        "@extensibility(MUTABLE)",
        "@nested",
    ),
    *(
        "@bit_bound(8)",
        "@bit_bound(65)",
        "@default(1)",
        '@default("x")',
        "@default",
        "@external",
    ),
    *(
        "@range(min=1, max=2)",
        "@range(max=1, min=2)",
        "@min(0)",
        "@max(1.5)",
        '@unit("m")',
    ),
    *(
        '@verbatim(language="comment", text="a" "b")',
        "@autoid(HASH)",
        '@hashid("x")',
        "@a::b",
    ),
    *(
        "@unknown(x=1, y)",
        "@",
        "@()",
        "@annotation",
        "@annotation A { long x default 1; };",
    ),
    *(
        "@must_understand",
        "@default_literal",
        "@rtc(rate=100.0)",
        '@name("x y")',
        "@topic",
    ),
    *(
        "@try_construct(TRIM)",
        "@default(1 / 0)",
        "@id(A)",
        "@key(FALSE)",
        "@oneway",
        "@service",
    ),
]
