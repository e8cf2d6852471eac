"""CORBA 3 and components: typeid, typeprefix, import, accessors' exceptions, components."""

from idl_probes.probe import alone

_I = "interface I {}; "
_S = "struct S { long a; }; "
_T = "module T<typename X> { typedef sequence<X> Xs; }; module T<long> LongT; "

PROBES = [
    alone(
        "getraises and setraises",
        "exception E {}; exception F {}; interface I { attribute long a getraises(E) setraises(E, F); attribute long b setraises(F); attribute long c getraises(E); };",
    ),
    alone(
        "raises of a readonly attribute",
        "exception E {}; interface I { readonly attribute long a raises(E); readonly attribute long b, c; };",
    ),
    alone(
        "raises of an attribute that can be set",
        "exception E {}; interface I { attribute long a raises(E); };",
        "IDL0614",
    ),
    alone(
        "setraises of a readonly attribute",
        "exception E {}; interface I { readonly attribute long a setraises(E); };",
        "IDL0614",
    ),
    alone(
        "getraises of a readonly attribute",
        "exception E {}; interface I { readonly attribute long a getraises(E); };",
    ),
    alone(
        "getraises of a struct",
        _S + "interface I { attribute long a getraises(S); };",
        "IDL0605",
    ),
    # typeid
    alone("typeid", _I + 'typeid I "IDL:x/I:2.0";', gives={"I id": "IDL:x/I:2.0"}),
    alone(
        "typeid of a scoped name",
        "module M { " + _I + '}; typeid M::I "IDL:x:1.0"; typeid ::M::I "IDL:x:1.0";',
        gives={"M::I id": "IDL:x:1.0"},
    ),
    alone(
        "typeid in an interface",
        'interface J { struct S { long a; }; typeid S "IDL:s:1.0"; };',
        gives={"J::S id": "IDL:s:1.0"},
    ),
    alone("typeid of nothing", 'typeid Nothing "IDL:x:1.0";', "IDL0200"),
    alone(
        "typeid twice", _I + 'typeid I "IDL:x:1.0"; typeid I "IDL:y:1.0";', "IDL0703"
    ),
    alone("typeid of a member", _S + 'typeid S::a "IDL:x:1.0";', "IDL0701"),
    alone("typeid without a text", _I + "typeid I;", "IDL01"),
    # typeprefix
    alone(
        "typeprefix",
        'module M { typeprefix M "p"; ' + _S + "};",
        gives={"M::S id": "IDL:p/M/S:1.0"},
    ),
    alone(
        "typeprefix of a module from outside",
        "module M { " + _I + '}; typeprefix M "p"; module M { ' + _S + "};",
        gives={"M::I id": "IDL:M/I:1.0", "M::S id": "IDL:p/M/S:1.0"},
    ),
    alone(
        "typeprefix reaches inner modules",
        'module M { typeprefix M "p"; module N { ' + _S + "}; };",
        gives={"M::N::S id": "IDL:p/M/N/S:1.0"},
    ),
    alone(
        "typeprefix kept across reopenings",
        'module M { typeprefix M "p"; ' + _S + "}; module M { " + _I + "};",
        gives={"M::I id": "IDL:p/M/I:1.0", "M::S id": "IDL:p/M/S:1.0"},
    ),
    alone(
        "typeprefix of an interface",
        'interface J { typeprefix J "p"; struct S { long a; }; };',
        gives={"J::S id": "IDL:p/J/S:1.0"},
    ),
    alone("typeprefix of nothing", 'typeprefix Nothing "p";', "IDL0200"),
    alone("typeprefix of a constant", 'const long C = 1; typeprefix C "p";', "IDL0209"),
    # import
    alone(
        "import",
        "module M { " + _S + "}; module N { import M; struct T { S s_; }; };",
        gives={"N::T": "struct N::T; s_: M::S"},
    ),
    alone(
        "import of a scoped name",
        "module M { module K { " + _S + "}; }; import ::M::K; struct T { S s_; };",
        T="struct T; s_: M::K::S",
    ),
    alone("import of a file", 'import "something"; ' + _S, "IDL0012"),
    alone("import of nothing", "import Nothing;", "IDL0200"),
    # Components
    alone(
        "component",
        _S
        + _I
        + "component C { provides I p; uses I q; publishes S r; consumes S s; attribute long t; };",
        C="component C; provider p: I; consumer q: I; outport r: S; inport s: S; parameter t: long",
    ),
    alone("empty component", "component C {};", C="component C"),
    alone(
        "component base",
        _S + "component A { publishes S x; }; component B : A { consumes S y; };",
        B="component B; outport x: S; inport y: S",
    ),
    alone("component supports", _I + "component C supports I {};"),
    alone("forward component", "component C; component C {};"),
    alone("emits", _S + "component C { emits S a; };", C="component C; outport a: S"),
    alone(
        "eventtypes on ports",
        "eventtype E { public long a; }; component C { publishes E x; consumes E y; };",
        C="component C; outport x: E; inport y: E",
    ),
    alone(
        "provides Object",
        "component C { provides Object a; };",
        C="component C; provider a: Object",
    ),
    alone("publishes an interface", _I + "component C { publishes I a; };", "IDL0900"),
    alone("provides a struct", _S + "component C { provides S a; };", "IDL0900"),
    alone("port of nothing known", "component C { provides Nothing a; };", "IDL0200"),
    alone(
        "port twice", _S + "component C { publishes S x; publishes S x; };", "IDL0901"
    ),
    alone(
        "component inherits from an interface", _I + "component C : I {};", "IDL0301"
    ),
    alone(
        "uses multiple",
        _I + "component C { uses multiple I a; };",
        "IDL0905",
        C="component C; consumer a: I",
    ),
    alone(
        "multiple as a type",
        "interface multiple {}; component C { uses multiple a; };",
        "IDL0208",
        C="component C; consumer a: multiple",
    ),
    alone("operation in a component", "component C { void f(); };", "IDL01"),
    # Homes, eventtypes
    alone(
        "home",
        "component C {}; home H manages C { factory make(in long a); finder find(in long b); void f(); attribute long g; };",
        "IDL0905",
        H="home H",
    ),
    alone(
        "home with a base",
        "component C {}; home G manages C {}; home H : G manages C {};",
        "IDL0905",
        "IDL0905",
    ),
    alone(
        "home with a key",
        "valuetype K { public long a; }; component C {}; home H manages C primarykey K {};",
        "IDL0905",
    ),
    alone(
        "home supports",
        _I + "component C {}; home H supports I manages C {};",
        "IDL0905",
    ),
    alone(
        "home manages an interface", _I + "home H manages I {};", "IDL0905", "IDL0301"
    ),
    alone("home of nothing", "home H manages Nothing {};", "IDL0905", "IDL0200"),
    alone(
        "eventtype",
        "eventtype E { public long a; private string b; factory make(in long x); };",
        E="eventtype E; a: long; b: string; make(in x: long): void",
    ),
    alone(
        "abstract and custom eventtypes",
        "abstract eventtype A {}; custom eventtype B { public long a; }; eventtype C : truncatable D {}; ",
        "IDL0200",
    ),
    alone(
        "eventtype base",
        "eventtype A { public long x; }; eventtype B : A { public long y; };",
        B="eventtype B: A; y: long",
    ),
    alone("forward eventtype", "eventtype E; eventtype E {};", E="eventtype E"),
    # Parsed, but not supported
    alone("porttype", _I + "porttype P { provides I a; uses I b; };", "IDL0302"),
    alone(
        "extended port",
        _I + "porttype P { provides I a; }; component C { port P x; mirrorport P y; };",
        "IDL0302",
        "IDL0905",
        "IDL0905",
        C="component C",
    ),
    alone(
        "connector",
        _I + "connector K { provides I a; attribute long b; }; connector L : K {};",
        "IDL0302",
        "IDL0302",
    ),
    alone(
        "template module",
        "module T<typename X, const long N, sequence Q> { typedef sequence<X, N> Xs; };",
        "IDL0302",
    ),
    alone(
        "template module in use",
        "module T<typename X> { typedef sequence<X> Xs; }; module T<long> LongT;",
        "IDL0302",
        "IDL0302",
    ),
    alone(
        "type of a template module in a struct",
        _T + "struct S { LongT::Xs a; }; struct R { S b; }; struct Q { long a; };",
        *("IDL0302", "IDL0302", "IDL0309", "IDL0309"),
        Q="struct Q; a: long",
    ),
    alone(
        "type of a template module in a typedef",
        _T + "typedef LongT::Xs L; typedef sequence<L> Ls;",
        *("IDL0302", "IDL0302", "IDL0309", "IDL0309"),
    ),
    alone(
        "type of a template module in an interface",
        _T
        + "interface I { void f(in LongT::Xs a); void g(); attribute LongT::Xs h; };",
        *("IDL0302", "IDL0302", "IDL0309", "IDL0309"),
        I="interface I; g(): void",
    ),
    alone(
        "base, exception and constant of a template module",
        _T
        + "interface I : LongT::J {}; interface K { void f() raises(LongT::E); }; const long A = LongT::N;",
        *("IDL0302", "IDL0302", "IDL0309", "IDL0309", "IDL0309"),
        K="interface K; f(): void",
    ),
    alone(
        "type of a template module at a port",
        _T + "component C { provides LongT::J j; consumes LongT::S s; };",
        *("IDL0302", "IDL0302", "IDL0309", "IDL0309"),
    ),
    alone(
        "port type as a type",
        "porttype P { provides Object o; }; struct S { P a; };",
        *("IDL0302", "IDL0309"),
    ),
    alone(
        "left out beside an error",
        _T + "struct S { LongT::Xs a; Nothing b; };",
        *("IDL0302", "IDL0302", "IDL0200"),
    ),
    alone(
        "qualified template module in use",
        "module M { module T<typename X> { typedef X Y; }; }; module M::T<string> U;",
        "IDL0302",
        "IDL0302",
    ),
    alone(
        "module alias",
        "module M { " + _S + "}; alias M N; struct T { N::S s_; };",
        "IDL0302",
        T="struct T; s_: M::S",
    ),
    # Configuration
    alone(
        "float parameter keeps its digits",
        "component C { @default(0.1) @min(0.1) @max(0.3) attribute float a; };",
        C="component C; parameter a: float = 0.1",
    ),
    alone(
        "double parameter",
        "component C { @default(0.1) @min(0.1) attribute double a; };",
        C="component C; parameter a: double = 0.1",
    ),
    alone(
        "float parameter out of range",
        "component C { @default(0.1) @min(0.2) attribute float a; };",
        "IDL0808",
    ),
    alone(
        "list parameter",
        'component C { @default("1,2") attribute string a; };',
        C='component C; parameter a: string = "1,2"',
    ),
]
