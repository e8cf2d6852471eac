"""CDL files that are short with large effects, deep, or many."""

from __future__ import annotations

from growth import Files, Kinds, chain, lines

CDL = (
    ("inspect", "a.cdl"),
    ("generate", "-q", "--no-cache", "-o", "o", "--target", "openrtm", "a.cdl"),
)

KINDS = Kinds(CDL)


def _cdl(text: str) -> Files:
    return {"a.cdl": text}


def _signature(text: str, type_: str) -> Files:
    """Return a signature with a parameter of the type, and its join."""
    return _cdl(
        f"{text}\nsignature sS {{ void f([in] const {type_} *x); }};\n"
        + _LINE.format("sS")
    )


_LINE = """
celltype tServer {{ entry {0} eServer; }};
[active]
celltype tClient {{ call {0} cServer; }};
cell tServer Server {{ }};
cell tClient Client {{ [through(RTCPlugin, "")] cServer = Server.eServer; }};
"""


@KINDS.add(16, 60)
def cdl_structs_that_double(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; struct S{1} b; }};"
    return _signature(chain(size, "struct S0 { int32_t x; };", line), f"struct S{size}")


@KINDS.add(60, 1000)
def cdl_chain_of_structs(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; }};"
    return _signature(chain(size, "struct S0 { int32_t x; };", line), f"struct S{size}")


@KINDS.add(1000)
def cdl_chain_of_typedefs(size: int) -> Files:
    return _signature(
        chain(size, "typedef int32_t T0;", "typedef T{1} T{0};"), f"T{size}"
    )


@KINDS.add(20)
def cdl_arrays_that_multiply(size: int) -> Files:
    return _signature(
        chain(
            size,
            "struct S0 { int32_t x[100]; };",
            "struct S{0} {{ struct S{1} x[100]; }};",
        ),
        f"struct S{size}",
    )


def _composites(size: int, line: str) -> Files:
    first = "signature sS { void f(void); };\ncelltype tC0 { entry sS eE; };"
    return _cdl(f"{chain(size, first, line)}\ncell tC{size} Root {{ }};")


@KINDS.add(10, 16, 40)
def composites_that_double(size: int) -> Files:
    line = "composite tC{0} {{ entry sS eE; cell tC{1} A {{ }}; cell tC{1} B {{ }};"
    return _composites(size, line + " eE => A.eE; }};")


@KINDS.add(300, 3000)
def chain_of_composites(size: int) -> Files:
    line = "composite tC{0} {{ entry sS eE; cell tC{1} A {{ }}; eE => A.eE; }};"
    return _composites(size, line)


@KINDS.add(1000, 1_000_000_000)
def arrays_of_ports(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\n"
        f"celltype tS {{ entry sS eE[{size}]; }};\n"
        f"celltype tC {{ call sS cC[{size}]; }};\n"
        f"cell tS Server {{ }};\ncell tC Client {{ cC[{size - 1}] = Server.eE[{size - 1}]; }};"
    )


@KINDS.add(1_000_000_000)
def open_arrays_of_ports(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\n"
        "celltype tS { entry sS eE[]; };\ncelltype tC { call sS cC[]; };\n"
        f"cell tS Server {{ }};\ncell tC Client {{ cC[{size - 1}] = Server.eE[{size - 1}]; }};"
    )


@KINDS.add(5000)
def many_cells(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\ncelltype tS { entry sS eE; };\n"
        "celltype tC { call sS cC; };\ncell tS Server { };\n"
        + lines(size, lambda i: f"cell tC C{i} {{ cC = Server.eE; }};")
    )


@KINDS.add(500)
def many_functions(size: int) -> Files:
    functions = lines(size, lambda i: f"int32_t f{i}([in] int32_t a);")
    return _cdl(f"signature sS {{ {functions} }};\n" + _LINE.format("sS"))


@KINDS.add(60, 500)
def deep_namespaces(size: int) -> Files:
    head = "".join(f"namespace n{i} {{ " for i in range(size))
    return _cdl(f"{head} signature sS {{ void f(void); }}; {'}; ' * size}")


@KINDS.add(60, 500)
def deep_regions(size: int) -> Files:
    head = "".join(f"region r{i} {{ " for i in range(size))
    return _cdl(f"{head} {'}; ' * size}")


@KINDS.add(60, 5000)
def cdl_constants_that_double(size: int) -> Files:
    line = "const int32_t C{0} = C{1} * 2 + C{1};"
    return _cdl(chain(size, "const int32_t C0 = 1;", line))


@KINDS.add(60)
def attributes_that_double(size: int) -> Files:
    line = "int32_t a{0} = a{1} + a{1};"
    attributes = chain(size, "int32_t a0 = 1;", line)
    return _cdl(f"celltype tC {{ attr {{ {attributes} }}; }};\ncell tC C {{ }};")


@KINDS.add(30, 3000)
def c_macros_that_double(size: int) -> Files:
    return {
        "a.cdl": 'import_C("a.h");\nsignature sS { void f([in] T x); };',
        "a.h": chain(size, "#define A0 1", "#define A{0} A{1}+A{1}")
        + f"\nenum {{ X = A{size} }};\ntypedef int T;\n",
    }


@KINDS.add(16, 60)
def c_structs_that_double(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; struct S{1} b; }};"
    return {
        "a.cdl": 'import_C("a.h");\nsignature sS { void f([in] const T *x); };'
        + _LINE.format("sS"),
        "a.h": chain(size, "struct S0 { int x; };", line)
        + f"\ntypedef struct S{size} T;\n",
    }


@KINDS.add(50000)
def cdl_many_quotes(size: int) -> Files:
    return _cdl("'\"" * size)


@KINDS.add(50000)
def cdl_many_open_comments(size: int) -> Files:
    return _cdl("/*" * size + "\n" + "/**/" * size)


@KINDS.add(50000)
def cdl_many_brackets(size: int) -> Files:
    return _cdl("namespace n {" * size + "[[[" * size)


@KINDS.add(20000)
def cdl_many_mistakes(size: int) -> Files:
    return _cdl("cell tNothing C { cX = Y.eZ; };\n" * size)


@KINDS.add(20000)
def cdl_many_syntax_errors(size: int) -> Files:
    return _cdl("signature sS { void f(; };\n" * size)


@KINDS.add(20000)
def cdl_long_expression(size: int) -> Files:
    return _cdl(f"const int32_t X = {'1+' * size}1;\n const int32_t Y = {'(' * size}1;")


@KINDS.add(2000)
def cdl_many_signatures(size: int) -> Files:
    return _cdl(lines(size, lambda i: f"signature s{i} {{ void f([in] int32_t a); }};"))


@KINDS.add(150, 2000)
def chain_of_imports(size: int) -> Files:
    files = {f"i{i}.cdl": f'import("i{i + 1}.cdl");\n' for i in range(size)}
    return {**files, f"i{size}.cdl": "", "a.cdl": 'import("i0.cdl");\n'}


@KINDS.add(1000000)
def cdl_one_long_word(size: int) -> Files:
    return _cdl(f"signature {'s' * size} {{ void f({'t' * size} x); }};")


@KINDS.add(1000000)
def cdl_one_long_number(size: int) -> Files:
    return _cdl(f"const int32_t X = {'9' * size};")
