"""Definitions that are short with large effects, deep, or many, by kind and size."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from fuzzing import ViolationError

from rtgen.cli import run

Files = dict[str, str]
Maker = Callable[[int], Files]

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
CDL = (
    ("inspect", "a.cdl"),
    ("generate", "-q", "--no-cache", "-o", "o", "--target", "openrtm", "a.cdl"),
)
EDS = (
    ("inspect", "a.eds"),
    ("generate", "-q", "--no-cache", "-o", "o", "a.eds"),
)
BUS = (("inspect", "a.toml"), ("generate", "-q", "--no-cache", "-o", "o", "a.toml"))
SYSTEM = (
    ("graph", "-o", "a.svg", "a.xml"),
    ("inspect", "a.xml"),
    ("convert", "--to", "rts-yaml", "a.xml"),
)
PROFILE = (
    ("inspect", "RTC.xml"),
    ("convert", "--to", "idl", "RTC.xml"),
    ("generate", "-q", "--no-cache", "-o", "o", "RTC.xml"),
)
ADOPT = (("adopt", "a.py"),)


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of definition: generator of its files, its sizes, the commands that read it."""

    make: Maker
    sizes: tuple[int, ...]
    commands: Sequence[tuple[str, ...]]


KINDS: dict[str, Kind] = {}


def kind(*sizes: int, commands: Sequence[tuple[str, ...]]) -> Callable[[Maker], Maker]:
    """Register a generator under its name."""

    def register(make: Maker) -> Maker:
        name = make.__name__.replace("_", " ")
        KINDS[name] = Kind(make, sizes, commands)
        return make

    return register


def _idl(text: str) -> Files:
    return {"a.idl": text}


def _with_port(text: str, type_: str) -> Files:
    return _idl(f"{text}\ncomponent Node {{ publishes {type_} port; }};\n")


def _lines(size: int, line: Callable[[int], str], first: int = 0) -> str:
    return "\n".join(line(i) for i in range(first, first + size))


# IDL.


@kind(16, 24, 60, commands=COMPONENT)
def structs_that_double(size: int) -> Files:
    return _with_port(
        "struct S0 { long x; };\n"
        + _lines(size, lambda i: f"struct S{i} {{ S{i - 1} a; S{i - 1} b; }};", 1),
        f"S{size}",
    )


@kind(16, 60, commands=COMPONENT)
def unions_that_double(size: int) -> Files:
    line = "union U{0} switch (long) {{ case 1: U{1} a; case 2: U{1} b; }};"
    return _with_port(
        "struct U0 { long x; };\n" + _lines(size, lambda i: line.format(i, i - 1), 1),
        f"U{size}",
    )


@kind(16, 60, commands=COMPONENT)
def sequences_that_double(size: int) -> Files:
    line = "struct S{0} {{ sequence<S{1}> a; sequence<S{1}> b; S{1} c[2]; }};"
    return _with_port(
        "struct S0 { long x; };\n" + _lines(size, lambda i: line.format(i, i - 1), 1),
        f"S{size}",
    )


@kind(10, 100, commands=COMPONENT)
def arrays_that_multiply(size: int) -> Files:
    return _with_port(
        "typedef long T0[10];\n"
        + _lines(size, lambda i: f"typedef T{i - 1} T{i}[10];", 1)
        + f"\nstruct S {{ T{size} x; }};",
        "S",
    )


@kind(1, commands=COMPONENT)
def one_large_array(size: int) -> Files:
    return _with_port("struct S { octet x[2000000000]; double y[30000][30000]; };", "S")


@kind(20, 60, commands=IDL)
def diamonds_of_interfaces(size: int) -> Files:
    text = "interface A0 { void f0(); }; interface B0 { void g0(); };\n"
    line = "interface {0}{1} : A{2}, B{2} {{ void {3}{1}(); }};"
    text += _lines(
        size,
        lambda i: line.format("A", i, i - 1, "f") + line.format("B", i, i - 1, "g"),
        1,
    )
    return _idl(text + f"\ncomponent Node {{ provides A{size} port; }};")


@kind(20, 60, commands=IDL)
def diamonds_of_value_types(size: int) -> Files:
    line = "abstract valuetype {0}{1} : A{2}, B{2} {{ void {3}{1}(); }};"
    return _idl(
        "abstract valuetype A0 { void f0(); }; abstract valuetype B0 { void g0(); };\n"
        + _lines(
            size,
            lambda i: line.format("A", i, i - 1, "f") + line.format("B", i, i - 1, "g"),
            1,
        )
    )


@kind(100, 1000, 5000, commands=COMPONENT)
def chain_of_structs(size: int) -> Files:
    return _with_port(
        "struct S0 { long x; };\n"
        + _lines(size, lambda i: f"struct S{i} {{ S{i - 1} a; }};", 1),
        f"S{size}",
    )


@kind(1000, 5000, commands=COMPONENT)
def chain_of_typedefs(size: int) -> Files:
    return _with_port(
        "struct S { long x; }; typedef S T0;\n"
        + _lines(size, lambda i: f"typedef T{i - 1} T{i};", 1)
        + f"\nstruct U {{ T{size} x; }};",
        "U",
    )


@kind(1000, 5000, commands=COMPONENT)
def chain_of_sequences(size: int) -> Files:
    return _with_port(
        "typedef sequence<long> T0;\n"
        + _lines(size, lambda i: f"typedef sequence<T{i - 1}> T{i};", 1)
        + f"\nstruct U {{ T{size} x; }};",
        "U",
    )


@kind(100, 1000, 5000, commands=COMPONENT)
def chain_of_bases(size: int) -> Files:
    return _with_port(
        "struct S0 { long x; };\n"
        + _lines(size, lambda i: f"struct S{i} : S{i - 1} {{ long y{i}; }};", 1),
        f"S{size}",
    )


@kind(100, 1000, 3000, commands=IDL)
def chain_of_interfaces(size: int) -> Files:
    text = "interface I0 { void f0(); };\n"
    text += _lines(size, lambda i: f"interface I{i} : I{i - 1} {{ void f{i}(); }};", 1)
    return _idl(text + f"\ncomponent Node {{ provides I{size} port; }};")


@kind(100, 1000, 3000, commands=IDL)
def chain_of_components(size: int) -> Files:
    line = "component C{0} : C{1} {{ attribute long p{0}; }};"
    return _idl(
        "component C0 { attribute long p0; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1)
    )


@kind(100, 1000, 3000, commands=IDL)
def chain_of_value_types(size: int) -> Files:
    line = "valuetype V{0} : V{1} {{ public long p{0}; }};"
    return _idl(
        "valuetype V0 { public long p0; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1)
    )


@kind(1000, 5000, commands=IDL)
def chain_of_constants(size: int) -> Files:
    line = "const long long C{0} = C{1} + 1;"
    return _idl(
        "const long long C0 = 0;\n" + _lines(size, lambda i: line.format(i, i - 1), 1)
    )


@kind(100, commands=IDL)
def constants_that_double(size: int) -> Files:
    line = "const string C{0} = C{1} C{1};"
    return _idl(
        'const string C0 = "ab";\n' + _lines(size, lambda i: line.format(i, i - 1), 1)
    )


@kind(20000, commands=IDL)
def many_members(size: int) -> Files:
    return _idl(f"struct S {{\n{_lines(size, lambda i: f'long m{i};')}\n}};")


@kind(20000, commands=IDL)
def many_enumerators(size: int) -> Files:
    names = ",\n".join(f"E{i}" for i in range(size))
    return _idl(f"enum E {{ {names} }};")


@kind(5000, commands=IDL)
def many_structs(size: int) -> Files:
    return _idl(_lines(size, lambda i: f"struct S{i} {{ long x; }};"))


@kind(400, commands=COMPONENT)
def many_components(size: int) -> Files:
    line = (
        "component C{0} {{ publishes D o; consumes D i; provides I s; uses I c;"
        " attribute double p; }};"
    )
    return _idl(
        "struct D { long x; }; interface I { void f(in D d); };\n"
        + _lines(size, lambda i: line.format(i))
    )


@kind(2000, commands=COMPONENT)
def many_ports(size: int) -> Files:
    ports = _lines(size, lambda i: f"publishes D o{i}; attribute long p{i};")
    return _idl(f"struct D {{ long x; }}; component C {{ {ports} }};")


@kind(3000, commands=IDL)
def many_operations(size: int) -> Files:
    return _idl(
        f"interface I {{ {_lines(size, lambda i: f'long f{i}(in long a);')} }};"
    )


@kind(3000, commands=IDL)
def many_bases(size: int) -> Files:
    bases = ", ".join(f"I{i}" for i in range(size))
    return _idl(
        _lines(size, lambda i: f"interface I{i} {{ void f{i}(); }};")
        + f"\ninterface J : {bases} {{}};"
    )


@kind(3000, commands=IDL)
def many_exceptions(size: int) -> Files:
    names = ", ".join(f"E{i}" for i in range(size))
    return _idl(
        _lines(size, lambda i: f"exception E{i} {{ long x; }};")
        + f"\ninterface J {{ void f() raises ({names}); }};"
    )


@kind(100000, commands=IDL)
def many_quotes(size: int) -> Files:
    return _idl("'\"" * size)


@kind(100000, commands=IDL)
def many_single_quotes(size: int) -> Files:
    return _idl("'" * size + "\n" + '"' * size)


@kind(20000, commands=IDL)
def many_lines_of_quotes(size: int) -> Files:
    return _idl("'\n\"\n" * size)


@kind(100000, commands=IDL)
def many_open_comments(size: int) -> Files:
    return _idl("/*" * size + "\n" + "/**/" * size)


@kind(100000, commands=IDL)
def many_brackets(size: int) -> Files:
    return _idl("module M {" * size)


@kind(50000, commands=IDL)
def many_syntax_errors(size: int) -> Files:
    return _idl("struct S { long; };\n" * size)


@kind(20000, commands=IDL)
def many_equal_names(size: int) -> Files:
    return _idl("struct S { long x; };\n" * size)


@kind(20000, commands=IDL)
def many_unknown_names(size: int) -> Files:
    return _idl(_lines(size, lambda i: f"struct S{i} {{ Nothing{i} x; }};"))


@kind(5000, commands=IDL)
def many_modules(size: int) -> Files:
    return _idl(_lines(size, lambda i: f"module M{i} {{ struct S {{ long x; }}; }};"))


@kind(20000, commands=IDL)
def long_documentation(size: int) -> Files:
    text = " * word word word\n" * size
    return _idl(f"/** \n{text}*/\nstruct S {{ long x; }};")


@kind(5_000_000, commands=COMPONENT)
def one_long_word(size: int) -> Files:
    return _idl(f"struct S {{ {'X' * size} x; }};")


@kind(1_000_000, commands=COMPONENT)
def one_long_name(size: int) -> Files:
    return _with_port(f"struct {'X' * size} {{ long x; }};", "X" * size)


@kind(1_000_000, commands=COMPONENT)
def one_long_text(size: int) -> Files:
    text = "x" * size
    return _idl(
        f'component C {{ @default("{text}") @unit("{text}") attribute string s; }};'
    )


@kind(5000, 1_000_000, commands=COMPONENT)
def one_long_number(size: int) -> Files:
    return _idl(
        f"const long long X = {'9' * size}; const double D = {'9' * size}.0;"
        f"component C {{ @default({'9' * size}) attribute long s;"
        f' @constraint("x<{"9" * size}") attribute long t; }};'
    )


@kind(100, 2000, commands=IDL)
def chain_of_includes(size: int) -> Files:
    files = {
        f"i{i}.idl": f'#include "i{i + 1}.idl"\nstruct S{i} {{ long x; }};\n'
        for i in range(size)
    }
    return {**files, f"i{size}.idl": "", "a.idl": '#include "i0.idl"\n'}


@kind(30, commands=IDL)
def includes_that_double(size: int) -> Files:
    files = {f"i{i}.idl": f'#include "i{i + 1}.idl"\n' * 2 for i in range(size)}
    return {**files, f"i{size}.idl": "// x\n", "a.idl": '#include "i0.idl"\n'}


@kind(20000, commands=IDL)
def many_macros(size: int) -> Files:
    return _idl(
        _lines(size, lambda i: f"#define M{i} M{i + 1}") + "\nconst long X = M0;"
    )


@kind(20000, commands=IDL)
def many_annotations(size: int) -> Files:
    return _idl(f"{'@acme(1) ' * size} struct S {{ long x; }};")


@kind(300, 3000, commands=IDL)
def deep_modules(size: int) -> Files:
    head = "".join(f"module M{i} {{ " for i in range(size))
    return _idl(f"{head} struct S {{ long x; }}; {'}; ' * size}")


@kind(60, 5000, commands=COMPONENT)
def ring_of_structs(size: int) -> Files:
    forward = _lines(size, lambda i: f"struct S{i};")
    line = "struct S{0} {{ sequence<S{1}> a; sequence<S{2}> b; }};"
    return _with_port(
        forward
        + _lines(size, lambda i: line.format(i, (i + 1) % size, (i + 7) % size)),
        "S0",
    )


# CDL.


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


@kind(16, 60, commands=CDL)
def cdl_structs_that_double(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; struct S{1} b; }};"
    return _signature(
        "struct S0 { int32_t x; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1),
        f"struct S{size}",
    )


@kind(60, 1000, commands=CDL)
def cdl_chain_of_structs(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; }};"
    return _signature(
        "struct S0 { int32_t x; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1),
        f"struct S{size}",
    )


@kind(1000, commands=CDL)
def cdl_chain_of_typedefs(size: int) -> Files:
    return _signature(
        "typedef int32_t T0;\n" + _lines(size, lambda i: f"typedef T{i - 1} T{i};", 1),
        f"T{size}",
    )


@kind(20, commands=CDL)
def cdl_arrays_that_multiply(size: int) -> Files:
    return _signature(
        "struct S0 { int32_t x[100]; };\n"
        + _lines(size, lambda i: f"struct S{i} {{ struct S{i - 1} x[100]; }};", 1),
        f"struct S{size}",
    )


@kind(10, 16, 40, commands=CDL)
def composites_that_double(size: int) -> Files:
    line = (
        "composite tC{0} {{ entry sS eE; cell tC{1} A {{ }}; cell tC{1} B {{ }};"
        " eE => A.eE; }};"
    )
    return _cdl(
        "signature sS { void f(void); };\ncelltype tC0 { entry sS eE; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1)
        + f"\ncell tC{size} Root {{ }};"
    )


@kind(300, 3000, commands=CDL)
def chain_of_composites(size: int) -> Files:
    line = "composite tC{0} {{ entry sS eE; cell tC{1} A {{ }}; eE => A.eE; }};"
    return _cdl(
        "signature sS { void f(void); };\ncelltype tC0 { entry sS eE; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1)
        + f"\ncell tC{size} Root {{ }};"
    )


@kind(1000, 1_000_000_000, commands=CDL)
def arrays_of_ports(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\n"
        f"celltype tS {{ entry sS eE[{size}]; }};\n"
        f"celltype tC {{ call sS cC[{size}]; }};\n"
        f"cell tS Server {{ }};\ncell tC Client {{ cC[{size - 1}] = Server.eE[{size - 1}]; }};"
    )


@kind(1_000_000_000, commands=CDL)
def open_arrays_of_ports(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\n"
        "celltype tS { entry sS eE[]; };\ncelltype tC { call sS cC[]; };\n"
        f"cell tS Server {{ }};\ncell tC Client {{ cC[{size - 1}] = Server.eE[{size - 1}]; }};"
    )


@kind(5000, commands=CDL)
def many_cells(size: int) -> Files:
    return _cdl(
        "signature sS { void f(void); };\ncelltype tS { entry sS eE; };\n"
        "celltype tC { call sS cC; };\ncell tS Server { };\n"
        + _lines(size, lambda i: f"cell tC C{i} {{ cC = Server.eE; }};")
    )


@kind(500, commands=CDL)
def many_functions(size: int) -> Files:
    functions = _lines(size, lambda i: f"int32_t f{i}([in] int32_t a);")
    return _cdl(f"signature sS {{ {functions} }};\n" + _LINE.format("sS"))


@kind(60, 500, commands=CDL)
def deep_namespaces(size: int) -> Files:
    head = "".join(f"namespace n{i} {{ " for i in range(size))
    return _cdl(f"{head} signature sS {{ void f(void); }}; {'}; ' * size}")


@kind(60, 500, commands=CDL)
def deep_regions(size: int) -> Files:
    head = "".join(f"region r{i} {{ " for i in range(size))
    return _cdl(f"{head} {'}; ' * size}")


@kind(60, 5000, commands=CDL)
def cdl_constants_that_double(size: int) -> Files:
    line = "const int32_t C{0} = C{1} * 2 + C{1};"
    return _cdl(
        "const int32_t C0 = 1;\n" + _lines(size, lambda i: line.format(i, i - 1), 1)
    )


@kind(60, commands=CDL)
def attributes_that_double(size: int) -> Files:
    text = "celltype tC { attr { int32_t a0 = 1; "
    text += _lines(size, lambda i: f"int32_t a{i} = a{i - 1} + a{i - 1};", 1)
    return _cdl(text + "}; };\ncell tC C { };")


@kind(30, 3000, commands=CDL)
def c_macros_that_double(size: int) -> Files:
    return {
        "a.cdl": 'import_C("a.h");\nsignature sS { void f([in] T x); };',
        "a.h": "#define A0 1\n"
        + _lines(size, lambda i: f"#define A{i} A{i - 1}+A{i - 1}", 1)
        + f"\nenum {{ X = A{size} }};\ntypedef int T;\n",
    }


@kind(16, 60, commands=CDL)
def c_structs_that_double(size: int) -> Files:
    line = "struct S{0} {{ struct S{1} a; struct S{1} b; }};"
    return {
        "a.cdl": 'import_C("a.h");\nsignature sS { void f([in] const T *x); };'
        + _LINE.format("sS"),
        "a.h": "struct S0 { int x; };\n"
        + _lines(size, lambda i: line.format(i, i - 1), 1)
        + f"\ntypedef struct S{size} T;\n",
    }


@kind(50000, commands=CDL)
def cdl_many_quotes(size: int) -> Files:
    return _cdl("'\"" * size)


@kind(50000, commands=CDL)
def cdl_many_open_comments(size: int) -> Files:
    return _cdl("/*" * size + "\n" + "/**/" * size)


@kind(50000, commands=CDL)
def cdl_many_brackets(size: int) -> Files:
    return _cdl("namespace n {" * size + "[[[" * size)


@kind(20000, commands=CDL)
def cdl_many_mistakes(size: int) -> Files:
    return _cdl("cell tNothing C { cX = Y.eZ; };\n" * size)


@kind(20000, commands=CDL)
def cdl_many_syntax_errors(size: int) -> Files:
    return _cdl("signature sS { void f(; };\n" * size)


@kind(20000, commands=CDL)
def cdl_long_expression(size: int) -> Files:
    return _cdl(f"const int32_t X = {'1+' * size}1;\n const int32_t Y = {'(' * size}1;")


@kind(2000, commands=CDL)
def cdl_many_signatures(size: int) -> Files:
    return _cdl(
        _lines(size, lambda i: f"signature s{i} {{ void f([in] int32_t a); }};")
    )


@kind(150, 2000, commands=CDL)
def chain_of_imports(size: int) -> Files:
    files = {f"i{i}.cdl": f'import("i{i + 1}.cdl");\n' for i in range(size)}
    return {**files, f"i{size}.cdl": "", "a.cdl": 'import("i0.cdl");\n'}


@kind(1000000, commands=CDL)
def cdl_one_long_word(size: int) -> Files:
    return _cdl(f"signature {'s' * size} {{ void f({'t' * size} x); }};")


@kind(1000000, commands=CDL)
def cdl_one_long_number(size: int) -> Files:
    return _cdl(f"const int32_t X = {'9' * size};")


# Descriptions of CANopen devices.

_EDS = """\
[FileInfo]
FileName=a.eds
FileVersion=1
FileRevision=1
EDSVersion=4.0
[DeviceInfo]
VendorName=Lab
VendorNumber=1
ProductName=Thing
ProductNumber=1
RevisionNumber=1
BaudRate_500=1
SimpleBootUpMaster=0
SimpleBootUpSlave=1
Granularity=8
NrOfRXPDO=0
NrOfTXPDO=0
LSS_Supported=0
"""


def _eds(objects: dict[int, str]) -> Files:
    mandatory = {0x1000: _VAR.format(7, "0"), 0x1001: _VAR.format(5, "0")}
    names = _listed("MandatoryObjects", list(mandatory))
    names += _listed("OptionalObjects", [i for i in objects if i < 0x2000])
    names += _listed("ManufacturerObjects", [i for i in objects if i >= 0x2000])
    texts = (
        f"[{index:04X}]\nParameterName=O{index:04X}\n{text}"
        for index, text in (mandatory | objects).items()
    )
    return {"a.eds": _EDS + names + "".join(texts)}


_VAR = "ObjectType=7\nDataType={0}\nAccessType=ro\nDefaultValue={1}\nPDOMapping=0\n"
_COMPACT = (
    "ObjectType=8\nDataType=7\nAccessType=rw\nDefaultValue=0\nPDOMapping=1\n"
    "CompactSubObj=254\n"
)


def _listed(name: str, indices: list[int]) -> str:
    lines = "".join(f"{n}=0x{i:04X}\n" for n, i in enumerate(indices, 1))
    return f"[{name}]\nSupportedObjects={len(indices)}\n{lines}"


@kind(100, 1000, 16000, commands=EDS)
def compact_sub_objects(size: int) -> Files:
    return _eds({0x2000 + i: _COMPACT for i in range(size)})


@kind(3000, 16000, commands=EDS)
def many_objects(size: int) -> Files:
    return _eds({0x2000 + i: _VAR.format(7, i) for i in range(size)})


@kind(400, commands=EDS)
def many_pdos(size: int) -> Files:
    compact = "ObjectType=9\nSubNumber=0\n"
    found = _eds({0x1800 + i: compact for i in range(size)})
    text = found["a.eds"].replace("NrOfTXPDO=0", f"NrOfTXPDO={size}\nCompactPDO=31")
    return {"a.eds": text}


@kind(50000, commands=EDS)
def eds_many_sections(size: int) -> Files:
    return {"a.eds": _EDS + _lines(size, lambda i: f"[Section{i}]\nKey{i}=1")}


@kind(100000, commands=EDS)
def eds_many_keys(size: int) -> Files:
    return {"a.eds": _EDS + "[2000]\n" + _lines(size, lambda i: f"Key{i}=1")}


@kind(1_000_000, commands=EDS)
def eds_long_value(size: int) -> Files:
    return _eds(
        {0x2000: _VAR.format(7, "9" * size), 0x2001: _VAR.format(9, "x" * size)}
    )


# Buses.

_BUS = "[bus]\nname = 'b'\nbitrate = 500000\n"


@kind(900, 5000, 100000, commands=BUS)
def dotted_keys(size: int) -> Files:
    return {"a.toml": _BUS + ".".join("a" * size) + " = 1\n"}


@kind(900, 50000, commands=BUS)
def dotted_sections(size: int) -> Files:
    return {"a.toml": _BUS + f"[{'.'.join('a' * size)}]\nx = 1\n"}


@kind(3000, commands=BUS)
def many_dotted_keys(size: int) -> Files:
    return {"a.toml": _BUS + _lines(300, lambda i: f"{'a.' * size}k{i} = 1")}


@kind(90, 5000, 100000, commands=BUS)
def nested_arrays(size: int) -> Files:
    return {"a.toml": f"{_BUS}x = {'[' * size}{']' * size}\n"}


@kind(90, 5000, 50000, commands=BUS)
def nested_tables(size: int) -> Files:
    return {"a.toml": f"{_BUS}x = {'{a=' * size}1{'}' * size}\n"}


@kind(127, 20000, commands=BUS)
def many_nodes(size: int) -> Files:
    line = '[nodes.N{0}]\nid = {0}\neds = "a.eds"\n'
    return {
        "a.toml": _BUS + _lines(size, lambda i: line.format(i), 1),
        **_eds({0x2000: _VAR.format(7, "1")}),
    }


@kind(5000, commands=BUS)
def toml_long_number(size: int) -> Files:
    return {"a.toml": f"[bus]\nname='b'\nbitrate = {'9' * size}\n"}


@kind(1_000_000, commands=BUS)
def toml_long_text(size: int) -> Files:
    return {"a.toml": f"[bus]\nname='{'b' * size}'\n[{'c' * size}]\n"}


@kind(900, 20000, commands=(("inspect", "a.idl"),))
def project_file_with_dotted_keys(size: int) -> Files:
    return {"rtgen.toml": ".".join("a" * size) + " = 1\n", "a.idl": ""}


@kind(900, 20000, commands=(("inspect", "a.idl"),))
def project_file_with_nested_arrays(size: int) -> Files:
    return {"rtgen.toml": f"x = {'[' * size}{']' * size}\n", "a.idl": ""}


# Systems and profiles.

_RTS = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:Lab:S:1.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{0}
</rts:RtsProfile>
"""
_MEMBER = (
    '<rts:Components rts:instanceName="C{0}" rts:id="RTC:Lab:Test:C{0}:1.0.0"'
    ' rts:pathUri="localhost/C{0}.rtc" rts:compositeType="None" rts:isRequired="true">'
    '<rts:DataPorts rts:name="C{0}.in"/><rts:DataPorts rts:name="C{0}.out"/>'
    "</rts:Components>"
)
_CONNECTOR = (
    '<rts:DataPortConnectors rts:connectorId="{2}" rts:name="n{2}" rts:dataType="T"'
    ' rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">'
    '<rts:sourceDataPort rts:portName="C{0}.out" rts:instanceName="C{0}"'
    ' rts:componentId="RTC:Lab:Test:C{0}:1.0.0"/>'
    '<rts:targetDataPort rts:portName="C{1}.in" rts:instanceName="C{1}"'
    ' rts:componentId="RTC:Lab:Test:C{1}:1.0.0"/></rts:DataPortConnectors>'
)


@kind(50, 400, commands=SYSTEM)
def system_in_a_row(size: int) -> Files:
    members = _lines(size, lambda i: _MEMBER.format(i))
    links = _lines(size - 1, lambda i: _CONNECTOR.format(i, i + 1, i))
    return {"a.xml": _RTS.format(members + links)}


@kind(50, 400, commands=SYSTEM)
def system_at_random(size: int) -> Files:
    members = _lines(size, lambda i: _MEMBER.format(i))
    links = _lines(
        3 * size, lambda i: _CONNECTOR.format(i % size, (i * 7919 + 13) % size, i)
    )
    return {"a.xml": _RTS.format(members + links)}


@kind(400, commands=SYSTEM)
def system_as_a_star(size: int) -> Files:
    members = _lines(size, lambda i: _MEMBER.format(i))
    links = _lines(size - 1, lambda i: _CONNECTOR.format(0, i, i), 1)
    return {"a.xml": _RTS.format(members + links)}


@kind(20, 70, commands=SYSTEM)
def system_of_all_with_all(size: int) -> Files:
    members = _lines(size, lambda i: _MEMBER.format(i))
    links = _lines(size * size, lambda i: _CONNECTOR.format(i // size, i % size, i))
    return {"a.xml": _RTS.format(members + links)}


@kind(2000, commands=SYSTEM)
def system_of_parallel_links(size: int) -> Files:
    members = _lines(2, lambda i: _MEMBER.format(i))
    links = _lines(size, lambda i: _CONNECTOR.format(0, 1, i))
    return {"a.xml": _RTS.format(members + links)}


_RTC = """\
<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:Lab:Test:Part:1.0.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:rtcDoc="http://www.openrtp.org/namespaces/rtc_doc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="Part" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="Test" rtc:vendor="Lab"
      rtc:version="1.0.0" rtc:executionType="PeriodicExecutionContext" rtc:executionRate="10.0"
      rtc:maxInstances="1"/>
{0}
</rtc:RtcProfile>
"""


@kind(1000, 5000, commands=PROFILE)
def profile_with_ports(size: int) -> Files:
    line = '<rtc:DataPorts rtc:name="same{1}" rtc:portType="DataInPort" rtc:type="A::T{0}"/>'
    return {
        "RTC.xml": _RTC.format(_lines(size, lambda i: line.format(i, " " * i + "x")))
    }


@kind(5000, commands=PROFILE)
def profile_with_equal_ports(size: int) -> Files:
    line = '<rtc:DataPorts rtc:name="a-{0}" rtc:portType="DataInPort" rtc:type="T"/>'
    names = ["".join("-+"[int(b)] for b in f"{i:014b}") for i in range(size)]
    return {"RTC.xml": _RTC.format("".join(line.format(n) for n in names))}


@kind(3000, commands=PROFILE)
def profile_with_parameters(size: int) -> Files:
    line = '<rtc:Configuration rtc:name="p{0}" rtc:type="int" rtc:defaultValue="{0}"/>'
    text = _lines(size, lambda i: line.format(i))
    return {
        "RTC.xml": _RTC.format(f"<rtc:ConfigurationSet>{text}</rtc:ConfigurationSet>")
    }


@kind(50, 5000, 200000, commands=PROFILE)
def deep_elements(size: int) -> Files:
    return {"RTC.xml": _RTC.format("<a>" * size + "</a>" * size)}


@kind(50000, commands=PROFILE)
def many_attributes(size: int) -> Files:
    return {
        "RTC.xml": _RTC.format(
            f"<a {_lines(size, lambda i: f'x{i}={chr(34)}1{chr(34)}')}/>"
        )
    }


@kind(1_000_000, commands=PROFILE)
def one_long_attribute(size: int) -> Files:
    return {
        "RTC.xml": _RTC.format(
            f'<rtc:DataPorts rtc:name="{"n" * size}" rtc:portType="{"k" * size}" rtc:type="T"/>'
            f'<rtc:DataPorts rtc:name="{"n" * size}" rtc:portType="DataInPort"'
            f' rtc:type="{"T" * size}"/>'
        )
    }


YAML = (
    ("inspect", "RTC.yaml"),
    ("convert", "--to", "rtc-xml", "RTC.yaml"),
    ("convert", "--to", "rts-xml", "a.yaml"),
    ("inspect", "a.yaml"),
)


@kind(12, 40, commands=YAML)
def yaml_aliases_that_double(size: int) -> Files:
    lines = "a0: &a0 [x, x]\n" + _lines(
        size, lambda i: f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]", 1
    )
    text = f"{lines}\nrtcProfile: *a{size}\nrtsProfile: *a{size}\n"
    return {"RTC.yaml": text, "a.yaml": text}


@kind(12, 24, commands=YAML)
def yaml_profile_of_aliases(size: int) -> Files:
    lines = "a0: &a0 {rtc: x, y: x}\n" + _lines(
        size, lambda i: f"a{i}: &a{i} {{y: *a{i - 1}, z: *a{i - 1}}}", 1
    )
    rtc = f"{lines}\nrtcProfile:\n  version: '0.3'\n  id: x\n  basicInfo: *a{size}\n"
    rts = f"{lines}\nrtsProfile:\n  version: '0.2'\n  id: x\n  components: [*a{size}]\n"
    return {"RTC.yaml": rtc, "a.yaml": rts}


@kind(90, 5000, 50000, commands=YAML)
def yaml_nesting(size: int) -> Files:
    text = f"rtcProfile: {'[' * size}{']' * size}\n"
    return {"RTC.yaml": text, "a.yaml": text.replace("rtc", "rts")}


# Modules that `adopt` reads.

_MODULE = """\
import OpenRTM_aist
import RTC
spec = ["implementation_id", "Part", "type_name", "Part", {spec}]
class Part(OpenRTM_aist.DataFlowComponentBase):
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        {body}
"""
_ADDED = 'self.p = OpenRTM_aist.InPort("{0}", RTC.TimedLong(RTC.Time(0, 0), 0))\n'
_ADDED += '        self.addInPort("{0}", self.p)'


def _module(spec: str = "", body: str = "pass", head: str = "") -> Files:
    return {"a.py": head + _MODULE.format(spec=spec, body=body)}


@kind(4301, 100000, commands=ADOPT)
def numbers_of_many_digits(size: int) -> Files:
    digits = "9" * size
    return _module(
        spec=f'"conf.default.x", str({digits}), "max_instance", "{digits}"',
        body=f"self.x = [{digits}]",
    )


@kind(4301, 20000, commands=ADOPT)
def hexadecimal_numbers(size: int) -> Files:
    digits = "0x" + "f" * size
    return _module(spec=f'"conf.default.x", str({digits})', body=f"self.x = [{digits}]")


@kind(500, 2000, 100000, commands=ADOPT)
def chain_of_attributes(size: int) -> Files:
    return _module(body=f"self{'.a' * size} = 1\n        self{'.a' * size}()")


@kind(500, 2000, 100000, commands=ADOPT)
def chain_of_sums(size: int) -> Files:
    texts = " + ".join(['"a"'] * size)
    return _module(spec=f'"description", {texts}', body=f"x = {texts}")


@kind(500, 2000, 100000, commands=ADOPT)
def chain_of_calls(size: int) -> Files:
    return _module(body=f"self.a{'()' * size}\n        self{'.a()' * size}")


@kind(80, 2000, 100000, commands=ADOPT)
def nested_lists(size: int) -> Files:
    return _module(
        spec="[" * size + "]" * size, body=f"self.x = {'[' * size}{']' * size}"
    )


@kind(80, 2000, commands=ADOPT)
def nested_tuples(size: int) -> Files:
    left, right = "(" * size, ",)" * size
    return _module(body=f"{left}a{right} = {left}1{right}")


@kind(2000, 20000, commands=ADOPT)
def chain_of_classes(size: int) -> Files:
    text = _lines(size, lambda i: f"class C{i}(C{i + 1}): pass")
    return _module(head="", body="pass" + "\n" + text)


@kind(60, 2000, commands=ADOPT)
def diamonds_of_classes(size: int) -> Files:
    line = "class C{0}(C{1}, D{1}): pass\nclass D{0}(C{1}, D{1}): pass"
    text = _lines(size, lambda i: line.format(i, i + 1))
    return _module(body="pass" + "\n" + text)


@kind(60, 2000, commands=ADOPT)
def variables_that_double(size: int) -> Files:
    text = "v0 = 'ab'\n" + _lines(size, lambda i: f"v{i} = v{i - 1} + v{i - 1}", 1)
    return _module(head=text + "\n", spec=f'"description", v{size}')


@kind(60, 90, 2000, commands=ADOPT)
def nested_blocks(size: int) -> Files:
    lines = [f"{' ' * (8 + i)}if x:" for i in range(size)]
    return _module(body="\n".join(["pass", *lines, f"{' ' * (8 + size)}pass"]))


@kind(5000, commands=ADOPT)
def module_with_ports(size: int) -> Files:
    return _module(
        body="\n        ".join(
            _ADDED.format(f"p{i}").replace("self.p", f"self.p{i}") for i in range(size)
        )
    )


@kind(1_000_000, commands=ADOPT)
def module_with_a_long_name(size: int) -> Files:
    spec = f'"{"k" * size}", "x", "vendor", "{"v" * size}"'
    return _module(spec=spec, body=_ADDED.format("n" * size))


@kind(1, commands=ADOPT)
def odd_encodings(size: int) -> Files:
    return _module(head="# coding: rot13\n")


@kind(1_000_000, commands=ADOPT)
def long_encoding(size: int) -> Files:
    return _module(head=f"# coding: {'x' * size}\n")


# Runs.


Case = tuple[str, int, tuple[str, ...]]
"""A kind, a size, and the words of a command."""

CASES: tuple[Case, ...] = tuple(
    (name, size, command)
    for name, each in KINDS.items()
    for size in each.sizes
    for command in each.commands
)
"""All cases, in a fixed order."""

_MESSAGES = 1_000_000
"""Maximum number of characters in the output of a command."""


class GrowthTarget:
    """Runs the commands on all definitions, each within the limits of the other fuzzers."""

    def __init__(self, folder: Path, cases: Sequence[Case] = CASES) -> None:
        self._folder = folder
        self._cases = cases
        os.environ["RTGEN_CACHE_DIR"] = str(folder / "cache")

    def make(self, number: int) -> bytes:
        """Return the words of a case."""
        name, size, command = self._cases[number]
        return f"{name} {size}: {' '.join(command)}".encode()

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Run a case; raises for an internal error, or for too much output."""
        name, size, command = self._cases[max(number, 0)]
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            for file, text in KINDS[name].make(size).items():
                Path(folder, file).write_text(text)
            messages = io.StringIO()
            with (
                chdir(folder),
                Path(os.devnull).open("w") as nothing,
                redirect_stdout(nothing),
                redirect_stderr(messages),
            ):
                code = run(command)
        output = messages.getvalue()
        if code not in (0, 1, 2) or len(output) > _MESSAGES:
            where = f"{name} {size}: exit code {code}, {len(output):,} characters"
            raise ViolationError(f"{output[-500:]}\n{where}")
        yield ("accepted", "accepted", "refused")[code]
