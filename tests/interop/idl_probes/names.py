"""Section 3 of the language: scopes, look-up, introduction, inheritance, forward declarations."""

from idl_probes.probe import better, refused, same

PROBES = [
    refused(
        "an operation where a type is expected, in another case",
        "interface I { void point(); void g(in Point p); };",
        "IDL0201",
    ),
    refused(
        "names that an unknown base may have",
        "interface A : B { void f(in X p); };\ninterface C : A { void g(in X p, in A::Y q); };",
        "IDL0200",
    ),
    # Scopes
    same(
        "one name in many scopes",
        "module M { typedef long x; struct S { long x; }; union U switch (long) { case 1: long x; }; exception E { long x; }; interface I { void f(in long x); void g(in long x); typedef long x; }; valuetype V { public long x; }; };",
    ),
    same(
        "enumerators beside the enum",
        "module M { enum E { A, B }; const E C = B; }; const M::E D = M::A;",
    ),
    refused(
        "enumerator clashes beside the enum",
        "enum E { A }; struct A { long x; };",
        "IDL0202",
    ),
    refused("enumerators of two enums clash", "enum E { A }; enum F { A };", "IDL0202"),
    refused(
        "enumerator clashes in a struct",
        "struct S { enum E { a } e_; long a; };",
        "IDL0202",
    ),
    better(
        "enumerator by its enum",
        "enum E { A }; const E C = E::A;",
        "IDL0213",
        C="const C: E = A",
    ),
    refused(
        "enumerator of another enum",
        "enum E { A }; enum F { B }; const E C = E::B;",
        "IDL0200",
    ),
    same(
        "module reopened",
        "module M { struct A { long x; }; }; module M { struct B { A a_; }; };",
    ),
    refused(
        "module reopened in other case",
        "module M { struct A { long x; }; }; module m { struct B { long x; }; };",
        "IDL0201",
    ),
    refused(
        "module and struct",
        "module M { struct A { long x; }; }; struct M { long x; };",
        "IDL0202",
    ),
    refused(
        "names clash across reopenings",
        "module M { struct A { long x; }; }; module M { struct A { long x; }; };",
        "IDL0202",
    ),
    better("empty module", "module M {}; struct S { long a; };", S="struct S; a: long"),
    better("empty struct", "struct S {};", S="struct S"),
    same("empty exception and interface", "exception E {}; interface I {};"),
    # Look-up
    refused(
        "use before declaration", "struct S { T a; }; struct T { long b; };", "IDL0200"
    ),
    same("outward", "module A { typedef long T; module B { struct S { T a; }; }; };"),
    same(
        "nearest first",
        "typedef long T; module A { typedef short T; struct S { T a; }; };",
    ),
    same(
        "qualified",
        "module A { module B { typedef long T; }; }; struct S { A::B::T x; };",
    ),
    refused(
        "first part decides",
        "module A { typedef long T; }; module B { module A { typedef long U; }; struct S { A::T x; }; };",
        "IDL0200",
    ),
    same(
        "absolute",
        "typedef long T; module A { typedef short T; struct S { ::T a; ::A::T b; }; };",
    ),
    refused(
        "absolute looks nowhere else",
        "module A { typedef long T; struct S { ::T a; }; };",
        "IDL0200",
    ),
    same(
        "inherited name",
        "interface A { typedef long T; }; interface B : A { void f(in T t_); };",
    ),
    same(
        "inherited before outer",
        "typedef short T; interface A { typedef long T; }; interface B : A { void f(in T t_); };",
    ),
    same(
        "inherited by qualification",
        "interface A { typedef long T; }; interface B : A {}; struct S { B::T a; };",
    ),
    same(
        "inheritance of the enclosing interface",
        "interface A { typedef long T; }; interface B : A { struct S { T a; }; };",
    ),
    same(
        "inherited by a valuetype",
        "valuetype A { typedef long T; }; valuetype B : A { public T a; };",
    ),
    same(
        "inherited from what is supported",
        "interface A { typedef long T; }; valuetype B supports A { public T a; };",
    ),
    refused("unknown", "struct S { Nothing a; };", "IDL0200"),
    refused(
        "unknown part", "module A { typedef long T; }; struct S { A::U x; };", "IDL0200"
    ),
    refused("part of no scope", "typedef long T; struct S { T::U a; };", "IDL0209"),
    refused("wrong case", "struct Foo { long a; }; typedef foo Bar;", "IDL0201"),
    refused(
        "wrong case in a part",
        "module Mod { typedef long T; }; struct S { mod::T a; };",
        "IDL0201",
    ),
    refused(
        "module as a type",
        "module M { typedef long T; }; struct S { M a; };",
        "IDL0210",
    ),
    same("constant as a type", "const long C = 1; struct S { C a; };", "IDL0219"),
    same(
        "constants as types",
        'typedef long T; enum E { A, B }; const T X = 1; const E Y = B; const string Z = "a";'
        " struct S { X a; sequence<Y> b; Z c; }; union U switch (Y) { case A: X d; };"
        " interface I { X f(in Y b, out Z c); attribute X d; }; typedef X V; const X W = 4;",
        *["IDL0219"] * 11,
    ),
    refused(
        "member as a type", "struct S { long a; }; struct T { S::a b; };", "IDL0210"
    ),
    refused("type as a value", "typedef long T; const long C = T;", "IDL0211"),
    refused(
        "struct as a bound", "struct S { long a; }; typedef string<S> T;", "IDL0211"
    ),
    # Introduction
    refused(
        "introduced in a struct",
        "struct Foo { long a; }; struct S { Foo foo; };",
        "IDL0204",
    ),
    refused(
        "introduced, same case", "typedef long T; struct S { T a; long T; };", "IDL0204"
    ),
    refused(
        "introduced in an operation",
        "struct Foo { long a; }; interface I { void f(in Foo foo); };",
        "IDL0204",
    ),
    refused(
        "introduced in an attribute",
        "enum E { A }; interface I { attribute E e; };",
        "IDL0204",
    ),
    refused(
        "introduced by a return type",
        "typedef long T; interface I { T f(); typedef short T; };",
        "IDL0204",
    ),
    same(
        "raises introduces nothing",
        "exception E {}; interface I { void f() raises(E); typedef long E; };",
    ),
    same("bases introduce nothing", "interface A {}; interface B : A { void a(); };"),
    refused(
        "introduced by a bound",
        "const long N = 3; struct S { string<N> a; long n; };",
        "IDL0204",
    ),
    refused(
        "introduced by a constant",
        "const long N = 3; interface I { const long M = N; typedef long N; };",
        "IDL0204",
    ),
    refused(
        "introduced by a switch",
        "enum E { A, B }; union U switch (E) { case A: long e; };",
        "IDL0204",
    ),
    refused(
        "introduced by a label",
        "const long N = 3; union U switch (long) { case N: long n; };",
        "IDL0204",
    ),
    refused(
        "first part of a qualified name",
        "module A { typedef long T; }; struct S { A::T a; };",
        "IDL0204",
    ),
    same(
        "last part introduces nothing",
        "module A { typedef long T; }; struct S { A::T t; };",
    ),
    same(
        "absolute introduces nothing",
        "struct Foo { long a; }; struct S { ::Foo foo; };",
    ),
    same(
        "own name is not an introduction",
        "module M { typedef long T; struct S { T a; }; };",
    ),
    refused(
        "use in a struct reaches the interface",
        "typedef long T; interface I { struct S { T a; }; typedef short T; };",
        "IDL0204",
    ),
    refused(
        "use in a parameter reaches the interface",
        "typedef long T; interface I { void f(in T a); typedef short T; };",
        "IDL0204",
    ),
    same(
        "use in a struct does not reach the struct around",
        "typedef long T; struct S { struct R { T a; } r_; long t; };",
    ),
    refused(
        "use in a struct in a struct reaches the interface",
        "typedef long T; interface I { struct S { struct R { T a; } r_; }; typedef short T; };",
        "IDL0204",
    ),
    refused(
        "use in a struct reaches the valuetype",
        "typedef long T; valuetype V { struct R { T a; }; public long t; };",
        "IDL0204",
    ),
    refused(
        "introduced into a module",
        "typedef long T; module M { typedef T U; typedef short T; };",
        "IDL0204",
    ),
    same(
        "use in a struct does not reach the module",
        "typedef long T; module M { struct S { T a; }; typedef short T; };",
    ),
    same(
        "use in an interface does not reach the module",
        "typedef long T; module M { interface I { void f(in T a); }; typedef short T; };",
    ),
    same(
        "the module stops it",
        "typedef long T; module M { module N { struct S { T a; }; }; typedef short T; };",
    ),
    refused(
        "survives reopening",
        "typedef long T; module M { typedef T U; }; module M { typedef short T; };",
        "IDL0204",
    ),
    refused(
        "introduced inherited name",
        "interface A { typedef long T; }; interface B : A { void f(in T a); typedef short T; };",
        "IDL0204",
    ),
    same(
        "redefined before its use",
        "interface A { typedef long T; }; interface B : A { typedef short T; void f(in T a); };",
    ),
    same(
        "introduction in one operation leaves the next",
        "struct Foo { long a; }; interface I { void f(in Foo a); void g(in long b); };",
    ),
    refused(
        "introduction clashes with an operation",
        "struct Foo { long a; }; interface I { void f(in Foo a); void foo(); };",
        "IDL0204",
    ),
    # Enclosing names
    refused("member named like the struct", "struct S { long s; };", "IDL0205"),
    refused(
        "operation named like the interface", "interface I { void I(); };", "IDL0205"
    ),
    refused(
        "struct named like the module", "module M { struct M { long a; }; };", "IDL0205"
    ),
    refused(
        "module named like the module",
        "module M { module m { typedef long T; }; };",
        "IDL0205",
    ),
    refused(
        "branch named like the union",
        "union U switch (long) { case 1: long u; };",
        "IDL0205",
    ),
    refused("member named like the exception", "exception E { long e; };", "IDL0205"),
    refused(
        "attribute named like the interface",
        "interface I { attribute long i; };",
        "IDL0205",
    ),
    refused("state named like the value", "valuetype V { public long v; };", "IDL0205"),
    same(
        "one level further down",
        "module M { interface I { struct M { long a; }; void f(in long I); }; };",
    ),
    same("parameter named like the interface", "interface I { void f(in long i); };"),
    same("parameter named like the operation", "interface I { void f(in long f); };"),
    # Interfaces as scopes
    refused("overloading", "interface I { void f(); void f(in long a); };", "IDL0202"),
    refused(
        "attribute and operation",
        "interface I { attribute long f; void f(); };",
        "IDL0202",
    ),
    refused(
        "type and operation", "interface I { typedef long f; void F(); };", "IDL0203"
    ),
    refused(
        "parameters clash", "interface I { void f(in long a, in long A); };", "IDL0203"
    ),
    refused(
        "inherited operation again",
        "interface A { void f(); }; interface B : A { void f(); };",
        "IDL0603",
    ),
    refused(
        "inherited operation in other case",
        "interface A { void f(); }; interface B : A { void F(); };",
        "IDL0603",
    ),
    refused(
        "inherited attribute again",
        "interface A { attribute long x; }; interface B : A { attribute long x; };",
        "IDL0603",
    ),
    refused(
        "inherited operation as an attribute",
        "interface A { void f(); }; interface B : A { attribute long f; };",
        "IDL0603",
    ),
    refused(
        "inherited from far",
        "interface A { void f(); }; interface B : A {}; interface C : B { void f(); };",
        "IDL0603",
    ),
    refused(
        "inherited operation as a type",
        "interface A { void f(); }; interface B : A { typedef long f; };",
        "IDL0603",
    ),
    refused(
        "two bases with one operation",
        "interface A { void f(); }; interface B { void f(); }; interface C : A, B {};",
        "IDL0604",
    ),
    refused(
        "operation and attribute of two bases",
        "interface A { void f(); }; interface B { attribute long F; }; interface C : A, B {};",
        "IDL0604",
    ),
    same(
        "diamond",
        "interface A { void f(); }; interface B : A {}; interface C : A {}; interface D : B, C {};",
    ),
    same(
        "types may be redefined",
        "interface A { typedef long T; const long C = 1; exception E {}; }; interface B : A { typedef short T; const short C = 2; exception E { long a; }; };",
    ),
    refused(
        "ambiguous type",
        "interface A { typedef long T; }; interface B { typedef long T; }; interface C : A, B { void f(in T a); };",
        "IDL0212",
    ),
    same(
        "ambiguous type not used",
        "interface A { typedef long T; }; interface B { typedef long T; }; interface C : A, B {};",
    ),
    same(
        "ambiguous type qualified",
        "interface A { typedef long T; }; interface B { typedef long T; }; interface C : A, B { void f(in A::T x); };",
    ),
    same(
        "redefined type is not ambiguous",
        "interface A { typedef long T; }; interface B { typedef long T; }; interface C : A, B { typedef short T; void f(in T a); };",
    ),
    # Builtin
    same(
        "TypeCode",
        "struct S { CORBA::TypeCode t; }; interface I { CORBA::TypeCode f(in ::CORBA::TypeCode a); };",
    ),
    better("CORBA::Object", "struct S { CORBA::Object o; };", S="struct S; o: Object"),
    same("Object, ValueBase, any", "struct S { Object o; ValueBase v; any a; };"),
    refused("something else in CORBA", "struct S { CORBA::Something a; };", "IDL0200"),
    same(
        "module CORBA reopened",
        "module CORBA { typedef long Something; }; struct S { CORBA::Something a; CORBA::TypeCode t; };",
    ),
    # Forward declarations
    same("forward interface", "interface I; interface I {}; "),
    same("forward repeated", "interface I; interface I; interface I {}; interface I;"),
    same(
        "forward abstract and local",
        "abstract interface A; local interface L; abstract interface A {}; local interface L {};",
    ),
    same("forward struct", "struct S; struct S { long a; };"),
    same(
        "forward struct repeated", "struct S; struct S; struct S { long a; }; struct S;"
    ),
    same("forward union", "union U; union U switch (long) { case 1: long a; };"),
    same("forward valuetype", "valuetype V; valuetype V { public long a; };"),
    same(
        "forward abstract valuetype", "abstract valuetype V; abstract valuetype V {};"
    ),
    same(
        "forward custom valuetype",
        "valuetype V; custom valuetype V { public long a; };",
    ),
    refused(
        "struct forward, union defined",
        "struct S; union S switch (long) { case 1: long a; };",
        "IDL0214",
    ),
    refused(
        "interface forward, valuetype defined",
        "interface I; valuetype I {};",
        "IDL0214",
    ),
    refused(
        "plain forward, abstract defined",
        "interface I; abstract interface I {};",
        "IDL0214",
    ),
    refused(
        "abstract forward, plain defined",
        "abstract interface I; interface I {};",
        "IDL0214",
    ),
    refused(
        "local forward, plain defined", "local interface I; interface I {};", "IDL0214"
    ),
    refused(
        "plain forward, local defined", "interface I; local interface I {};", "IDL0214"
    ),
    refused(
        "abstract forward, plain value defined",
        "abstract valuetype V; valuetype V {};",
        "IDL0214",
    ),
    refused(
        "forward in other case",
        "interface Foo; interface foo {}; interface Foo {};",
        "IDL0203",
    ),
    same("interface never defined", "interface I; struct S { I i_; };", "IDL0216"),
    same("valuetype never defined", "valuetype V; struct S { V v_; };", "IDL0216"),
    refused("struct never defined", "struct S;", "IDL0215"),
    refused("union never defined", "union U;", "IDL0215"),
    refused(
        "forward struct as a member",
        "struct S; struct T { S s_; }; struct S { long a; };",
        "IDL0300",
    ),
    refused(
        "forward union as a branch",
        "union U; union V switch (long) { case 1: U u_; }; union U switch (long) { case 1: long a; };",
        "IDL0300",
    ),
    same(
        "sequence of a forward struct",
        "struct S; typedef sequence<S> Ss; struct S { Ss s_; };",
    ),
    same(
        "sequence of sequence of a forward struct",
        "struct S; typedef sequence<S> Ss; typedef sequence<Ss> Sss; struct S { Sss s_; };",
    ),
    same(
        "sequence of a forward union",
        "union U; typedef sequence<U, 4> Us; union U switch (long) { case 1: Us u_; };",
    ),
    refused(
        "sequence of a forward struct in another",
        "struct S; typedef sequence<S> Ss; struct T { Ss s_; }; struct S { long a; };",
        "IDL0300",
    ),
    refused(
        "sequence of a forward struct in an operation",
        "struct S; typedef sequence<S> Ss; interface I { void f(in Ss a); }; struct S { long a; };",
        "IDL0300",
    ),
    refused(
        "typedef of a forward struct",
        "struct S; typedef S T; struct S { long a; };",
        "IDL0300",
    ),
    refused(
        "array of a forward struct",
        "struct S; typedef S T[3]; struct S { long a; };",
        "IDL0300",
    ),
    same(
        "sequence of a forward struct after it",
        "struct S; typedef sequence<S> Ss; struct S { long a; }; struct T { Ss s_; S b; };",
    ),
    same(
        "nested in its own body",
        "struct S; typedef sequence<S> Ss; struct S { struct R { Ss s_; } r_; };",
    ),
    same("recursive sequence", "struct S { sequence<S> a; };", "IDL0307"),
    same(
        "recursive sequence in a union",
        "union U switch (long) { case 1: sequence<U> a; };",
        "IDL0307",
    ),
    refused("directly inside itself", "struct S { S a; };", "IDL0300"),
    refused("array of itself", "struct S { S a[2]; };", "IDL0300"),
    refused(
        "union inside itself", "union U switch (long) { case 1: U a; };", "IDL0300"
    ),
    refused(
        "base not complete",
        "interface A; interface B : A {}; interface A {};",
        "IDL0300",
    ),
    refused(
        "base valuetype not complete",
        "valuetype A; valuetype B : A {}; valuetype A {};",
        "IDL0300",
    ),
    same(
        "forward interface as a type",
        "interface I; struct S { I i_; }; interface J { I f(in I a); }; interface I {};",
    ),
    same("an interface in its own operations", "interface I { I f(in I a); };"),
    same(
        "an interface's forward in a module",
        "module M { interface I; }; module M { interface I {}; };",
    ),
    # Case
    same(
        "case does not matter with -nc",
        "struct Foo { long a; long A; }; struct foo { Foo f_; }; struct S { Foo foo; }; interface I { void f(in Foo foo); void F(); };",
        ignore_case=True,
    ),
    refused(
        "look-up with -nc goes by case",
        "struct Foo { long a; }; typedef foo Bar;",
        "IDL0200",
        ignore_case=True,
    ),
    same(
        "module in other case with -nc",
        "module M { typedef long T; }; module m { typedef M::T U; };",
        ignore_case=True,
    ),
    same(
        "enclosing scope in other case with -nc",
        "struct S { long s; }; interface I { void i(); };",
        ignore_case=True,
    ),
    refused(
        "declared twice with -nc",
        "struct S { long a; long a; };",
        "IDL0202",
        ignore_case=True,
    ),
    refused(
        "enclosing scope with -nc", "struct S { long S; };", "IDL0205", ignore_case=True
    ),
    refused(
        "introduced with -nc",
        "typedef long T; struct S { T a; long T; };",
        "IDL0204",
        ignore_case=True,
    ),
    refused(
        "inherited operation again with -nc",
        "interface A { void f(); }; interface B : A { void f(); };",
        "IDL0603",
        ignore_case=True,
    ),
    same(
        "inherited operation in other case with -nc",
        "interface A { void f(); }; interface B : A { void F(); };",
        ignore_case=True,
    ),
    same(
        "two bases in other case with -nc",
        "interface A { void f(); }; interface B { void F(); }; interface C : A, B {};",
        ignore_case=True,
    ),
    same(
        "keyword in other case with -nc", "struct Struct { long a; };", ignore_case=True
    ),
]
