"""Section 4 of the language: types, structs, unions, enums."""

from idl_probes.probe import alone, better, refused, same

PROBES = [
    # Basic types
    same(
        "basic types",
        "struct S { short a; long b; long long c; unsigned short d; unsigned long e; unsigned long long f; float g; double h; long double i; char j; wchar k; boolean l; octet m; any n; Object o; ValueBase p; };",
    ),
    refused("unsigned double", "struct S { unsigned double a; };", "IDL01"),
    refused("unsigned alone", "struct S { unsigned a; };", "IDL01"),
    refused("long short", "struct S { long short a; };", "IDL01"),
    refused("long float", "struct S { long float a; };", "IDL01"),
    refused("int", "struct S { int a; };", "IDL0200"),
    refused("bool", "struct S { bool a; };", "IDL0200"),
    # Text, sequences, arrays, fixed
    same(
        "strings",
        "const long N = 3; struct S { string a; string<5> b; wstring c; wstring<N> d; string<2 * N + 1> e; };",
    ),
    same(
        "sequences",
        "const long N = 3; struct S { sequence<long> a; sequence<string<4>, N> b; sequence<sequence<octet> > c; };",
    ),
    same(
        "fixed type",
        "typedef fixed<5, 2> A; typedef fixed<31, 31> B; typedef fixed<1, 0> C; const long D = 7; typedef fixed<D, D - 3> E;",
    ),
    same(
        "arrays",
        "const long N = 3; typedef long A[N]; struct S { long x[2][3]; A y[4]; };",
    ),
    same(
        "array of an alias of an array",
        "typedef long A[3]; typedef A B[2]; typedef B C[4]; struct S { C c_; };",
    ),
    same(
        "several declarators",
        "typedef long a, b[2], c[3][4]; struct S { long x, y[2]; };",
    ),
    refused("bound 0", "typedef string<0> A;", "IDL0304"),
    refused("negative bound", "typedef sequence<long, -1> A;", "IDL0304"),
    refused("dimension 0", "typedef long A[0];", "IDL0304"),
    refused("floating bound", "typedef string<2.0> A;", "IDL0500"),
    refused("text bound", 'typedef string<"a"> A;', "IDL0500"),
    refused("no dimension", "typedef long A[];", "IDL01"),
    refused("sequence without an element", "typedef sequence<> A;", "IDL01"),
    refused("sequence alone", "typedef sequence A;", "IDL01"),
    refused("string of something", "typedef string<long> A;", "IDL01"),
    refused("fixed with 32 digits", "typedef fixed<32, 2> A;", "IDL0305"),
    refused("fixed with a scale above its digits", "typedef fixed<3, 4> A;", "IDL0305"),
    refused("fixed with a negative scale", "typedef fixed<3, -1> A;", "IDL0305"),
    refused("fixed without digits", "typedef fixed A;", "IDL0305"),
    refused("fixed with digits alone", "typedef fixed<3> A;", "IDL01"),
    # Anonymous types
    same(
        "anonymous in members",
        "struct S { sequence<long> a; string<3> b; long c[2]; sequence<long> d[2]; };",
    ),
    same(
        "anonymous in branches",
        "union U switch (long) { case 1: sequence<long> a; case 2: long b[3]; };",
    ),
    same("anonymous in exceptions", "exception E { sequence<long> a; long b[2]; };"),
    refused(
        "sequence parameter", "interface I { void f(in sequence<long> a); };", "IDL0306"
    ),
    refused("array parameter", "interface I { void f(in long a[3]); };", "IDL0306"),
    refused("sequence result", "interface I { sequence<long> f(); };", "IDL0306"),
    refused(
        "sequence attribute", "interface I { attribute sequence<long> a; };", "IDL0306"
    ),
    refused("array attribute", "interface I { attribute long a[2]; };", "IDL01"),
    same(
        "bounded strings there",
        "interface I { string<3> f(in string<4> a, inout wstring<5> b); attribute string<6> c; };",
    ),
    refused("fixed parameter", "interface I { void f(in fixed<3, 1> a); };", "IDL0306"),
    # In-place declarations
    same(
        "in place in a typedef",
        "typedef struct S { long a; } T; typedef enum E { A } F[2]; typedef union U switch (long) { case 1: long a; } V;",
    ),
    same(
        "in place in a member",
        "struct S { struct T { long a; } t_; enum E { A, B } e_; union U switch (long) { case 1: long a; } u_; };",
    ),
    same(
        "in place in a branch",
        "union U switch (long) { case 1: struct T { long a; } t_; };",
    ),
    same(
        "in place in a switch",
        "union U switch (enum E { A, B }) { case A: long x; case B: short y; };",
    ),
    same("in place in an exception", "exception X { enum E { A } e_; };"),
    same(
        "in place in an interface's typedef", "interface I { typedef enum E { A } F; };"
    ),
    refused(
        "in place in an operation",
        "interface I { void f(in struct S { long a; } b); };",
        "IDL0306",
    ),
    refused(
        "in place in an attribute",
        "interface I { attribute enum E { A } b; };",
        "IDL0306",
    ),
    refused(
        "in place in a sequence", "typedef sequence<struct S { long a; }> T;", "IDL0306"
    ),
    refused("tag is mandatory", "typedef struct { long a; } T;", "IDL0104"),
    refused("tag of an enum is mandatory", "typedef enum { A } T;", "IDL0104"),
    refused(
        "tag of a member is mandatory", "struct S { struct { long a; } b; };", "IDL0104"
    ),
    same(
        "constants of types in place",
        "struct S { enum E { A, B } e_; }; const S::E C = S::B;",
    ),
    # void, exceptions, native
    same("void result", "interface I { void f(); };"),
    refused("void member", "struct S { void a; };", "IDL0303"),
    refused("void parameter", "interface I { void f(in void a); };", "IDL0303"),
    refused("void attribute", "interface I { attribute void a; };", "IDL0303"),
    refused("void typedef", "typedef void T;", "IDL0303"),
    refused("sequence of void", "typedef sequence<void> T;", "IDL0303"),
    refused("void constant", "const void C = 1;", "IDL0310"),
    refused("exception member", "exception E {}; struct S { E a; };", "IDL0210"),
    refused(
        "exception parameter",
        "exception E {}; interface I { void f(in E a); };",
        "IDL0210",
    ),
    refused("exception result", "exception E {}; interface I { E f(); };", "IDL0210"),
    refused(
        "sequence of exceptions", "exception E {}; typedef sequence<E> T;", "IDL0210"
    ),
    refused("typedef of an exception", "exception E {}; typedef E T;", "IDL0210"),
    same(
        "native",
        "native N; interface I { N f(in N a); attribute N b;}; struct S { N a; }; typedef sequence<N> Ns; union U switch (long) { case 1: N a; };",
    ),
    refused("native declarator", "native N[3];", "IDL01"),
    # Structs
    same(
        "struct of everything",
        "interface I {}; enum E { A }; struct T { long a; }; union U switch (long) { case 1: long a; }; valuetype V {}; native N; struct S { I a_; E b; T c; U d; V f; N g; };",
    ),
    refused("constant in a struct", "struct S { const long C = 1; long a; };", "IDL01"),
    refused("typedef in a struct", "struct S { typedef long T; T a; };", "IDL01"),
    refused("member without a type", "struct S { a; };", "IDL01"),
    refused("members clash", "struct S { long a; short a; };", "IDL0202"),
    refused("struct without a brace", "struct S long a; };", "IDL01"),
    # Unions: the switch
    *(
        same(
            f"switch on {kind}",
            f"union U switch ({kind}) {{ case {label}: long a; default: short b; }};",
        )
        for kind, label in {
            "short": "-1",
            "long": "-2",
            "long long": "-3",
            "unsigned short": "1",
            "unsigned long": "2",
            "unsigned long long": "3",
            "char": "'a'",
            "boolean": "TRUE",
        }.items()
    ),
    same(
        "switch on an enum",
        "enum E { A, B, C }; union U switch (E) { case A: long a_; case B: case C: short b_; };",
    ),
    same(
        "switch on an alias",
        "typedef long T; typedef T V; union U switch (V) { case 1: long a; };",
    ),
    same(
        "switch on an alias of an enum",
        "enum E { A, B }; typedef E F; union U switch (F) { case A: long a_; };",
    ),
    better(
        "switch on wchar",
        "union U switch (wchar) { case L'a': long a; };",
        U="union U switch (wchar); 'a': long a",
    ),
    better(
        "switch on octet",
        "union U switch (octet) { case 1: long a; };",
        U="union U switch (octet); 1: long a",
    ),
    alone(
        "switch on int8 and uint8",
        "union U switch (int8) { case -1: long a; }; union V switch (uint8) { case 255: long a; };",
        U="union U switch (int8); -1: long a",
        V="union V switch (uint8); 255: long a",
    ),
    *(
        refused(
            f"switch on {kind}",
            f"typedef sequence<long> Seq; struct St {{ long a; }}; typedef long Arr[2]; union U switch ({kind}) {{ case 1: long a; }};",
            "IDL0400",
        )
        for kind in ("float", "double", "string", "any", "Object", "Seq", "St", "Arr")
    ),
    # Unions: labels
    same(
        "several labels", "union U switch (long) { case 1: case 2: case 3: long a; };"
    ),
    same(
        "labels that are expressions",
        "const short N = 3; union U switch (long) { case N + 1: long a; case N * N: short b; };",
    ),
    same("default", "union U switch (long) { case 1: long a; default: short b; };"),
    same(
        "default first", "union U switch (long) { default: short b; case 1: long a; };"
    ),
    same(
        "default beside labels",
        "union U switch (long) { case 1: default: case 2: long a; };",
    ),
    same("only a default", "union U switch (long) { default: long a; };"),
    same(
        "character labels",
        r"union U switch (char) { case 'a': case '\n': case '\'': case '\xff': long a; };",
    ),
    same(
        "boolean labels",
        "union U switch (boolean) { case TRUE: long a; case FALSE: short b; };",
    ),
    same(
        "constant of the kind as a label",
        "const char C = 'a'; const boolean D = TRUE; union U switch (char) { case C: long a; }; union V switch (boolean) { case D: long a; };",
    ),
    same(
        "qualified label",
        "module M { enum E { A, B }; }; union U switch (M::E) { case M::A: long a_; };",
    ),
    better(
        "label of an enum elsewhere",
        "module M { enum E { A, B }; }; union U switch (M::E) { case A: long a_; };",
        U="union U switch (M::E); M::A: long a_",
    ),
    better(
        "label by its enum",
        "enum E { A, B }; union U switch (E) { case E::A: long a_; };",
        "IDL0213",
        U="union U switch (E); A: long a_",
    ),
    refused(
        "label twice",
        "union U switch (long) { case 1: long a; case 1: short b; };",
        "IDL0401",
    ),
    refused(
        "label twice by value",
        "const long N = 2; union U switch (long) { case N: long a; case 1 + 1: short b; };",
        "IDL0401",
    ),
    refused(
        "boolean label twice",
        "union U switch (boolean) { case TRUE: long a; case TRUE: short b; };",
        "IDL0401",
    ),
    refused(
        "enum label twice",
        "enum E { A, B }; union U switch (E) { case A: case A: long a_; };",
        "IDL0401",
    ),
    refused(
        "label out of range",
        "union U switch (short) { case 40000: long a; };",
        "IDL0501",
    ),
    refused(
        "negative label",
        "union U switch (unsigned long) { case -1: long a; };",
        "IDL0501",
    ),
    refused(
        "label of the wrong kind",
        "union U switch (long) { case 'a': long a; };",
        "IDL0500",
    ),
    refused(
        "number for a boolean",
        "union U switch (boolean) { case 1: long a; };",
        "IDL0500",
    ),
    refused(
        "number for an enum",
        "enum E { A }; union U switch (E) { case 0: long a_; };",
        "IDL0500",
    ),
    refused(
        "enumerator of another enum as a label",
        "enum E { A }; enum F { B }; union U switch (E) { case B: long a_; };",
        "IDL0506",
    ),
    refused(
        "enumerator for a number",
        "enum E { A }; union U switch (long) { case A: long a_; };",
        "IDL0500",
    ),
    refused("unknown label", "union U switch (long) { case N: long a; };", "IDL0200"),
    refused(
        "default twice",
        "union U switch (long) { default: long a; default: short b; };",
        "IDL0402",
    ),
    refused(
        "superfluous default, boolean",
        "union U switch (boolean) { case TRUE: long a; case FALSE: short b; default: char c; };",
        "IDL0403",
    ),
    refused(
        "superfluous default, enum",
        "enum E { A, B }; union U switch (E) { case A: long a_; case B: short b_; default: char c; };",
        "IDL0403",
    ),
    refused(
        "superfluous default, beside",
        "enum E { A, B }; union U switch (E) { case A: long a_; case B: default: short b_; };",
        "IDL0403",
    ),
    refused(
        "superfluous default, 256 characters",
        "union U switch (char) { "
        + " ".join(f"case '\\x{c:x}':" for c in range(1, 256))
        + " case '\\0': long a; default: short b; };",
        "IDL0403",
    ),
    same(
        "255 characters and a default",
        "union U switch (char) { "
        + " ".join(f"case '\\x{c:x}':" for c in range(1, 256))
        + " long a; default: short b; };",
    ),
    refused(
        "branch names clash",
        "union U switch (long) { case 1: long a; case 2: short a; };",
        "IDL0202",
    ),
    refused("no branch", "union U switch (long) {};", "IDL0404"),
    refused("branch without a label", "union U switch (long) { long a; };", "IDL01"),
    refused(
        "two names in a branch",
        "union U switch (long) { case 1: long a, b; };",
        "IDL01",
    ),
    refused("switch without a type", "union U switch () { case 1: long a; };", "IDL01"),
    # Enums
    same("enum", "enum E { A, B, C }; const E D = C;"),
    same("enum of one", "enum E { A };"),
    refused("trailing comma", "enum E { A, B, };", "IDL0115"),
    refused("values", "enum E { A = 1, B = 2 };", "IDL0117"),
    refused("empty enum", "enum E {};", "IDL0116"),
    refused("enumerator twice", "enum E { A, A };", "IDL0202"),
    refused("enumerators differ in case", "enum E { A, a };", "IDL0203"),
    refused("enumerator named like the enum", "enum E { E };", "IDL0202"),
    refused("semicolons in an enum", "enum E { A; B };", "IDL01"),
    refused("missing comma in an enum", "enum E { A B };", "IDL01"),
]
