"""Section 6 of the language: IDL 4.2, DDS and ROS 2, which omniidl does not support."""

from idl_probes.probe import Probe, alone

_WORDS = (
    *("component", "consumes", "emits", "eventtype", "finder", "getraises", "home"),
    *("import", "multiple", "primarykey", "provides", "publishes", "setraises"),
    *("typeid", "typeprefix", "uses", "map", "bitset", "bitmask", "bitfield", "alias"),
    *("port", "porttype", "mirrorport", "connector", "typename", "manages", "int8"),
    *("uint16", "int64"),
)

_PLACES = {
    "struct": "struct $ { long a; }; struct T { $ b; };",
    "typedef": "typedef long $; struct T { $ b; sequence<$> c; };",
    "enum": "enum $ { A }; const $ B = A;",
    "enumerator": "enum E { $ }; const E B = $;",
    "constant": "const long $ = 1; const long B = $ + 1;",
    "module": "module $ { typedef long T; }; typedef $::T U;",
    "interface": "interface $ {}; interface I : $ { $ f(in $ a); };",
    "exception": "exception $ {}; interface I { void f() raises($); };",
    "union": "union $ switch (long) { case 1: long a; }; struct T { $ b; };",
    "valuetype": "valuetype $ {}; valuetype V : $ {};",
    "value box": "valuetype $ long; struct T { $ b; };",
    "native": "native $; interface I { void f(in $ a); };",
    "member": "struct S { long $; short b; };",
    "branch": "union U switch (long) { case 1: long $; };",
    "operation": "interface I { void $(); void b(); };",
    "attribute": "interface I { attribute long $, b; };",
    "parameter": "interface I { void f(in long $, out long b); };",
    "state": "valuetype V { public long $; };",
}


def _words() -> list[Probe]:
    """Return every contextual word as the name of every kind of declaration."""
    probes = []
    for place, text in _PLACES.items():
        for word in _WORDS:
            filled = text.replace("$", word)
            old = word in _WORDS[:16] or word == "manages"
            probes.append(
                alone(f"{word} as {place}", filled, *(["IDL0208"] if old else []))
            )
    return probes


PROBES = [
    *_words(),
    # Annotations: forms and places
    alone(
        "annotation forms",
        '@final @nested() struct S { @id(3) long a; @unit(value="m") double b; @range(min=1, max=2) long c; };',
        S="struct S; a: long; b: double; c: long",
    ),
    alone(
        "default literal",
        "enum E { A, @default_literal B };",
        E="enum E; A; B (default)",
    ),
    alone(
        "default literal twice",
        "enum E { @default_literal A, @default_literal B };",
        "IDL0809",
    ),
    alone("annotation twice", "struct S { @key @key long a; };", "IDL0809"),
    alone("two ids", "struct S { @id(1) @id(2) long a; };", "IDL0809"),
    alone(
        "verbatim twice",
        '@verbatim(text="a") @verbatim(language="c", text="b") struct S { long a; };',
        S="struct S; a: long",
    ),
    alone("verbatim of nothing", "@verbatim struct S { long a; };", "IDL0802"),
    alone(
        "verbatim without text",
        '@verbatim(language="comment") struct S { long a; };',
        "IDL0802",
    ),
    alone(
        "position of a member",
        "struct S { @position(1) long a; };",
        "IDL0801",
        S="struct S; a: long",
    ),
    alone("position of an enumerator", "enum E { @position(1) A };", "IDL0801"),
    alone("value of a bit", "bitmask M { @value(1) A };", "IDL0801"),
    alone("position of a bit field", "bitset B { @position(1) bitfield<3> a; };"),
    alone("key of a bit field", "bitset B { @key bitfield<3> a; };", "IDL0801"),
    # Keys of DDS before annotations
    alone(
        "key as a comment",
        "struct S {\n @optional long a; //@key\n @optional long b; //@Key\n @optional long c ;// @key //@ID 3\n @optional long d, e; //@key\n};",
        *["IDL0803"] * 5,
    ),
    alone(
        "comments that are not key",
        "struct S {\n @optional long a; // @key of it\n //@key\n @optional long b; //@keys\n /* @key */ @optional long c; //key\n @optional long d;\n //@key\n};",
    ),
    alone(
        "key as a comment and an annotation",
        "struct S {\n @key long a; //@key\n @optional long b; //@key\n};",
        "IDL0803",
    ),
    alone("scoped annotation", "@ext::thing struct S { long a; };", "IDL0800"),
    alone(
        "blank in an annotation",
        "@ final struct S { @ id (3) long a; };",
        S="struct S; a: long",
    ),
    alone(
        "annotations everywhere",
        '@verbatim(text="x") module M { @verbatim(text="x") interface I { @verbatim(text="x") void f(@verbatim(text="x") in long a); @verbatim(text="x") attribute long b; }; @verbatim(text="x") typedef long T; @verbatim(text="x") const long C = 1; @verbatim(text="x") exception E { @verbatim(text="x") long a; }; @verbatim(text="x") valuetype V {}; };',
    ),
    alone(
        "annotation before a case",
        "union U switch (long) { @id(3) case 1: long a; };",
        U="union U switch (long); 1: long a",
    ),
    alone(
        "annotation before the type of a case",
        "union U switch (long) { case 1: @external long a; };",
        U="union U switch (long); 1: long a",
    ),
    alone(
        "annotation of an enumerator",
        "enum E { @value(3) A, @default_literal B };",
        E="enum E; A; B (default)",
    ),
    alone(
        "annotation behind the direction",
        'interface I { void f(in @verbatim(text="x") long a); };',
        I="interface I; f(in a: long): void",
    ),
    alone(
        "annotation behind the type",
        "struct S { long @key a; string @optional b; };",
        S="struct S; a: long; b: string",
    ),
    alone(
        "annotation of an element",
        "typedef sequence<@external long> T; typedef map<string, @external long> M;",
        T="typedef T = sequence<long>",
    ),
    alone(
        "annotation of a switch",
        "union U switch (@key long) { case 1: long a; };",
        U="union U switch (long); 1: long a",
    ),
    alone(
        "unknown annotation",
        '@nothing(3) struct S { @other(a=1, b="c") long a; };',
        "IDL0800",
        "IDL0800",
    ),
    alone(
        "legacy key",
        "struct S { long a; //@key\n long b; };",
        S="struct S; a: long; b: long",
    ),
    alone(
        "declared annotation",
        '@annotation limit { long low default 1; string text default "a"; }; @limit(low=3) struct S { long a; };',
        "IDL0302",
        S="struct S; a: long",
    ),
    alone(
        "declared annotation with a wrong argument",
        "@annotation limit { long low; }; @limit(high=3) struct S { long a; };",
        "IDL0302",
        "IDL0802",
    ),
    alone(
        "declared annotation with declarations",
        "@annotation limit { enum Mode { ON, OFF }; const long N = 3; Mode mode default ON; any value; }; @limit(mode=OFF, value=3) struct S { long a; };",
        "IDL0302",
    ),
    alone(
        "declared annotation, words as members",
        '@annotation limit { long map; long component; string port default "a"; }; @limit(map=1) struct S { long a; };',
        "IDL0302",
    ),
    alone(
        "argument given twice", "struct S { @range(min=1, min=2) long a; };", "IDL0802"
    ),
    # The standard annotations
    alone("id", "struct S { @id(1) long a; @id(0x10) long b; };"),
    alone("id twice", "struct S { @id(1) long a; @id(1) long b; };", "IDL0804"),
    alone(
        "id of a base",
        "struct A { @id(1) long x; }; struct B : A { @id(1) long y; };",
        "IDL0804",
    ),
    alone("id without a number", "struct S { @id long a; };", "IDL0802"),
    alone("id that is text", 'struct S { @id("a") long a; };', "IDL0500"),
    alone("negative id", "struct S { @id(-1) long a; };", "IDL0802"),
    alone(
        "autoid",
        "@autoid(HASH) struct S { long a; }; @autoid(SEQUENTIAL) struct T { long b; }; @autoid struct U { long c; };",
    ),
    alone(
        "autoid of something else", "@autoid(RANDOM) struct S { long a; };", "IDL0802"
    ),
    alone("hashid", 'struct S { @hashid long a; @hashid("x") long b; };'),
    alone("optional", "struct S { @optional long a; @optional(FALSE) long b; };"),
    alone("optional key", "struct S { @key @optional long a; };", "IDL0803"),
    alone("key that is not optional", "struct S { @key @optional(FALSE) long a; };"),
    alone("key of a base", "struct A { @key long x; }; struct B : A { long y; };"),
    alone(
        "position",
        "@bit_bound(8) bitmask M { @position(0) A, @position(7) B };",
        M="bitmask M; A (0); B (7)",
    ),
    alone(
        "position goes on",
        "bitmask M { @position(3) A, B, @position(1) C, D };",
        M="bitmask M; A (3); B (4); C (1); D (2)",
    ),
    alone(
        "position beyond the bound",
        "@bit_bound(8) bitmask M { @position(8) A };",
        "IDL0805",
    ),
    alone("position twice", "bitmask M { @position(3) A, @position(3) B };", "IDL0805"),
    alone("position beyond 32", "bitmask M { @position(32) A };", "IDL0805"),
    alone("value", "enum E { @value(3) A, B, @value(10) C };", E="enum E; A; B; C"),
    alone(
        "negative values",
        "enum E { @value(-3) A, B, @value(10) C };",
        E="enum E; A; B; C",
    ),
    alone(
        "negative value beyond the bound",
        "@bit_bound(8) enum E { @value(-129) A };",
        "IDL0806",
    ),
    alone(
        "large value beside a negative one",
        "@bit_bound(8) enum E { @value(-1) A, @value(200) B };",
        "IDL0806",
    ),
    alone(
        "external of an incomplete type",
        "struct N; struct A { @external N n_; }; struct N { long a; };",
        A="struct A; n_: N",
        N="struct N; a: long",
    ),
    alone(
        "external, in full, of an incomplete type",
        "struct N; struct A { @external(TRUE) N n_; @external(value=TRUE) N m; };"
        " struct N { long a; };",
        A="struct A; n_: N; m: N",
    ),
    alone(
        "not external of an incomplete type",
        "struct N; struct A { @external(FALSE) N n_; }; struct N { long a; };",
        "IDL0300",
    ),
    alone("value twice", "enum E { @value(1) A, @value(1) B };", "IDL0806"),
    alone(
        "value beyond the bound",
        "@bit_bound(8) enum E { @value(300) A };",
        "IDL0806",
    ),
    alone(
        "value that follows is taken",
        "enum E { @value(2) A, @value(1) B, C };",
        "IDL0806",
    ),
    alone(
        "extensibility",
        "@extensibility(FINAL) struct A { long x; }; @extensibility(APPENDABLE) struct B { long x; }; @extensibility(MUTABLE) struct C { long x; }; @final struct D { long x; }; @appendable union U switch (long) { case 1: long x; }; @mutable struct E { long x; };",
    ),
    alone(
        "extensibility of something else",
        "@extensibility(NONE) struct A { long x; };",
        "IDL0802",
    ),
    alone(
        "conflicting extensibility", "@final @mutable struct S { long a; };", "IDL0807"
    ),
    alone(
        "conflicting extensibility of a union",
        "@final @extensibility(MUTABLE) union U switch (long) { case 1: long a; };",
        "IDL0807",
    ),
    alone(
        "same extensibility twice", "@final @extensibility(FINAL) struct S { long a; };"
    ),
    alone(
        "must_understand, external, nested",
        "@nested struct S { @must_understand long a; @external long b; @must_understand(FALSE) long c; };",
    ),
    alone("default_literal", "enum E { A, @default_literal B };"),
    alone(
        "default",
        "struct S { @default(3) long a; @default(\"x\") string b; @default(TRUE) boolean c; @default(1.5) double d; @default('c') char e; };",
    ),
    alone("default with a key", "struct S { @default(value=3) long a; };"),
    alone(
        "default of an enum",
        "enum E { A, B }; struct S { @default(B) E e_; @default(E::B) E f; };",
        "IDL0213",
    ),
    alone(
        "default that does not fit", "struct S { @default(300) octet a; };", "IDL0501"
    ),
    alone("default of another kind", 'struct S { @default("x") long a; };', "IDL0500"),
    alone(
        "default of another enum",
        "enum E { A }; enum F { B }; struct S { @default(B) E e_; };",
        "IDL0506",
    ),
    alone(
        "default out of range",
        "struct S { @default(5) @range(min=1, max=3) long a; };",
        "IDL0808",
    ),
    alone("default out of min", "struct S { @default(0) @min(1) long a; };", "IDL0808"),
    alone(
        "default longer than the bound",
        'struct S { @default("abc") string<2> a; };',
        "IDL0505",
    ),
    alone(
        "range",
        "struct S { @range(min=1, max=3) long a; @min(0.5) @max(1.5) double b; @range(min=-1) short c; };",
    ),
    alone("range upside down", "struct S { @range(min=3, max=1) long a; };", "IDL0808"),
    alone(
        "range of another type",
        'struct S { @range(min="a", max="b") long a; };',
        "IDL0500",
        "IDL0500",
    ),
    alone(
        "range beyond the type",
        "struct S { @range(min=0, max=300) octet a; };",
        "IDL0501",
    ),
    alone("unit", 'struct S { @unit("m/s") double a; };'),
    alone("unit that is a number", "struct S { @unit(3) double a; };", "IDL0500"),
    alone(
        "bit_bound",
        "@bit_bound(1) enum A { X }; @bit_bound(32) enum B { Y }; @bit_bound(64) bitmask C { Z };",
    ),
    alone("bit_bound 0", "@bit_bound(0) enum A { X };", "IDL0805"),
    alone("bit_bound 33 of an enum", "@bit_bound(33) enum A { X };", "IDL0805"),
    alone("bit_bound 65 of a bitmask", "@bit_bound(65) bitmask A { X };", "IDL0805"),
    alone("bit_bound of a struct", "@bit_bound(8) struct S { long a; };", "IDL0801"),
    alone(
        "verbatim",
        '@verbatim(language="c++", placement=BEFORE_DECLARATION, text="int " "x;") struct S { long a; };',
    ),
    alone(
        "verbatim, comment, as ROS 2 has it",
        'module pkg { module msg { @verbatim (language="comment", text="A point." "\\n" "In metres.") struct Point { @verbatim (language="comment", text="x") @unit (value="m") double x; }; }; };',
    ),
    alone(
        "service, oneway, ami",
        '@service interface I { @oneway void f(); @ami void g(); }; @service(platform="DDS") interface J {}; @ami interface K {};',
    ),
    alone(
        "topic",
        '@topic struct S { @key long a; }; @topic(name="x", platform="DDS") struct T { long b; };',
    ),
    alone("data_representation", "@data_representation(XCDR2) struct S { long a; };"),
    alone(
        "try_construct",
        "struct S { @try_construct long a; @try_construct(TRIM) string<3> b; @try_construct(USE_DEFAULT) long c; @try_construct(DISCARD) long d; };",
    ),
    alone(
        "ignore_literal_names, non_serialized, default_nested",
        "@ignore_literal_names enum E { A }; @default_nested module M { struct S { @non_serialized long a; }; };",
    ),
    alone(
        "transfer_mode",
        "struct S { @transfer_mode(SHMEM_REF) octet a[4]; }; @transfer_mode(SHMEM_REF) struct T { long b; };",
    ),
    alone("misplaced key", "@key struct S { long a; };", "IDL0801"),
    alone("key on a module", "@key module M { struct S { long a; }; };", "IDL0801"),
    alone(
        "defaults of a module",
        "@mutable @autoid(HASH) module M { struct S { long a; }; }; module M { struct T { long a; }; };",
    ),
    alone("misplaced final", "struct S { @final long a; };", "IDL0801"),
    alone("misplaced optional", "interface I { @optional void f(); };", "IDL0801"),
    # Types
    alone(
        "integers",
        "struct S { int8 a; uint8 b; int16 c; uint16 d; int32 e; uint32 f; int64 g; uint64 h; };",
        S="struct S; a: int8; b: uint8; c: short; d: unsigned short; e: long; f: unsigned long; g: long long; h: unsigned long long",
    ),
    alone(
        "constants of the integers",
        "const int8 A = -128; const uint8 B = 255; const int16 C = -1; const uint64 D = 18446744073709551615;",
        A="const A: int8 = -128",
        D="const D: unsigned long long = 18446744073709551615",
    ),
    alone("constant beyond int8", "const int8 A = 128;", "IDL0501"),
    alone("constant beyond uint8", "const uint8 A = -1;", "IDL0501"),
    alone(
        "complement of uint8",
        "const uint8 A = ~5; const int8 B = ~5;",
        A="const A: uint8 = 250",
        B="const B: int8 = -6",
    ),
    alone(
        "declared integers win",
        "typedef short int32; struct S { int32 a; };",
        S="struct S; a: int32",
    ),
    alone(
        "integers inside a module of their own",
        "module M { typedef short int32; struct S { int32 a; }; }; struct T { int32 b; };",
        gives={"M::S": "struct M::S; a: M::int32", "T": "struct T; b: long"},
    ),
    alone(
        "map",
        "typedef map<string, long> A; typedef map<long, sequence<double>, 8> B; struct S { map<uint8, string<4>> c; };",
        A="typedef A = map<string,long>",
        B="typedef B = map<long,sequence<double>,8>",
        S="struct S; c: map<uint8,string<4>>",
    ),
    alone(
        "map of enums", "enum E { A }; typedef map<E, E> M;", M="typedef M = map<E,E>"
    ),
    alone("map without a value", "typedef map<string> A;", "IDL01"),
    alone("map with a floating key", "typedef map<double, long> A;", "IDL0311"),
    alone(
        "map with a struct as the key",
        "struct S { long a; }; typedef map<S, long> A;",
        "IDL0311",
    ),
    alone("map with a bound of 0", "typedef map<string, long, 0> A;", "IDL0304"),
    alone("map of void", "typedef map<string, void> A;", "IDL0303"),
    alone(
        "bitset",
        "bitset B { bitfield<3> a; bitfield<4, short> e; bitfield<2>; bitfield<1> c, d; };",
        B="bitset B; a: 3 bits; e: 4 bits; (padding): 2 bits; c: 1 bits; d: 1 bits",
    ),
    alone(
        "bitset base",
        "bitset A { bitfield<3> x; }; bitset B : A { bitfield<4> y; };",
        B="bitset B: A; y: 4 bits",
    ),
    alone("bitset of 64", "bitset B { bitfield<32> a; bitfield<32> c; };"),
    alone("bitset of 65", "bitset B { bitfield<32> a; bitfield<33> c; };", "IDL0312"),
    alone(
        "bitset of 65 with its base",
        "bitset A { bitfield<60> x; }; bitset B : A { bitfield<5> y; };",
        "IDL0312",
    ),
    alone("bit field of 0", "bitset B { bitfield<0> a; };", "IDL0304"),
    alone(
        "bit field beyond its type", "bitset B { bitfield<9, octet> a; };", "IDL0312"
    ),
    alone("bit field of a string", "bitset B { bitfield<9, string> a; };", "IDL0312"),
    alone("bit field of a boolean", "bitset B { bitfield<1, boolean> a; };"),
    alone("bit fields clash", "bitset B { bitfield<1> a; bitfield<1> a; };", "IDL0202"),
    alone(
        "bitset with a struct as its base",
        "struct S { long a; }; bitset B : S { bitfield<1> b_; };",
        "IDL0301",
    ),
    alone(
        "bitmask",
        "bitmask M { A, B, C }; struct S { M m_; };",
        M="bitmask M; A (0); B (1); C (2)",
    ),
    alone("flags of two bitmasks", "bitmask M { A }; bitmask N { A };"),
    alone("flags clash", "bitmask M { A, A };", "IDL0202"),
    alone(
        "33 flags",
        "bitmask M { " + ", ".join(f"F{i}" for i in range(33)) + " };",
        "IDL0805",
    ),
    alone(
        "inheritance",
        "struct A { long x; }; struct B : A { long y; }; struct C : B {};",
        B="struct B: A; y: long",
        C="struct C: B",
    ),
    alone(
        "inherited member again",
        "struct A { long x; }; struct B : A { long x; };",
        "IDL0603",
    ),
    alone(
        "inherits from an interface",
        "interface I {}; struct S : I { long a; };",
        "IDL0301",
    ),
    alone(
        "inherits from something unknown", "struct S : Nothing { long a; };", "IDL0200"
    ),
    alone(
        "inherits from what is not complete",
        "struct A; struct B : A { long x; }; struct A { long y; };",
        "IDL0300",
    ),
    alone(
        "inherits from two",
        "struct A { long x; }; struct B { long y; }; struct C : A, B {};",
        "IDL01",
    ),
    alone("empty struct", "struct S {}; struct T { S s_; };", S="struct S"),
    alone(
        "256 octets and a default",
        "union U switch (uint8) { "
        + " ".join(f"case {i}:" for i in range(256))
        + " long a; default: long b; };",
        "IDL0403",
    ),
    alone(
        "label beyond int8", "union U switch (int8) { case 128: long a; };", "IDL0501"
    ),
    alone(
        "constants of ROS 2",
        "module pkg { module msg { module Mode_Constants { const octet ON = 1; }; struct Mode { octet value; }; }; };",
        gives={
            "pkg::msg::Mode_Constants::ON": "const pkg::msg::Mode_Constants::ON: octet = 1"
        },
    ),
    alone(
        "anonymous sequences of ROS 2",
        "module pkg { module msg { typedef double double__9[9]; struct M { double__9 k; sequence<sequence<octet>> d; wstring<4> n; }; }; };",
    ),
]
