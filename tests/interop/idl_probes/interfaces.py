"""Section 4 of the language: interfaces and valuetypes."""

from idl_probes.probe import better, refused, same

PROBES = [
    same(
        "interface of everything",
        "interface I { typedef long T; struct S { long a; }; union U switch (long) { case 1: long a; }; enum E { A }; const long C = 1; exception X { long a; }; native N; attribute long at; void f(in T a, out S b, inout U c) raises(X); };",
    ),
    refused("interface in an interface", "interface I { interface J {}; };", "IDL01"),
    refused(
        "module in an interface",
        "interface I { module M { typedef long T; }; };",
        "IDL01",
    ),
    refused("valuetype in an interface", "interface I { valuetype V {}; };", "IDL01"),
    refused(
        "forward interface in an interface", "interface I { interface J; };", "IDL01"
    ),
    same("several bases", "interface A {}; interface B {}; interface C : A, B {};"),
    same(
        "base by a qualified name",
        "module M { interface A {}; }; interface B : M::A {}; interface C : ::M::A {};",
    ),
    same(
        "base through a typedef",
        "interface A {}; typedef A B; typedef B C; interface D : C {};",
    ),
    refused("base twice", "interface A {}; interface B : A, A {};", "IDL0600"),
    refused(
        "base twice through a typedef",
        "interface A {}; typedef A T; interface B : A, T {};",
        "IDL0600",
    ),
    refused("base Object", "interface I : Object {};", "IDL0301"),
    refused(
        "base that is a struct", "struct S { long a; }; interface I : S {};", "IDL0301"
    ),
    refused(
        "base that is a valuetype", "valuetype V {}; interface I : V {};", "IDL0301"
    ),
    refused("base unknown", "interface I : Nothing {};", "IDL0200"),
    refused("base itself", "interface I : I {};", "IDL0300"),
    refused("no base after the colon", "interface I : {};", "IDL01"),
    same(
        "abstract",
        "abstract interface A { void f(); }; abstract interface B : A {}; interface C : B {};",
    ),
    refused(
        "abstract from plain", "interface A {}; abstract interface B : A {};", "IDL0601"
    ),
    same(
        "local",
        "local interface L { void f(); }; interface I {}; local interface M : I, L {};",
    ),
    refused("plain from local", "local interface L {}; interface I : L {};", "IDL0602"),
    refused(
        "abstract from local",
        "local interface L {}; abstract interface A : L {};",
        "IDL0601",
        "IDL0602",
    ),
    same(
        "local mentions local",
        "local interface L {}; local interface M { L f(in L a); attribute L b; };",
    ),
    refused(
        "local parameter",
        "local interface L {}; interface I { void f(in L a); };",
        "IDL0308",
    ),
    refused("local result", "local interface L {}; interface I { L f(); };", "IDL0308"),
    refused(
        "local attribute",
        "local interface L {}; interface I { attribute L a; };",
        "IDL0308",
    ),
    refused(
        "local in a struct",
        "local interface L {}; struct S { L a; }; interface I { void f(in S b); };",
        "IDL0308",
    ),
    refused(
        "local in a sequence",
        "local interface L {}; typedef sequence<L> Ls; interface I { void f(in Ls a); };",
        "IDL0308",
    ),
    refused(
        "local in a union",
        "local interface L {}; union U switch (long) { case 1: L a; }; interface I { U f(); };",
        "IDL0308",
    ),
    refused(
        "local in an exception",
        "local interface L {}; exception E { L a; }; interface I { void f() raises(E); };",
        "IDL0308",
    ),
    same("local in a struct of its own", "local interface L {}; struct S { L a; };"),
    refused("local abstract", "local abstract interface I {};", "IDL01"),
    # Operations
    same(
        "directions", "interface I { long f(in long a, out short b, inout char c); };"
    ),
    refused("missing direction", "interface I { void f(long a); };", "IDL0118"),
    refused("missing parameter name", "interface I { void f(in long); };", "IDL01"),
    refused("missing result", "interface I { f(); };", "IDL01"),
    refused("two directions", "interface I { void f(in out long a); };", "IDL01"),
    refused(
        "trailing comma in parameters", "interface I { void f(in long a,); };", "IDL01"
    ),
    refused("C's (void)", "interface I { void f(void); };", "IDL01"),
    same(
        "raises",
        "exception E {}; exception F { long a; }; interface I { void g() raises(E, F); };",
    ),
    same(
        "raises a qualified name",
        "module M { exception E {}; }; interface I { void f() raises(M::E); void g() raises(::M::E); };",
    ),
    refused("raises()", "interface I { void f() raises(); };", "IDL0119"),
    refused("raises nothing known", "interface I { void f() raises(E); };", "IDL0200"),
    same(
        "raised twice",
        "exception E {}; interface I { void f() raises(E, E); };",
        "IDL0606",
    ),
    refused(
        "raises a struct",
        "struct S { long a; }; interface I { void f() raises(S); };",
        "IDL0605",
    ),
    refused(
        "raises an interface",
        "interface J {}; interface I { void f() raises(J); };",
        "IDL0605",
    ),
    better(
        "raises a native",
        "native N; interface I { void f() raises(N); };",
        I="interface I; f(): void",
    ),
    same("oneway", "interface I { oneway void f(in long a, in string b); };"),
    refused("oneway with a result", "interface I { oneway long f(); };", "IDL0607"),
    refused(
        "oneway with out", "interface I { oneway void f(out long a); };", "IDL0607"
    ),
    refused(
        "oneway with inout", "interface I { oneway void f(inout long a); };", "IDL0607"
    ),
    refused(
        "oneway with raises",
        "exception E {}; interface I { oneway void f() raises(E); };",
        "IDL0607",
    ),
    refused("oneway attribute", "interface I { oneway attribute long a; };", "IDL01"),
    same(
        "context", 'interface I { void f() context("a", "b.c", "d_1", "e.*", "f*"); };'
    ),
    same(
        "raises, then context",
        'exception E {}; interface I { void f() raises(E) context("a"); };',
    ),
    same("oneway with context", 'interface I { oneway void f() context("a"); };'),
    refused(
        "context, then raises",
        'exception E {}; interface I { void f() context("a") raises(E); };',
        "IDL01",
    ),
    refused(
        "context begins with a digit",
        'interface I { void f() context("1a"); };',
        "IDL0608",
    ),
    refused(
        "context with a star inside",
        'interface I { void f() context("a*b"); };',
        "IDL0608",
    ),
    refused(
        "context that is a star", 'interface I { void f() context("*"); };', "IDL0608"
    ),
    refused(
        "context with a blank", 'interface I { void f() context("a b"); };', "IDL0608"
    ),
    refused(
        "context that is empty", 'interface I { void f() context(""); };', "IDL0608"
    ),
    refused("context()", "interface I { void f() context(); };", "IDL01"),
    refused(
        "context with two stars", 'interface I { void f() context("a**"); };', "IDL0608"
    ),
    # Attributes
    same(
        "attributes",
        "interface I { attribute long a, b; readonly attribute string c; };",
    ),
    refused("readonly alone", "interface I { readonly long a; };", "IDL01"),
    refused("attribute without a name", "interface I { attribute long; };", "IDL01"),
    refused("readonly behind", "interface I { attribute readonly long a; };", "IDL01"),
    # Valuetypes
    same(
        "valuetype",
        "exception E {}; valuetype V { public long a; private string b, c[2]; factory make(in long a_) raises(E); void f(in long x); attribute long at; typedef long T; const long D = 1; };",
    ),
    same("empty valuetype", "valuetype V {};"),
    same(
        "valuetype base",
        "valuetype A { public long x; }; valuetype B : A { public long y; };",
    ),
    same(
        "truncatable",
        "valuetype A { public long x; }; valuetype B : truncatable A { public long y; };",
    ),
    same(
        "truncatable with an abstract base",
        "abstract valuetype A {}; valuetype B : truncatable A { public long y; };",
        "IDL0615",
    ),
    same(
        "abstract bases",
        "abstract valuetype A {}; abstract valuetype B {}; valuetype C : A, B {}; abstract valuetype D : A, B {};",
    ),
    same(
        "concrete base first",
        "valuetype A {}; abstract valuetype B {}; valuetype C : A, B {};",
    ),
    refused(
        "concrete base second",
        "valuetype A {}; abstract valuetype B {}; valuetype C : B, A {};",
        "IDL0609",
    ),
    refused(
        "two concrete bases",
        "valuetype A {}; valuetype B {}; valuetype C : A, B {};",
        "IDL0609",
    ),
    refused(
        "value base twice", "abstract valuetype A {}; valuetype B : A, A {};", "IDL0600"
    ),
    refused(
        "abstract from concrete",
        "valuetype A {}; abstract valuetype B : A {};",
        "IDL0601",
    ),
    same("custom", "custom valuetype V { public long a; };"),
    refused(
        "custom truncatable",
        "valuetype A {}; custom valuetype B : truncatable A {};",
        "IDL0610",
    ),
    refused(
        "not custom from custom",
        "custom valuetype A { public long x; }; valuetype B : A {};",
        "IDL0610",
    ),
    same(
        "custom from custom",
        "custom valuetype A { public long x; }; custom valuetype B : A {};",
    ),
    same(
        "supports",
        "interface I { void f(); }; abstract interface A {}; abstract interface B {}; valuetype V supports I, A, B {}; valuetype W : V supports A {};",
    ),
    refused(
        "two concrete interfaces",
        "interface I {}; interface J {}; valuetype V supports I, J {};",
        "IDL0609",
    ),
    refused(
        "concrete interface second",
        "interface I {}; abstract interface A {}; valuetype V supports A, I {};",
        "IDL0609",
    ),
    refused(
        "supports a struct",
        "struct S { long a; }; valuetype V supports S {};",
        "IDL0301",
    ),
    refused(
        "supports twice",
        "abstract interface A {}; valuetype V supports A, A {};",
        "IDL0600",
    ),
    same(
        "supports a local interface", "local interface L {}; valuetype V supports L {};"
    ),
    same(
        "abstract with operations",
        "abstract valuetype V { void f(); attribute long a; typedef long T; };",
    ),
    refused(
        "abstract with state", "abstract valuetype V { public long a; };", "IDL0611"
    ),
    refused(
        "abstract with a factory",
        "abstract valuetype V { factory make(); };",
        "IDL0611",
    ),
    refused("abstract custom", "abstract custom valuetype V {};", "IDL01"),
    refused(
        "interface as a value base", "interface I {}; valuetype V : I {};", "IDL0301"
    ),
    refused("value base through nothing", "valuetype V : Nothing {};", "IDL0200"),
    refused(
        "value base not complete",
        "valuetype A; valuetype B : A {}; valuetype A {};",
        "IDL0300",
    ),
    refused(
        "state clashes with an inherited one",
        "valuetype A { public long x; }; valuetype B : A { public long x; };",
        "IDL0603",
    ),
    refused(
        "state clashes with an inherited operation",
        "valuetype A { void f(); }; valuetype B : A { public long f; };",
        "IDL0603",
    ),
    refused(
        "state clashes with a supported operation",
        "interface I { void f(); }; valuetype V supports I { public long f; };",
        "IDL0603",
    ),
    refused(
        "state is local",
        "local interface L {}; valuetype V { public L a; };",
        "IDL0308",
    ),
    same(
        "state of any type",
        "valuetype W {}; struct S { long a; }; valuetype V { public W a; public S b; public sequence<long> c; public V d; public any e; };",
    ),
    same(
        "state in place",
        "valuetype V { public struct S { long a; } s_; public enum E { A } e_; };",
    ),
    refused("state without access", "valuetype V { long a; };", "IDL01"),
    refused(
        "constant in place of state",
        "valuetype V { public const long C = 1; };",
        "IDL01",
    ),
    refused("factory with a result", "valuetype V { factory long make(); };", "IDL01"),
    refused(
        "factory with out", "valuetype V { factory make(out long a); };", "IDL0613"
    ),
    refused("factory without in", "valuetype V { factory make(long a); };", "IDL0118"),
    same(
        "value boxes",
        "struct S { long a; }; valuetype A long; valuetype B string; valuetype C sequence<long>; valuetype D S; valuetype E string<4>;",
    ),
    same(
        "value box in place",
        "valuetype A struct S { long a; }; valuetype B enum E { X };",
    ),
    refused("box of a value", "valuetype A {}; valuetype B A;", "IDL0612"),
    refused("box of a box", "valuetype A long; valuetype B A;", "IDL0612"),
    refused("box of nothing known", "valuetype B Nothing;", "IDL0200"),
    refused("box of an exception", "exception E {}; valuetype B E;", "IDL0210"),
    refused("box of void", "valuetype B void;", "IDL0303"),
    refused("box as a base", "valuetype A long; valuetype B : A {};", "IDL0301"),
    same(
        "boxes in use",
        "valuetype A long; struct S { A a_; }; interface I { A f(in A b); };",
    ),
    refused("local valuetype", "local valuetype V {};", "IDL01"),
    same(
        "valuetypes by abstract interfaces",
        "abstract interface A { void f(); }; valuetype V supports A {}; interface I { A g(in A a_); };",
    ),
    same(
        "operations inherited in a diamond of values",
        "abstract valuetype A { void f(); }; abstract valuetype B : A {}; abstract valuetype C : A {}; valuetype D : B, C {};",
    ),
]
