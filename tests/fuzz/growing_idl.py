"""IDL files that are short with large effects, deep, or many."""

from __future__ import annotations

from growth import Files, Kinds, chain, lines

IDL = (
    ("inspect", "a.idl"),
    ("lint", "a.idl"),
    ("generate", "-q", "--no-cache", "-o", "o", "a.idl"),
)
OPENRTM = (
    ("generate", "-q", "--no-cache", "-o", "o", "--target", "openrtm", "a.idl"),
    ("generate", "-q", "--no-cache", "-o", "s", "--target", "small", "a.idl"),
)
COMPONENT = (*IDL, *OPENRTM, ("convert", "--to", "rtc-xml", "a.idl"))

KINDS = Kinds(IDL)


def _idl(text: str) -> Files:
    return {"a.idl": text}


def _with_port(text: str, type_: str) -> Files:
    return _idl(f"{text}\ncomponent Node {{ publishes {type_} port; }};\n")


def _providing(text: str, type_: str) -> Files:
    return _idl(f"{text}\ncomponent Node {{ provides {type_} port; }};")


@KINDS.add(16, 24, 60, commands=COMPONENT)
def structs_that_double(size: int) -> Files:
    return _with_port(
        chain(size, "struct S0 { long x; };", "struct S{0} {{ S{1} a; S{1} b; }};"),
        f"S{size}",
    )


@KINDS.add(16, 60, commands=COMPONENT)
def unions_that_double(size: int) -> Files:
    line = "union U{0} switch (long) {{ case 1: U{1} a; case 2: U{1} b; }};"
    return _with_port(chain(size, "struct U0 { long x; };", line), f"U{size}")


@KINDS.add(16, 60, commands=COMPONENT)
def sequences_that_double(size: int) -> Files:
    line = "struct S{0} {{ sequence<S{1}> a; sequence<S{1}> b; S{1} c[2]; }};"
    return _with_port(chain(size, "struct S0 { long x; };", line), f"S{size}")


@KINDS.add(10, 100, commands=COMPONENT)
def arrays_that_multiply(size: int) -> Files:
    return _with_port(
        chain(size, "typedef long T0[10];", "typedef T{1} T{0}[10];")
        + f"\nstruct S {{ T{size} x; }};",
        "S",
    )


@KINDS.add(1, commands=COMPONENT)
def one_large_array(size: int) -> Files:
    return _with_port("struct S { octet x[2000000000]; double y[30000][30000]; };", "S")


@KINDS.add(20, 60)
def diamonds_of_interfaces(size: int) -> Files:
    first = "interface A0 { void f0(); }; interface B0 { void g0(); };"
    line = "interface A{0} : A{1}, B{1} {{ void f{0}(); }};"
    line += "interface B{0} : A{1}, B{1} {{ void g{0}(); }};"
    return _providing(chain(size, first, line), f"A{size}")


@KINDS.add(20, 60)
def diamonds_of_value_types(size: int) -> Files:
    first = (
        "abstract valuetype A0 { void f0(); }; abstract valuetype B0 { void g0(); };"
    )
    line = "abstract valuetype A{0} : A{1}, B{1} {{ void f{0}(); }};"
    line += "abstract valuetype B{0} : A{1}, B{1} {{ void g{0}(); }};"
    return _idl(chain(size, first, line))


@KINDS.add(100, 1000, 5000, commands=COMPONENT)
def chain_of_structs(size: int) -> Files:
    return _with_port(
        chain(size, "struct S0 { long x; };", "struct S{0} {{ S{1} a; }};"), f"S{size}"
    )


@KINDS.add(1000, 5000, commands=COMPONENT)
def chain_of_typedefs(size: int) -> Files:
    return _with_port(
        chain(size, "struct S { long x; }; typedef S T0;", "typedef T{1} T{0};")
        + f"\nstruct U {{ T{size} x; }};",
        "U",
    )


@KINDS.add(1000, 5000, commands=COMPONENT)
def chain_of_sequences(size: int) -> Files:
    return _with_port(
        chain(size, "typedef sequence<long> T0;", "typedef sequence<T{1}> T{0};")
        + f"\nstruct U {{ T{size} x; }};",
        "U",
    )


@KINDS.add(100, 1000, 5000, commands=COMPONENT)
def chain_of_bases(size: int) -> Files:
    return _with_port(
        chain(size, "struct S0 { long x; };", "struct S{0} : S{1} {{ long y{0}; }};"),
        f"S{size}",
    )


@KINDS.add(100, 1000, 3000)
def chain_of_interfaces(size: int) -> Files:
    line = "interface I{0} : I{1} {{ void f{0}(); }};"
    return _providing(chain(size, "interface I0 { void f0(); };", line), f"I{size}")


@KINDS.add(100, 1000, 3000)
def chain_of_components(size: int) -> Files:
    line = "component C{0} : C{1} {{ attribute long p{0}; }};"
    return _idl(chain(size, "component C0 { attribute long p0; };", line))


@KINDS.add(100, 1000, 3000)
def chain_of_value_types(size: int) -> Files:
    line = "valuetype V{0} : V{1} {{ public long p{0}; }};"
    return _idl(chain(size, "valuetype V0 { public long p0; };", line))


@KINDS.add(1000, 5000)
def chain_of_constants(size: int) -> Files:
    line = "const long long C{0} = C{1} + 1;"
    return _idl(chain(size, "const long long C0 = 0;", line))


@KINDS.add(100)
def constants_that_double(size: int) -> Files:
    line = "const string C{0} = C{1} C{1};"
    return _idl(chain(size, 'const string C0 = "ab";', line))


@KINDS.add(20000)
def many_members(size: int) -> Files:
    return _idl(f"struct S {{\n{lines(size, lambda i: f'long m{i};')}\n}};")


@KINDS.add(20000)
def many_enumerators(size: int) -> Files:
    names = ",\n".join(f"E{i}" for i in range(size))
    return _idl(f"enum E {{ {names} }};")


@KINDS.add(5000)
def many_structs(size: int) -> Files:
    return _idl(lines(size, lambda i: f"struct S{i} {{ long x; }};"))


@KINDS.add(400, commands=COMPONENT)
def many_components(size: int) -> Files:
    line = (
        "component C{0} {{ publishes D o; consumes D i; provides I s; uses I c;"
        " attribute double p; }};"
    )
    return _idl(
        "struct D { long x; }; interface I { void f(in D d); };\n"
        + lines(size, lambda i: line.format(i))
    )


@KINDS.add(2000, commands=COMPONENT)
def many_ports(size: int) -> Files:
    ports = lines(size, lambda i: f"publishes D o{i}; attribute long p{i};")
    return _idl(f"struct D {{ long x; }}; component C {{ {ports} }};")


@KINDS.add(3000)
def many_operations(size: int) -> Files:
    return _idl(f"interface I {{ {lines(size, lambda i: f'long f{i}(in long a);')} }};")


@KINDS.add(3000)
def many_bases(size: int) -> Files:
    bases = ", ".join(f"I{i}" for i in range(size))
    return _idl(
        lines(size, lambda i: f"interface I{i} {{ void f{i}(); }};")
        + f"\ninterface J : {bases} {{}};"
    )


@KINDS.add(3000)
def many_exceptions(size: int) -> Files:
    names = ", ".join(f"E{i}" for i in range(size))
    return _idl(
        lines(size, lambda i: f"exception E{i} {{ long x; }};")
        + f"\ninterface J {{ void f() raises ({names}); }};"
    )


@KINDS.add(100000)
def many_quotes(size: int) -> Files:
    return _idl("'\"" * size)


@KINDS.add(100000)
def many_single_quotes(size: int) -> Files:
    return _idl("'" * size + "\n" + '"' * size)


@KINDS.add(20000)
def many_lines_of_quotes(size: int) -> Files:
    return _idl("'\n\"\n" * size)


@KINDS.add(100000)
def many_open_comments(size: int) -> Files:
    return _idl("/*" * size + "\n" + "/**/" * size)


@KINDS.add(100000)
def many_brackets(size: int) -> Files:
    return _idl("module M {" * size)


@KINDS.add(50000)
def many_syntax_errors(size: int) -> Files:
    return _idl("struct S { long; };\n" * size)


@KINDS.add(20000)
def many_equal_names(size: int) -> Files:
    return _idl("struct S { long x; };\n" * size)


@KINDS.add(20000)
def many_unknown_names(size: int) -> Files:
    return _idl(lines(size, lambda i: f"struct S{i} {{ Nothing{i} x; }};"))


@KINDS.add(5000)
def many_modules(size: int) -> Files:
    return _idl(lines(size, lambda i: f"module M{i} {{ struct S {{ long x; }}; }};"))


@KINDS.add(20000)
def long_documentation(size: int) -> Files:
    text = " * word word word\n" * size
    return _idl(f"/** \n{text}*/\nstruct S {{ long x; }};")


@KINDS.add(5_000_000, commands=COMPONENT)
def one_long_word(size: int) -> Files:
    return _idl(f"struct S {{ {'X' * size} x; }};")


@KINDS.add(1_000_000, commands=COMPONENT)
def one_long_name(size: int) -> Files:
    return _with_port(f"struct {'X' * size} {{ long x; }};", "X" * size)


@KINDS.add(1_000_000, commands=COMPONENT)
def one_long_text(size: int) -> Files:
    text = "x" * size
    return _idl(
        f'component C {{ @default("{text}") @unit("{text}") attribute string s; }};'
    )


@KINDS.add(5000, 1_000_000, commands=COMPONENT)
def one_long_number(size: int) -> Files:
    return _idl(
        f"const long long X = {'9' * size}; const double D = {'9' * size}.0;"
        f"component C {{ @default({'9' * size}) attribute long s;"
        f' @constraint("x<{"9" * size}") attribute long t; }};'
    )


@KINDS.add(100, 2000)
def chain_of_includes(size: int) -> Files:
    files = {
        f"i{i}.idl": f'#include "i{i + 1}.idl"\nstruct S{i} {{ long x; }};\n'
        for i in range(size)
    }
    return {**files, f"i{size}.idl": "", "a.idl": '#include "i0.idl"\n'}


@KINDS.add(30)
def includes_that_double(size: int) -> Files:
    files = {f"i{i}.idl": f'#include "i{i + 1}.idl"\n' * 2 for i in range(size)}
    return {**files, f"i{size}.idl": "// x\n", "a.idl": '#include "i0.idl"\n'}


@KINDS.add(20000)
def many_macros(size: int) -> Files:
    return _idl(
        lines(size, lambda i: f"#define M{i} M{i + 1}") + "\nconst long X = M0;"
    )


@KINDS.add(20000)
def many_annotations(size: int) -> Files:
    return _idl(f"{'@acme(1) ' * size} struct S {{ long x; }};")


@KINDS.add(300, 3000)
def deep_modules(size: int) -> Files:
    head = "".join(f"module M{i} {{ " for i in range(size))
    return _idl(f"{head} struct S {{ long x; }}; {'}; ' * size}")


@KINDS.add(60, 5000, commands=COMPONENT)
def ring_of_structs(size: int) -> Files:
    forward = lines(size, lambda i: f"struct S{i};")
    line = "struct S{0} {{ sequence<S{1}> a; sequence<S{2}> b; }};"
    return _with_port(
        forward + lines(size, lambda i: line.format(i, (i + 1) % size, (i + 7) % size)),
        "S0",
    )
