"""Projects for `slopes.py` whose size is a parameter.

Each is a dict of file names and texts; `version` is 1 for a second version in which every item has
changed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import isqrt

Files = dict[str, str]
Maker = Callable[[int, int], Files]

DEFINITIONS = ("generate", "check", "lint", "diff", "docs", "inspect", "lsp")
TEXTS = (*DEFINITIONS, "fmt")
SYSTEMS = ("check", "lint", "docs", "inspect", "lsp", "graph", "run", "ui")
COMMANDS = (*TEXTS, *SYSTEMS[-3:])


@dataclass(frozen=True, slots=True)
class Shape:
    """A kind of project: its language, the least of its sizes, and the commands that read it."""

    make: Maker
    size: int
    commands: tuple[str, ...]


SHAPES: dict[str, Shape] = {}


def _shape(size: int, commands: tuple[str, ...]) -> Callable[[Maker], Maker]:
    def register(make: Maker) -> Maker:
        SHAPES[make.__name__.replace("_", " ")] = Shape(make, size, commands)
        return make

    return register


def _lines(size: int, line: Callable[[int], str]) -> str:
    return "\n".join(line(number) for number in range(size)) + "\n"


# IDL


@_shape(20, TEXTS)
def idl_structs(size: int, version: int) -> Files:
    """Return structs of structs, with enums, constants, typedefs and comments."""
    text = _lines(
        size,
        lambda i: f"""
  const long LENGTH{i} = {i + 1};
  enum Mode{i} {{ MODE{i}_OFF, MODE{i}_ON }};
  typedef sequence<double, LENGTH{i}> Values{i};
  /** The record of number {i}. */
  struct Record{i} {{
  Mode{i} mode;   ///< What it does.
    @unit("m") double distance; Values{i} values;
    {f'Record{i - 1}' if i % 10 else 'long'} inner;
    {'double' if version else 'long'} count;
  }};""",
    )
    return {"definitions/a.idl": f"module Lab {{{text}}};\n"}


@_shape(1, TEXTS)
def idl_deep_modules(size: int, version: int) -> Files:
    """Return chains of 24 nested modules with a struct in each."""
    member = "double" if version else "long"
    text = ""
    for chain in range(size):
        for level in range(24):
            inner = f"Item{chain}_0 inner;" if level else ""
            text += f"module Part{chain}_{level} {{\n"
            text += f" struct Item{chain}_{level} {{ {member} count; {inner} }};\n"
        text += "};\n" * 24
    return {"definitions/a.idl": text}


@_shape(25, TEXTS)
def idl_operations(size: int, version: int) -> Files:
    """Return an interface whose operations have a type with as many structs as they are."""
    inner = _lines(size, lambda i: f"struct Part{i} {{ long x; sequence<double> y; }};")
    members = _lines(size, lambda i: f"  Part{i} member{i};")
    kind = "double" if version else "long"
    calls = _lines(size, lambda i: f"  {kind} call{i}(in Whole given, out Part{i} x);")
    text = f"{inner}struct Whole {{\n{members}}};\ninterface Service {{\n{calls}}};\n"
    return {"definitions/a.idl": f"module Lab {{\n{text}}};\n"}


@_shape(5, TEXTS)
def idl_services(size: int, version: int) -> Files:
    """Return interfaces with an exception, and components that provide and use them."""
    kind = "double" if version else "long"
    calls = _lines(
        10,
        lambda k: f"    {kind} call{k}(in long index, out string text) raises (Failed@);",
    )
    text = f"""
  exception Failed@ {{ string reason; }};
  interface Service@ {{
{calls}  }};
  component Server@ {{ provides Service@ service; }};
  component Client@ {{ uses Service@ service; attribute double gain; }};"""
    return {
        "definitions/a.idl": "module Lab {"
        + _lines(size, lambda i: text.replace("@", str(i)))
        + "};\n"
    }


@_shape(12, DEFINITIONS)
def idl_lattice(size: int, version: int) -> Files:
    """Return files each of which includes the next two, with structs of the next."""
    files = {f"included/part{i}.idl": _included(i, size, version) for i in range(size)}
    return {"definitions/a.idl": '#include "part0.idl"\n', **files}


def _included(number: int, size: int, version: int) -> str:
    after = [other for other in (number + 1, number + 2) if other < size]
    includes = "".join(f'#include "part{other}.idl"\n' for other in after)
    held = after if number % 24 > 1 else []
    members = "".join(f" Part{other}::Item inner{other};" for other in held)
    kind = "double" if version else "long"
    return (
        f"#ifndef PART_{number}\n#define PART_{number}\n{includes}"
        f"module Part{number} {{\n  struct Item {{ {kind} stamp;{members} }};\n"
        + _lines(8, lambda k: f"  struct More{k} {{ Item first; double x{k}; }};")
        + "};\n#endif\n"
    )


@_shape(36, DEFINITIONS)
def idl_circles(size: int, version: int) -> Files:
    """Return files each of which includes all others: as many inclusions as `size`."""
    numbers = range(isqrt(size))
    kind = "double" if version else "long"
    return {
        f"definitions/part{i}.idl": f"#ifndef PART_{i}\n#define PART_{i}\n"
        + "".join(f'#include "part{k}.idl"\n' for k in numbers if k != i)
        + f"module Part{i} {{ struct Item {{ {kind} stamp; }}; }};\n#endif\n"
        for i in numbers
    }


# CDL


@_shape(15, TEXTS)
def cdl_cells(size: int, version: int) -> Files:
    """Return cells of few celltypes, each joined to the one before."""
    first = 2 if version else 1
    cells = _lines(
        size,
        lambda i: f"cell tLink Link{i} {{ cLink = {f'Link{i - 1}' if i else 'First'}.eLink; "
        f"number = {i + first}; }};",
    )
    return {"definitions/a.cdl": f"""\
signature sLink {{ int32_t get([in] int32_t index); }};
celltype tFirst {{ entry sLink eLink; }};
[active] celltype tLink {{ entry sLink eLink; call sLink cLink; attr {{ int32_t number = 0; }}; }};
cell tFirst First {{ }};
{cells}"""}


@_shape(4, TEXTS)
def cdl_joins(size: int, version: int) -> Files:
    """Return signatures with a server, a client and a join through RTCs each."""
    kind = "double64_t" if version else "int32_t"
    text = """\
signature sBig@ {{
{0}}};
celltype tServer@ {{ entry sBig@ eBig; }};
[active] celltype tClient@ {{ call sBig@ cBig; }};
cell tServer@ Server@ {{ }};
cell tClient@ Client@ {{ [through(RTCPlugin, "")] cBig = Server@.eBig; }};"""
    calls = _lines(
        5,
        lambda k: f"  int32_t op{k}([in] {kind} a, [in,size_is(n)] const int16_t *v, "
        "[in] int32_t n, [inout] struct tagItem *it);",
    )
    joins = _lines(size, lambda i: text.format(calls).replace("@", str(i)))
    return {
        "definitions/a.cdl": "struct tagItem { int32_t id; float32_t w[4]; };\n" + joins
    }


@_shape(12, TEXTS)
def cdl_signatures(size: int, version: int) -> Files:
    """Return signatures with structs, which no cell uses."""
    kind = "double64_t" if version else "int32_t"
    text = """\
const int32_t LENGTH@ = @ + 4;
struct tagItem@ {{ int32_t id; {0} w[LENGTH@]; }};
signature sBig@ {{
  int32_t put([in] {0} a, [in] const struct tagItem@ *item);
  int32_t get([in] int32_t n, [out,size_is(n)] {0} *v);
}};"""
    return {
        "definitions/a.cdl": _lines(
            size, lambda i: text.format(kind).replace("@", str(i))
        )
    }


# EDS

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
NrOfRXPDO={0}
NrOfTXPDO={1}
LSS_Supported=0
"""
_VARIABLE = (
    "ParameterName={0}\nObjectType=7\nDataType={1}\nAccessType={2}\nDefaultValue={3}\n"
    "PDOMapping={4}\n"
)


def _eds(objects: dict[int, str], sends: int = 0, receives: int = 0) -> Files:
    mandatory = {
        0x1000: "[1000]\n" + _VARIABLE.format("Device type", 7, "ro", 0, 0),
        0x1001: "[1001]\n" + _VARIABLE.format("Error register", 5, "ro", 0, 0),
        0x1018: "[1018]\nParameterName=Identity\nObjectType=9\nSubNumber=2\n[1018sub0]\n"
        + _VARIABLE.format("Number", 5, "ro", 1, 0)
        + "[1018sub1]\n"
        + _VARIABLE.format("Vendor", 7, "ro", 1, 0),
    }
    names = (
        _listed("MandatoryObjects", mandatory)
        + _listed("OptionalObjects", (i for i in objects if not 0x2000 <= i < 0x6000))
        + _listed("ManufacturerObjects", (i for i in objects if 0x2000 <= i < 0x6000))
    )
    text = names + "".join((mandatory | objects).values())
    return {"definitions/a.eds": _EDS.format(receives, sends) + text}


def _listed(name: str, indices: Iterable[int]) -> str:
    texts = [f"{number}=0x{index:04X}\n" for number, index in enumerate(indices, 1)]
    return f"[{name}]\nSupportedObjects={len(texts)}\n{''.join(texts)}"


@_shape(20, DEFINITIONS)
def eds_objects(size: int, version: int) -> Files:
    """Return variables and records of a manufacturer."""
    objects = {}
    for number in range(size):
        index, name = 0x2000 + number, f"Value {number}"
        if number % 3:
            value = number + version
            text = _VARIABLE.format(name, 7, "rw", value, 0)
        else:
            text = f"ParameterName={name}\nObjectType=9\nSubNumber=3\n"
            for sub, default in enumerate((2, number + version, 7)):
                text += f"[{index:04X}sub{sub}]\n" + _VARIABLE.format(
                    f"Part {sub}", 7 if sub else 5, "rw" if sub else "ro", default, 0
                )
        objects[index] = f"[{index:04X}]\n{text}"
    return _eds(objects)


@_shape(6, DEFINITIONS)
def eds_pdos(size: int, version: int) -> Files:
    """Return PDOs that are sent, with four variables each."""
    objects = {}
    for number in range(size):
        index = 0x1800 + number
        text = (
            f"[{index:04X}]\nParameterName=TPDO {number}\nObjectType=9\nSubNumber=3\n"
        )
        cob = (
            f"$NODEID+0x{0x40000180 + number * 0x80:X}" if number < 4 else "0x80000000"
        )
        for sub, (kind, access, value) in enumerate(
            ((5, "ro", "2"), (7, "rw", cob), (5, "rw", "255"))
        ):
            text += f"[{index:04X}sub{sub}]\n" + _VARIABLE.format(
                f"Part {sub}", kind, access, value, 0
            )
        objects[index] = text
    for number in range(size):
        index, source = 0x1A00 + number, 0x6000 + number
        text = f"[{index:04X}]\nParameterName=Map {number}\nObjectType=9\nSubNumber=5\n"
        for sub in range(5):
            value = f"0x{source << 16 | sub << 8 | 16:08X}" if sub else "4"
            text += f"[{index:04X}sub{sub}]\n" + _VARIABLE.format(
                f"Part {sub}", 7 if sub else 5, "rw", value, 0
            )
        objects[index] = text
    for number in range(size):
        index = 0x6000 + number
        text = f"[{index:04X}]\nParameterName=Signals {number}\nObjectType=9\nSubNumber=5\n"
        for sub in range(5):
            text += f"[{index:04X}sub{sub}]\n" + _VARIABLE.format(
                f"Signal {number} {sub}",
                3 if sub else 5,
                "ro",
                version if sub else 4,
                int(sub > 0),
            )
        objects[index] = text
    return _eds(objects, sends=size)


# Systems

_SYSTEM = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:Lab:Test:1.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{0}{1}  <rtsExt:Properties rtsExt:name="rtgen.run.until" rtsExt:value="1"/>
</rts:RtsProfile>
"""
_MEMBER = """\
  <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:Lab:Test:{1}:1.0.0"
      rts:instanceName="{0}" rts:pathUri="localhost/{0}.rtc" rts:compositeType="None"
      rts:isRequired="true"/>
"""
_CONNECTOR = """\
  <rts:DataPortConnectors rts:connectorId="{0}" rts:name="{0}"
      rts:dataType="Lab::Sample" rts:interfaceType="corba_cdr"
      rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:portName="sent" rts:instanceName="{1}" rts:componentId=""/>
    <rts:targetDataPort rts:portName="received" rts:instanceName="{2}" rts:componentId=""/>
  </rts:DataPortConnectors>
"""
_NODES = """\
module Lab {{
  struct Sample {{ {0} value; }};
{1}}};
"""


def _system(
    types: int, names: list[str], links: Iterable[tuple[str, str]], version: int
) -> Files:
    """Return a system of components whose types are taken in turn."""
    nodes = _lines(
        types,
        lambda i: f"  @rate(10) component Node{i} {{ publishes Sample sent; "
        "consumes Sample received; attribute double gain; };",
    )
    members = "".join(
        _MEMBER.format(name, f"Node{i % types}") for i, name in enumerate(names)
    )
    connectors = "".join(
        _CONNECTOR.format(f"c{number}", *pair) for number, pair in enumerate(links)
    )
    kind = "double" if version else "long"
    return {
        "definitions/nodes.idl": _NODES.format(kind, nodes),
        "systems/system.xml": _SYSTEM.format(members, connectors),
    }


@_shape(63, SYSTEMS)
def system_in_a_row(size: int, version: int) -> Files:
    """Return components of three types in a row."""
    names = [f"C{i}" for i in range(size)]
    return _system(3, names, pairwise(names), version)


@_shape(20, SYSTEMS)
def system_as_a_star(size: int, version: int) -> Files:
    """Return a component that sends to all others."""
    names = [f"C{i}" for i in range(size)]
    return _system(3, names, ((names[0], name) for name in names[1:]), version)


@_shape(20, SYSTEMS)
def system_at_random(size: int, version: int) -> Files:
    """Return components with three connections each."""
    names = [f"C{i}" for i in range(size)]
    links = (
        (names[i], names[(7 * i + 13 * k + 1) % size])
        for i in range(size)
        for k in range(3)
    )
    return _system(3, names, dict.fromkeys(links), version)


@_shape(8, (*TEXTS, "graph", "run", "ui"))
def system_of_many_types(size: int, version: int) -> Files:
    """Return components of as many types, in a row."""
    names = [f"C{i}" for i in range(size)]
    return _system(size, names, pairwise(names), version)
