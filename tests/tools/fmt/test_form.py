"""The form of texts: one case for each rule, as input and result."""

import pytest

from rtgen.tools.fmt import Options, edits, format_text
from rtgen.tools.fmt.tokens import Language, LexicalError

IDL = [
    ("", ""),
    ("\n\n", ""),
    ("module M{struct S{long a;};};", "module M {\n    struct S { long a; };\n};\n"),
    ("struct S{long a;long b;};", "struct S {\n    long a;\n    long b;\n};\n"),
    (
        "struct S\n{\n\n\tlong   a ;\n\n\n\tlong b;\n\n};",
        "struct S {\n    long a;\n\n    long b;\n};\n",
    ),
    ("enum E{A,B};", "enum E { A, B };\n"),
    ("enum E{A,\nB};", "enum E {\n    A,\n    B\n};\n"),
    ("interface I\n{\n};", "interface I {};\n"),
    ("interface I:A,B{};", "interface I : A, B {};\n"),
    (
        "typedef sequence < sequence<long,3>> T ;",
        "typedef sequence<sequence<long, 3>> T;\n",
    ),
    ("typedef sequence<sequence<long> > T;", "typedef sequence<sequence<long> > T;\n"),
    (
        "typedef sequence<sequence<string<4>>> T;",
        "typedef sequence<sequence<string<4>>> T;\n",
    ),
    (
        "typedef sequence<sequence<string<4> >> T;",
        "typedef sequence<sequence<string<4> >> T;\n",
    ),
    (
        "typedef sequence<sequence<string<4>> > T;",
        "typedef sequence<sequence<string<4>>> T;\n",
    ),
    ("typedef sequence<long,16>>3> T;", "typedef sequence<long, 16 >> 3> T;\n"),
    ("const long X=-1|(A<<2);", "const long X = -1 | (A << 2);\n"),
    ("const ::M::T X = 1.0e-3;", "const ::M::T X = 1.0e-3;\n"),
    ("typedef M :: T A [3] [4],B;", "typedef M::T A[3][4], B;\n"),
    (
        'interface I{ oneway void f( in long a , inout ::T b )raises(X,Y)context("a");};',
        'interface I { oneway void f(in long a, inout ::T b) raises (X, Y) context ("a"); };\n',
    ),
    (
        "union U switch(long){case 1:case -2:long a;default:\nlong b;};",
        "union U switch (long) {\n    case 1: case -2: long a;\n    default:\n        long b;\n};\n",
    ),
    (
        '@rtc( kind = "A" )\ncomponent C{@unit("m") @min(-1)attribute double a;};',
        '@rtc(kind="A")\ncomponent C { @unit("m") @min(-1) attribute double a; };\n',
    ),
    ("struct S{long a;}\n;", "struct S { long a; };\n"),
    ("typedef struct S{long a;} T;", "typedef struct S { long a; } T;\n"),
    (
        "valuetype V:truncatable A supports I{private long a;factory f(in long b);};",
        "valuetype V : truncatable A supports I {\n    private long a;\n    factory f(in long b);\n};\n",
    ),
]

COMMENTS = [
    ("long a;// x\n", "long a; // x\n"),
    ("struct S{ // x\nlong a;/* y */long b;\n// z\n};",
     "struct S { // x\n    long a;\n    /* y */ long b;\n    // z\n};\n"),
    ("/** doc */ struct S;", "/** doc */ struct S;\n"),
    ("interface I {\nvoid f(in long a, // x\n  in long b /* y */);\n};",
     "interface I {\n    void f(in long a, // x\n           in long b /* y */);\n};\n"),
    ("struct S {\n  /** one\n     * two */\n  long a;\n};",
     "struct S {\n    /** one\n     * two */\n    long a;\n};\n"),
    ("module M {\n/* one\n     two\n   three */\n};",
     "module M {\n    /* one\n         two\n       three */\n};\n"),
    ("struct S {\n long a;    // x\n long bcd;  // y\n};",
     "struct S {\n    long a;   // x\n    long bcd; // y\n};\n"),
    ("struct S {\n long a; // x\n long bcd; // y\n};",
     "struct S {\n    long a; // x\n    long bcd; // y\n};\n"),
    ("long a;   /* x\n*/\nlong bcd; // y", "long a; /* x\n         */\nlong bcd; // y\n"),
    ("long a; // x \\\n  still\nlong b;", "long a; // x \\\n  still\nlong b;\n"),
    ("// x \\ \nlong a;", "// x \\ \nlong a;\n"),
    ("@key // x\nlong a;", "@key // x\nlong a;\n"),
]  # fmt: skip

DIRECTIVES = [
    ("module M {\n  #  define A(x) \\\n   x  \nlong a;\n};",
     "module M {\n#  define A(x) \\\n   x\n    long a;\n};\n"),
    ("#ifndef A\n#define A\nmodule M{\n#endif\n};", "#ifndef A\n#define A\nmodule M {\n#endif\n};\n"),
    ("#if 0\n  it's   no code {\n#if X\n#endif\n#else\nlong   a;\n#endif\n",
     "#if 0\n  it's   no code {\n#if X\n#endif\n#else\nlong a;\n#endif\n"),
    ("#ifdef A\nstruct S {\n#else\nstruct T {\n#endif\nlong a;\n};\nlong b;",
     "#ifdef A\nstruct S {\n#else\nstruct T {\n#endif\n    long a;\n};\nlong b;\n"),
    ("#define X /* a\n b */ 1\nlong   a;", "#define X /* a\n b */ 1\nlong a;\n"),
    ("interface I {\nvoid f(in long a\n#ifdef B\n, in long b\n#endif\n);\n};",
     "interface I {\n    void f(in long a\n#ifdef B\n            , in long b\n#endif\n            );\n};\n"),
    ("/* x */ #pragma prefix \"a\"\n", "/* x */\n#pragma prefix \"a\"\n"),
]  # fmt: skip

CDL = [
    ("[active]celltype tA{call sB cB;};", "[active]\ncelltype tA { call sB cB; };\n"),
    ("signature sA{ER f([in,size_is(n*2)]const char_t*p,[out]int32_t**q);};",
     "signature sA { ER f([in, size_is(n * 2)] const char_t *p, [out] int32_t **q); };\n"),
    ("cell tA A{cB=r::C.eD[2];x={1,\n2};y=C_EXP(\"&z\");};",
     "cell tA A {\n    cB = r::C.eD[2];\n    x = { 1,\n        2 };\n    y = C_EXP(\"&z\");\n};\n"),
    ("cell tA A{\n[through(P,\"\")]\ncB=C.eD;cE[]<=F.eG;\ncH=>composite.i;};",
     "cell tA A {\n    [through(P, \"\")]\n    cB = C.eD;\n    cE[] <= F.eG;\n    cH => composite.i;\n};\n"),
    ("celltype tA{attr{[omit]int32_t a=-1;};require tB.eC;};",
     "celltype tA {\n    attr { [omit] int32_t a = -1; };\n    require tB.eC;\n};\n"),
    ("import( <a.cdl> );import_C(\"b.h\");", "import(<a.cdl>);\nimport_C(\"b.h\");\n"),
    ("__tool_info__(\"t\") { \"a\" :  1 }\nregion r{};",
     "__tool_info__(\"t\") { \"a\" :  1 }\nregion r {};\n"),
    ("const int32_t A=(int32_t)2*B?-C:~D;", "const int32_t A = (int32_t) 2 * B ? -C : ~D;\n"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "form"), [*IDL, *COMMENTS, *DIRECTIVES])
def test_idl(text: str, form: str) -> None:
    assert format_text(text, Language.IDL) == form
    assert format_text(form, Language.IDL) == form


@pytest.mark.parametrize(("text", "form"), CDL)
def test_cdl(text: str, form: str) -> None:
    assert format_text(text, Language.CDL) == form
    assert format_text(form, Language.CDL) == form


def test_long_lines() -> None:
    options = Options(line_length=40)
    text = "interface I{\nvoid f(in long first,in sequence<long,3> second)raises(Aaaa,Bbbbbbbbb,C);\n};"
    assert format_text(text, Language.IDL, options) == (
        "interface I {\n"
        "    void f(in long first,\n"
        "           in sequence<long, 3> second)\n"
        "            raises (Aaaa, Bbbbbbbbb, C);\n"
        "};\n"
    )
    text = "const long A_VERY_LONG_NAME = OTHER_NAME | THIRD_NAME;"
    assert format_text(text, Language.IDL, options) == (
        "const long A_VERY_LONG_NAME = OTHER_NAME\n        | THIRD_NAME;\n"
    )


def test_annotations_that_do_not_fit_are_a_line() -> None:
    text = '@unit("m") @constraint("x>0.0") attribute double a_long_name;'
    form = '@unit("m") @constraint("x>0.0")\nattribute double a_long_name;\n'
    for each in (text, form):
        assert format_text(each, Language.IDL, Options(line_length=60)) == form


def test_indent() -> None:
    text = "module M {\nstruct S;\n};"
    form = "module M {\n  struct S;\n};\n"
    assert format_text(text, Language.IDL, Options(indent=2)) == form


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("long a; /* x", (8, 10)),
        ('const string A = "x;\n', (17, 20)),
        ("long a; # b", (8, 9)),
        ("lo\u00b6ng a;", (2, 3)),
        ("a:\\\n:b", (2, 3)),
        ("#define A /* x", (10, 12)),
    ],
)
def test_faults(text: str, place: tuple[int, int]) -> None:
    with pytest.raises(LexicalError) as caught:
        format_text(text, Language.IDL)
    assert (caught.value.start, caught.value.end) == place


def test_edits_are_statements() -> None:
    text = "long  a;\nlong  b;\nlong c;\nstruct  S{\nlong d;};\n"
    found = edits(text, Language.IDL)
    assert [text[e.start : e.end] for e in found] == [
        "long  a;\n",
        "long  b;\n",
        "struct  S{\nlong d;};\n"[:11],
        "long d;};\n",
    ]
    [only] = edits(text, Language.IDL, lines=(2, 3))
    assert only.text == "long b;\n"
    assert edits(text, Language.IDL, lines=(3, 3)) == []
    assert edits(text, Language.IDL, lines=(9, 12)) == []
