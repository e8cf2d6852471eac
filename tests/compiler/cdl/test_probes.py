"""Short CDL texts that rtgen accepts if tecsgen 1.7 does, or refuses by which rule.

Each row has the message of tecsgen (empty without one), rtgen's rule, and the text.
"""

from __future__ import annotations

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.cdl import read_text

TAKEN = """
const int32_t A = 1
const int32_t A = 0, B = 017, C = 0x1F, D = -5, E = 'a', F = '\\n'
const int32_t A = 08
const float32_t A = 1., B = 1.5e-3, C = 1.e5, D = 2
const int32_t A = (1 + 2) * 3 / 2 % 4 - ~1
const bool_t A = 1 < 2 && !(3 == 4) || true
const int32_t A = true ? 1 : 2
const int32_t A = (int32_t)1.5
const bool_t A = 5
const bool_t A = 0; const int32_t B = A + 1; const bool_t C = A == 0
const float32_t A = 2; const int32_t B = A % 2 << 1
const char_t *const A = "a" "b"
const char_t *const A = 0
const int32_t *const A = (int32_t *)0x300
const int32_t A = C_EXP( "X" )
const volatile int32_t A = 1
/* comment */ const /* inside */ int32_t A = 1 // behind
const int32_t in = 1, out = 2, string = in, size_is = 3
typedef int32_t T; const T A = 1
typedef int32_t T, *P, Q[3]
typedef [string] char_t *T
typedef const int32_t T; T A = 1
typedef unsigned int T; typedef signed char U; typedef unsigned long V
typedef int32_t (*T)( void ); typedef void (*U)( int8_t a, T b )
struct tagA { int32_t a; }
struct tagA { int32_t a, *b, c[2][3]; struct tagA *next; }
struct t { int8_t a, *b; }; struct t { int8_t a; int8_t *b; }
struct tagA { [size_is(n)] int8_t *p; int32_t n; [string] char_t *s; [string(8)] char_t *t; }
typedef struct { int32_t a; } A; typedef struct tagB { A a; } B
struct tagA { struct tagB { int32_t b; } b; }
enum e { A, B = 3, C }
enum8 { A }; enum64 f { B }
namespace nA { const int32_t B = 1; }; const int32_t C = nA::B + ::nA::B
namespace nA { typedef int32_t T; }; namespace nA { const T C = 1; }
namespace nA { const int32_t A = 1; namespace nB { const int32_t B = A; }; }
signature s { }
signature s { void f( void ); }
[context( "any" ), callback, deviate] signature s { void f( void ); }
[generate( MrubyBridgePlugin, "" )] signature s { void f( void ); }
signature s { void f( [in] int8_t a, [out] int8_t *b, [inout] int8_t *c ); }
signature s { [oneway] void f( [in] int8_t a ); }
signature s { void f( [in,string] const char_t *a, [in,string(8)] const char_t *b ); }
signature s { void f( [in,size_is(n)] const int8_t *a, [in] int32_t n ); }
signature s { void f( [out,size_is(n),count_is(*m)] int8_t *a, [in] int32_t n, [inout] int32_t *m ); }
signature s { void f( [in,size_is(n,8)] const int8_t *a, [in] int32_t n ); }
signature s { void f( [in,size_is(n),string] const char_t **a, [in] int32_t n ); }
signature s { void f( [in,nullable] const int8_t *a ); }
signature s { void f( [in] const int8_t a[3], [in] const int8_t (*b)[4], [in] const int8_t *c[2] ); }
signature s { void f( [in] const void *a ); }
signature s { void f( [in,size_is(*n)] const int8_t *a, [out] int32_t *n ); }
signature s { void f( [in] Descriptor( s ) a ); }
struct t { int8_t a; struct t *next; struct u *other; }; signature s { struct t *f( [in] const struct t *a ); }
signature s { void f( [in,string(true)] const char_t *a, [in,size_is(4.0)] const int8_t *b ); }
signature s { void f( [in,count_is(n),nullable] const int8_t *a, [in] int32_t n ); }
signature s { void f( [in,size_is(n)] const void **a, [in] int32_t n ); }
const bool_t A = 1.5, B = "text", C = (int8_t *)1
const int32_t A = 1 + true, B = 7 % 4; const float32_t C = 5.5 % 2; const bool_t D = 1 == true
const uint16_t *const A = (int16_t *)0x10; const int8_t *const B = 0, **const C = (uint8_t **)1
typedef int16_t T; const T *const A = (T *)0x10; typedef T U; const U *const B = (T *)1
struct t { int8_t a; }; celltype c { attr { struct t a = { 1 }; }; var { struct t b = a; }; }
celltype c { attr { int8_t *a; }; var { int16_t *b = a; }; }
struct t { int8_t a; }; celltype c { attr { bool_t a = "x", b = 0.5; struct t *c = C_EXP( "X" ); }; }
signature a { void f( void ); }; signature s { void f( [send(a)] int8_t *x, [receive(a)] int8_t **y ); }
signature s { void in( [in] int8_t out, [out] int8_t *through ); }
celltype t { attr { int32_t id = 1; }; }
celltype t { attr { int32_t a = 1, b; const char_t *c = "x"; }; var { int32_t d = a; }; }
celltype t { attr { int32_t a = 1; }; }; generate( RepeatCellPlugin, t, "" )
"""
"""Statements without their last `;`, one row each."""

WARNED = [
    ("W1001", "CDL0400", '[context( "irq" )] signature s { void f( void ); };'),
    ("W2001", "CDL0303", "const signed int8_t A = 1;"),
    ("W2002", "CDL0303", "const unsigned int8_t A = 1;"),
    ("W3001", "CDL0410", "signature s { void f( [in,in] int8_t a ); };"),
    ("W3002", "CDL0412", "signature s { void f( [out,string] char_t *a ); };"),
    ("W3003", "CDL0414", "signature s { void f( [out] int8_t **a ); };"),
    ("W3004", "CDL0405", "signature s { int8_t *f( void ); };"),
    (
        "W3005",
        "CDL0424",
        "signature s { void f( [in,size_is(2,4)] const int8_t *a ); };",
    ),
    ("W5010", "CDL0404", "signature s { void f(); };"),
    (
        "",
        "CDL0812",
        "struct t { int8_t a; }; [active] celltype c { attr { struct t a = { 1, 2 }; }; };",
    ),
    ("S2017", "CDL0430", "signature s { void f( [in,size_is(2*n)] const int8_t *a, [in] int8_t n ); };"),
    ("S2017", "CDL0430", "signature s { void f( [in,size_is((n))] const int8_t *a, [in] int8_t n ); };"),
    ("S2017", "CDL0430", "signature s { void f( [in,size_is(n<<1)] const int8_t *a, [in] int8_t n ); };"),
    ("", "CDL0308", "signature s { void f( [in] enum e a ); };"),
]  # fmt: skip

REFUSED = [
    ("G1001", "CDL0406", "signature s { void f( int8_t a ); };"),
    ("G1002", "CDL0407", "signature s { void f( int8_t ); };"),
    ("G1003", "CDL0407", "signature s { void f( [in] int8_t ); };"),
    ("G1009", "CDL0214", "[active] const int32_t A = 1;"),
    ("G1010", "CDL0402", "signature s { int8_t f; };"),
    ("G1011", "CDL0402", "signature s { [oneway] int8_t f; };"),
    ("G1015", "CDL0207", "const int32_t A = "),
    ("G1015", "CDL0205", "signature s {\n"),
    ("G1016", "CDL0200", "cell t { };"),
    ("G1016", "CDL0201", "signature s { void f( void ); }"),
    ("G1016", "CDL0202", "signatur s { void f( void ); };"),
    ("G1016", "CDL0203", "const int32_t cell = 1;"),
    ("G1016", "CDL0203", "signature s { void f( [in,size_is(in)] const int8_t *a ); };"),
    ("G1016", "CDL0204", "typedef int32_t T; typedef int32_t T;"),
    ("G1016", "CDL0204", "typedef int32_t T; const int32_t T = 1;"),
    ("G1016", "CDL0206", "};"),
    ("G1016", "CDL0208", "celltype t { };"),
    ("G1016", "CDL0208", "struct s { };"),
    ("G1016", "CDL0208", "namespace n { };"),
    ("G1016", "CDL0209", "const int32_t A = 1;;"),
    ("G1016", "CDL0212", "const int32_t A = (1;"),
    ("G1016", "CDL0213", "const int8_t A = 1; struct s { int8_t const a; };"),
    ("G1016", "CDL0213", "signature s { void f( [in] volatile const int8_t a ); };"),
    ("G1016", "CDL0215", "[activ] celltype t { attr { int8_t a = 1; }; };"),
    ("G1016", "CDL0300", "const float A = 1.0;"),
    ("G1016", "CDL0300", "const A B = 1;"),
    ("G1016", "CDL0300", "namespace n { typedef int8_t T; }; const T A = 1;"),
    ("G1016", "CDL0300", "union u { int8_t a; };"),
    ("G1016", "CDL0103", "#define A 1\n"),
    ("G1016", "CDL0104", "const bool_t A = 1 << 2; const bool_t B = 3 > 2;"),
    ("G1016", "CDL0104", "const bool_t A = 1 <= 2; const bool_t B = 3 > 2;"),
    ("G1016", "CDL0105", "const int32_t A = 1U;"),
    ("G1016", "CDL0105", "const int32_t A = 0X10;"),
    ("G1016", "CDL0105", "const float32_t A = 1e5;"),
    ("", "CDL0102", 'const char_t *const A = "a\n";'),
    ("S1094", "CDL0802", 'const char_t *A = "a";'),
    ("S1095", "CDL0802", "int32_t A = 1;"),
    ("S1096", "CDL0801", "struct t { int8_t a; }; const struct t A = { 1 };"),
    ("S1097", "CDL0800", "const int32_t A;"),
    ("S1001", "CDL0401", '[context("any"),context("any")] signature s { void f( void ); };'),
    ("S1148", "CDL0006", 'import( "nothing.cdl" );'),
    ("S1142", "CDL0900", 'import_C( "nothing.h" );'),
    ("S2001", "CDL0301", "const int32_t A = 1; const int32_t A = 1;"),
    ("S2001", "CDL0301", "struct t { int8_t a; }; struct t { int8_t b; };"),
    ("S2001", "CDL0301", "struct t { int8_t a; }; struct t { int16_t a; };"),
    ("S2001", "CDL0307", "struct t { int8_t a, a; };"),
    ("S2001", "CDL0403", "signature s { void f( void ); void f( void ); };"),
    ("S2001", "CDL0428", "signature s { void f( [in] int8_t a, [in] int8_t a ); };"),
    ("S2006", "CDL0429", "signature s { void f( [in] void g( void ) ); };"),
    ("S2007", "CDL0305", "signature s { void f( [in] const int8_t a[2][] ); };"),
    ("S2008", "CDL0409", "signature s { void f( [in,out] int8_t *a ); };"),
    ("S2009", "CDL0411", "signature s { void f( [send(x)] int8_t *a ); };"),
    ("S2011", "CDL0401", "signature s { void f( [in,size_is(1),size_is(1)] const int8_t *a ); };"),
    ("S2012", "CDL0401", "signature s { void f( [in,count_is(1),count_is(1)] const int8_t *a ); };"),
    ("S2013", "CDL0401", "signature s { void f( [in,string,string] const char_t *a ); };"),
    ("S2014", "CDL0408", "signature s { void f( [nullable] int8_t *a ); };"),
    ("S2014", "CDL0413", "signature s { void f( [out] int8_t a ); };"),
    ("S2014", "CDL0413", "signature s { void f( [out] int8_t a[3] ); };"),
    ("S2015", "CDL0415", "signature s { void f( [in] int8_t *a ); };"),
    ("S2016", "CDL0416", "signature s { void f( [out] const int8_t *a ); };"),
    ("S2017", "CDL0420", "signature s { void f( [in,size_is(n)] const int8_t *a, [inout] int8_t *n ); };"),
    ("S2018", "CDL0421", "signature s { void f( [in,size_is(0)] const int8_t *a ); };"),
    ("S2020", "CDL0420", "signature s { void f( [in,count_is(1.5)] const int8_t *a ); };"),
    ("S2021", "CDL0421", "signature s { void f( [in,count_is(-1)] const int8_t *a ); };"),
    ("S2023", "CDL0420", "signature s { void f( [in,string(n)] const char_t *a, [in] bool_t n ); };"),
    ("S2025", "CDL0421", "signature s { void f( [in,string(false)] const char_t *a ); };"),
    ("T1022", "CDL0302", "signature s { void f( [in] const struct u *a ); };"),
    ("T1022", "CDL0302", "signature s { struct u *f( void ); };"),
    ("T1022", "CDL0302", "typedef struct u *T;"),
    ("T1022", "CDL0302", "typedef struct u T;"),
    ("T1022", "CDL0302", "const struct u *const A = 0;"),
    ("T1022", "CDL0302", "celltype c { attr { struct u *a = 0; }; };"),
    ("T1022", "CDL0302", "celltype c { var { struct u **a; }; };"),
    ("G1016", "CDL0401", "signature s { [oneway,oneway] void f( void ); };"),
    ("T1031", "CDL0810", 'celltype c { attr { int8_t a[2] = C_EXP( "X" ); }; };'),
    ("T1032", "CDL0811", "const int16_t *const A = (int8_t *)0x10;"),
    ("T1032", "CDL0811", "const int8_t **const A = (int16_t **)1;"),
    ("T1032", "CDL0811", "const float32_t *const A = (int32_t *)1;"),
    ("T1032", "CDL0811", "const int8_t *const A = (int8_t *)1; const int16_t *const B = A;"),
    ("T1032", "CDL0811", "typedef int16_t T; const T *const A = (int16_t *)0x10;"),
    ("T1034", "CDL0811", 'typedef char_t T; const T *const A = "a";'),
    ("T1040", "CDL0418", "signature s { void f( [in,size_is(1),string] const void **a ); };"),
    ("V1001", "CDL0806", 'const bool_t A = "a" == "b";'),
    ("V1001", "CDL0806", "const bool_t A = true + 1;"),
    ("V1018", "CDL0807", "const float32_t A = 1.5 % 0;"),
    ("V1019", "CDL0806", "const bool_t A = (bool_t)1.5;"),
    ("S2024", "CDL0421", "signature s { void f( [in,string(0)] const char_t *a ); };"),
    ("S2027", "CDL0306", "signature s { void f( [in] void a ); };"),
    ("S2028", "CDL0422", "signature s { void f( [in,size_is(n,0)] const int8_t *a, [in] int8_t n ); };"),
    ("S2029", "CDL0804", "signature s { void f( [in,size_is(n,n)] const int8_t *a, [in] int8_t n ); };"),
    ("S2030", "CDL0423", "signature s { void f( [in,size_is(4,2)] const int8_t *a ); };"),
    ("S2030", "CDL0423", "signature s { void f( [in,size_is(4,4)] const int8_t *a ); };"),
    ("T1003", "CDL0417", "signature s { void f( [in,nullable] int8_t a ); };"),
    ("T1007", "CDL0306", "struct t { void a; };"),
    ("T1008", "CDL0304", "const signed uint8_t A = 1;"),
    ("T1011", "CDL0809", "const int32_t A = 1.5;"),
    ("T1011", "CDL0809", "const int32_t A = (int32_t)10/3.0;"),
    ("T1012", "CDL0806", "const int32_t A = 1 < 2;"),
    ("T1012", "CDL0806", "const bool_t A = true; const int32_t B = A;"),
    ("T1013", "CDL0808", "const int8_t A = 128;"),
    ("T1014", "CDL0808", "const int8_t A = -129;"),
    ("T1015", "CDL0808", "const uint8_t A = -1;"),
    ("T1016", "CDL0808", "const uint8_t A = 256;"),
    ("T1017", "CDL0810", "const int8_t A = { 1 };"),
    ("T1024", "CDL0810", "struct t { int8_t a; }; celltype c { attr { struct t a = 1; }; };"),
    ("T1029", "CDL0426", "signature s { [oneway] int8_t f( void ); };"),
    ("T1030", "CDL0427", "signature s { [oneway] void f( [out] int8_t *a ); };"),
    ("T1031", "CDL0810", "celltype c { attr { int8_t a[2] = 1; }; };"),
    ("T1031", "CDL0810", 'celltype c { attr { char_t a[2] = "a"; }; };'),
    ("T1034", "CDL0811", 'const int16_t *const A = "a";'),
    ("T1040", "CDL0418", "signature s { void f( [in,size_is(1)] const void *a ); };"),
    ("T9999", "CDL0419", "signature s { void f( [in,size_is(1),nullable] const int8_t *a ); };"),
    ("E1001", "CDL0804", "const int32_t A = B;"),
    ("E1004", "CDL0805", "const int32_t A = 1; const int32_t B = A[0];"),
    ("E1005", "CDL0805", "const int32_t A = 1; const int32_t B = A.b;"),
    ("E1007", "CDL0805", "const int32_t A = 1; const int32_t B = &A;"),
    ("E1015", "CDL0425", "signature s { void f( [in,size_is(n)] const int8_t *a, [receive(s)] int8_t n ); };"),
    ("V1001", "CDL0806", "const float32_t A = 1.0 << 2;"),
    ("V1001", "CDL0806", 'const int32_t A = 10 / "A";'),
    ("V1005", "CDL0806", 'const int16_t *const A = (int16_t *)"a";'),
    ("V1009", "CDL0807", "const int32_t A = 10 / 0;"),
    ("V1010", "CDL0807", "const float32_t A = 10 / 0.0;"),
    ("V1014", "CDL0806", "const bool_t A = true == 1;"),
    ("V1020", "CDL0806", "const bool_t A = 1.5 && true;"),
]  # fmt: skip


def _found(text: str) -> dict[str, Severity]:
    _, diagnostics = read_text(text, prelude=False)
    return {d.code: d.severity for d in diagnostics}


@pytest.mark.parametrize("text", TAKEN.strip().split("\n"))
def test_taken(text: str) -> None:
    found = _found(text.replace(" //", ";//") if "//" in text else f"{text};")
    assert Severity.ERROR not in found.values(), found


@pytest.mark.parametrize(("message", "rule", "text"), WARNED)
def test_warned_of(message: str, rule: str, text: str) -> None:
    assert _found(text) == {rule: Severity.WARNING}, message


@pytest.mark.parametrize(("message", "rule", "text"), REFUSED)
def test_refused(message: str, rule: str, text: str) -> None:
    assert _found(text).get(rule) is Severity.ERROR, message
