"""Descriptions of CANopen devices, and bus files, that are long, deep, or many."""

from __future__ import annotations

from growth import Files, Kinds, lines

EDS = (
    ("inspect", "a.eds"),
    ("generate", "-q", "--no-cache", "-o", "o", "a.eds"),
)
BUS = (("inspect", "a.toml"), ("generate", "-q", "--no-cache", "-o", "o", "a.toml"))

KINDS = Kinds(EDS)


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
    text = "".join(f"{n}=0x{i:04X}\n" for n, i in enumerate(indices, 1))
    return f"[{name}]\nSupportedObjects={len(indices)}\n{text}"


@KINDS.add(100, 1000, 16000)
def compact_sub_objects(size: int) -> Files:
    return _eds({0x2000 + i: _COMPACT for i in range(size)})


@KINDS.add(3000, 16000)
def many_objects(size: int) -> Files:
    return _eds({0x2000 + i: _VAR.format(7, i) for i in range(size)})


@KINDS.add(400)
def many_pdos(size: int) -> Files:
    compact = "ObjectType=9\nSubNumber=0\n"
    found = _eds({0x1800 + i: compact for i in range(size)})
    text = found["a.eds"].replace("NrOfTXPDO=0", f"NrOfTXPDO={size}\nCompactPDO=31")
    return {"a.eds": text}


@KINDS.add(50000)
def eds_many_sections(size: int) -> Files:
    return {"a.eds": _EDS + lines(size, lambda i: f"[Section{i}]\nKey{i}=1")}


@KINDS.add(100000)
def eds_many_keys(size: int) -> Files:
    return {"a.eds": _EDS + "[2000]\n" + lines(size, lambda i: f"Key{i}=1")}


@KINDS.add(1_000_000)
def eds_long_value(size: int) -> Files:
    return _eds(
        {0x2000: _VAR.format(7, "9" * size), 0x2001: _VAR.format(9, "x" * size)}
    )


_BUS = "[bus]\nname = 'b'\nbitrate = 500000\n"


@KINDS.add(900, 5000, 100000, commands=BUS)
def dotted_keys(size: int) -> Files:
    return {"a.toml": _BUS + ".".join("a" * size) + " = 1\n"}


@KINDS.add(900, 50000, commands=BUS)
def dotted_sections(size: int) -> Files:
    return {"a.toml": _BUS + f"[{'.'.join('a' * size)}]\nx = 1\n"}


@KINDS.add(3000, commands=BUS)
def many_dotted_keys(size: int) -> Files:
    return {"a.toml": _BUS + lines(300, lambda i: f"{'a.' * size}k{i} = 1")}


@KINDS.add(90, 5000, 100000, commands=BUS)
def nested_arrays(size: int) -> Files:
    return {"a.toml": f"{_BUS}x = {'[' * size}{']' * size}\n"}


@KINDS.add(90, 5000, 50000, commands=BUS)
def nested_tables(size: int) -> Files:
    return {"a.toml": f"{_BUS}x = {'{a=' * size}1{'}' * size}\n"}


@KINDS.add(127, 20000, commands=BUS)
def many_nodes(size: int) -> Files:
    line = '[nodes.N{0}]\nid = {0}\neds = "a.eds"\n'
    return {
        "a.toml": _BUS + lines(size, lambda i: line.format(i), 1),
        **_eds({0x2000: _VAR.format(7, "1")}),
    }


@KINDS.add(5000, commands=BUS)
def toml_long_number(size: int) -> Files:
    return {"a.toml": f"[bus]\nname='b'\nbitrate = {'9' * size}\n"}


@KINDS.add(1_000_000, commands=BUS)
def toml_long_text(size: int) -> Files:
    return {"a.toml": f"[bus]\nname='{'b' * size}'\n[{'c' * size}]\n"}


@KINDS.add(900, 20000, commands=(("inspect", "a.idl"),))
def project_file_with_dotted_keys(size: int) -> Files:
    return {"rtgen.toml": ".".join("a" * size) + " = 1\n", "a.idl": ""}


@KINDS.add(900, 20000, commands=(("inspect", "a.idl"),))
def project_file_with_nested_arrays(size: int) -> Files:
    return {"rtgen.toml": f"x = {'[' * size}{']' * size}\n", "a.idl": ""}
