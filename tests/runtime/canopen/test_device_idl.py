"""The IDL of devices: for inclusion, in the model of a project, and devices without IDL."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from eds_files import Thing, eds, entry

from rtgen.cli import run
from rtgen.compiler.compilation import compile_project, read
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Component, Declaration, Interface, NamedType, Struct
from rtgen.compiler.model.components import ConfigurationParameter
from rtgen.compiler.project import load, with_arguments
from rtgen.compiler.project.compilation import Compilation

THINGS = (
    Thing("Speed", 0x04, default="1500"),
    Thing("Torque", 0x02, "ro"),
    Thing("Label", 0x09, mappable=False, default="bench"),
    Thing("Blob", 0x0F, mappable=False, default=""),
    Thing("Count", 0x15),
)
DRIVE = eds(
    THINGS,
    {1: [entry(0x2000, 32), entry(0x2001, 8)], 2: [entry(0x2004, 64)]},
    {1: [entry(0x2000, 32)]},
)
BUS = """
[bus]
bit_rate = 500
[device.drive]
eds = "drive.eds"
{settings}
[node.left]
device = "drive"
id = 3
[node.right]
device = "drive"
id = 4
"""
Make = Callable[..., Compilation]


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Make:
    """Return a compiler for a project of these files."""

    def compiled(target: str = "embedded", **files: str) -> Compilation:
        here = tmp_path / "specs"
        here.mkdir(exist_ok=True)
        (tmp_path / "rtgen.toml").write_text(
            '[sources]\npaths = ["specs"]\n[output]\npackage = "robots"\n'
            f'target = "{target}"\n'
        )
        for name, text in files.items():
            stem, _, suffix = name.rpartition("_")
            (here / f"{stem}.{suffix}").write_text(text, encoding="utf-8")
        monkeypatch.chdir(tmp_path)
        return compile_project(load())

    return compiled


def codes(made: Compilation) -> list[str]:
    """Return the codes except those about missing parts: keys for readers, a heartbeat."""
    return [d.code for d in made.diagnostics if d.code not in ("EDS0201", "EDS0711")]


def declared(name: str) -> object:
    """Return a declaration of the project around the working folder."""
    model = read(load(), lowered=True).model
    return model.find(tuple(name.split("::")))


def parameters(name: str) -> dict[str, ConfigurationParameter]:
    found = declared(name)
    assert isinstance(found, Component)
    return {p.name: p for p in found.configuration}


def ports(name: str) -> list[tuple[str, str, str]]:
    found = declared(name)
    assert isinstance(found, Component)
    return [(p.kind.value, p.name, str(p.type)) for p in found.ports]


def test_module_of_a_device(make: Make) -> None:
    assert not make(drive_eds=DRIVE).failed
    tpdo = declared("Drive::Tpdo1")
    assert isinstance(tpdo, Struct)
    assert [(m.name, str(m.type)) for m in tpdo.members] == [
        ("tm", "RTC::Time"),
        ("Speed", "long"),
        ("Torque", "short"),
    ]
    with pytest.raises(KeyError):
        declared("Drive::ObjectAccess")


def test_operations_for_single_objects(make: Make) -> None:
    settings = 'operations = ["2001", "2002", "2003", "2000"]'
    made = make(drive_eds=DRIVE, net_toml=BUS.format(settings=settings))
    assert not made.failed
    service = declared("Drive::ObjectAccess")
    assert isinstance(service, Interface)
    assert [operation.name for operation in service.operations] == [
        *("get_Torque", "get_Label", "set_Label", "get_Blob", "set_Blob"),
        *("get_Speed", "set_Speed"),
    ]
    assert service.bases == (("CANopen", "ObjectDictionary"),)
    operations = {o.name: o for o in service.operations}
    assert str(operations["get_Torque"].returns) == "short"
    assert str(operations["set_Label"].parameters[0].type) == "string"
    assert operations["get_Blob"].returns == NamedType(("CANopen", "Octets"))
    assert operations["get_Speed"].raises == (
        ("CANopen", "SdoAbort"),
        ("CANopen", "BusGone"),
    )


def test_members_that_a_struct_cannot_have_bear_their_number(make: Make) -> None:
    things = [Thing(name, 0x05) for name in ("TPDO1", "tm", "RTC", "Tpdo2")]
    mapped = [entry(0x2000 + place, 8) for place in (0, 1, 2, 3, 3)]
    assert not make(odd_eds=eds(things, {1: mapped})).failed
    tpdo = declared("Odd::Tpdo1")
    assert isinstance(tpdo, Struct)
    assert [m.name for m in tpdo.members] == [
        *("tm", "TPDO1_2000_00", "tm_2001_00", "RTC_2002_00", "Tpdo2", "Tpdo2_2"),
    ]


def test_components_of_a_device(make: Make) -> None:
    assert not make(drive_eds=DRIVE).failed
    of_pdos = [
        ("outport", "tpdo1", "Drive::Tpdo1"),
        ("outport", "tpdo2", "Drive::Tpdo2"),
        ("inport", "rpdo1", "Drive::Rpdo1"),
    ]
    assert ports("DriveDevice") == of_pdos
    assert ports("DriveProxy") == [
        *of_pdos,
        ("provider", "sdo", "CANopen::ObjectDictionary"),
    ]
    defaults = {name: p.default for name, p in parameters("DriveProxy").items()}
    assert defaults == {
        "interface": "virtual",
        "channel": "can0",
        "bitrate": 0,
        "options": "",
        "node_id": 1,
        "network": "",
        "master": False,
        "heartbeat_timeout": 0,
        "boot_timeout": 2000,
        "emergency_stop": "",
        "recoveries": 0,
        "sdo_in_error": False,
    }
    assert parameters("DriveDevice")["node_id"].maximum == 255


SETTINGS = """
ports = "object"
parameters = ["2000", "2001"]
[device.drive.factors]
"2000" = -0.5
[device.drive.units]
"2000" = "rad/s"
"""


def test_a_bus_file_says_how_components_are(make: Make) -> None:
    text = BUS.replace("{settings}", SETTINGS)
    drive = DRIVE.replace("AccessType=ro\nDefaultValue=0\nPDOM", "AccessType=rw\nPDOM")
    drive = drive.replace("DefaultValue=1500\n", "DefaultValue=1500\nHighLimit=2000\n")
    made = make(drive_eds=drive, bus_toml=text)
    assert codes(made) == ["EDS0804"]
    assert ports("DriveDevice") == [
        ("outport", "Speed_out", "RTC::TimedDouble"),
        ("outport", "Torque", "RTC::TimedShort"),
        ("outport", "Count", "Drive::TimedLongLong"),
        ("inport", "Speed_in", "RTC::TimedDouble"),
    ]
    found = parameters("DriveProxy")
    assert (found["network"].default, found["node_id"].default) == ("bus", 3)
    speed, torque = found["Speed"], found["Torque"]
    assert (str(speed.type), speed.default, speed.unit) == ("double", -750.0, "rad/s")
    assert (speed.minimum, speed.maximum) == (-1000.0, None)
    assert (torque.default, torque.minimum, torque.maximum) == (None, -128, 127)
    assert parameters("CanopenManager")["network"].default == "bus"


@pytest.mark.parametrize(
    ("limits", "start"),
    [
        ("LowLimit=5\nHighLimit=50\n", 5),
        ("LowLimit=-50\nHighLimit=-3\n", -3),
        ("LowLimit=-5\nHighLimit=5\n", None),
    ],
)
def test_an_object_without_a_default_begins_within_its_limits(
    make: Make, limits: str, start: int | None
) -> None:
    """As a parameter, and as a member of an RPDO before its first sample."""
    settings = 'ports = "object"\nparameters = ["2000"]\n'
    drive = DRIVE.replace("DefaultValue=1500\n", limits)
    made = make(drive_eds=drive, bus_toml=BUS.replace("{settings}", settings))
    assert codes(made) == ["EDS0804"]
    assert parameters("DriveProxy")["Speed"].default == (start or 0)
    [proxy] = [a for a in made.artifacts if a.path.endswith("drive_proxy/__init__.py")]
    assert f"Gathering(1, (_Speed_in, {start or 0}))" in proxy.text


def test_a_factor_out_of_this_world(make: Make) -> None:
    settings = SETTINGS.replace("-0.5", "1e308").replace(', "2001"', "")
    made = make(drive_eds=DRIVE, bus_toml=BUS.replace("{settings}", settings))
    assert codes(made) == []
    assert parameters("DriveProxy")["Speed"].default is None


def test_factors_of_a_description_are_reported_only(make: Make) -> None:
    scaled = DRIVE.replace(
        "ParameterName=Speed\n", "ParameterName=Speed\nFactor=0.1\nUnit=rpm\n"
    )
    settings = 'parameters = ["2000"]\n'
    make(drive_eds=scaled, bus_toml=BUS.replace("{settings}", settings))
    tpdo = declared("Drive::Tpdo1")
    assert isinstance(tpdo, Struct)
    speed = tpdo.members[1]
    assert (speed.name, str(speed.type)) == ("Speed", "long")
    assert speed.doc == "Speed (2000h, INTEGER32, in units of 0.1 rpm)"
    found = parameters("DriveProxy")["Speed"]
    assert (str(found.type), found.default, found.unit) == ("long", 1500, "")


def test_a_definition_uses_the_types_of_a_device(make: Make) -> None:
    text = """
    #include "Drive.idl"
    component Wheel {
        consumes Drive::Tpdo1 feedback;
        uses CANopen::ObjectDictionary objects;
    };
    """
    assert not make(drive_eds=DRIVE, wheel_idl=text).failed
    assert ports("Wheel") == [
        ("inport", "feedback", "Drive::Tpdo1"),
        ("consumer", "objects", "CANopen::ObjectDictionary"),
    ]


def test_inspect_has_what_is_included(
    make: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    make(drive_eds=DRIVE, wheel_idl='#include "Drive.idl"\n')
    assert run(["inspect", "--no-cache", "specs"]) == 0
    output = capfd.readouterr().out
    assert "struct Drive::Tpdo1" in output
    assert "component" not in output
    assert "device Drive" in output


def test_a_misspelt_include_of_a_device(make: Make) -> None:
    made = make(drive_eds=DRIVE, wheel_idl='#include "Drvie.idl"\n')
    [found] = [d for d in made.diagnostics if d.code == "IDL0010"]
    assert "Drive.idl" in str(found.hint)


def test_rtc_types_of_the_project(make: Make) -> None:
    """A project's own file is used; it is not copied beside the devices'."""
    own = (Path(__file__).parents[3] / "specs/idl/BasicDataType.idl").read_text()
    made = make("openrtm", drive_eds=DRIVE, BasicDataType_idl=own)
    paths = {a.path for a in made.artifacts}
    assert "robots/canopen/Canopen.idl" in paths
    assert "robots/canopen/BasicDataType.idl" not in paths
    [types] = [a for a in made.artifacts if a.path == "robots/_idl/basic_data_type.py"]
    assert types.origin == ("specs/BasicDataType.idl",)


def test_idl_of_rtgen_is_copied_for_other_compilers(make: Make) -> None:
    """Only if another compiler reads the IDL of devices."""
    shared = {"robots/canopen/Canopen.idl", "robots/canopen/BasicDataType.idl"}
    for_corba = {a.path for a in make("openrtm", drive_eds=DRIVE).artifacts}
    embedded = {a.path for a in make(drive_eds=DRIVE).artifacts}
    assert shared <= for_corba
    assert not shared & embedded
    assert "robots/drive/Drive.idl" in embedded


def test_no_manager_without_a_network(make: Make) -> None:
    made = make(drive_eds=DRIVE)
    assert not any("manager" in a.path.lower() for a in made.artifacts)


def test_node_id_of_the_command_line(
    make: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    make(drive_eds=DRIVE)
    assert run(["generate", "--no-cache", "--node-id", "9", "--diff"]) == 0
    assert "node_id: int = 9" in capfd.readouterr().out


def test_a_description_in_sources_and_bus_file_is_one_device(make: Make) -> None:
    made = make(drive_eds=DRIVE, bus_toml=BUS.replace("{settings}", 'name = "Wheel"'))
    assert not made.failed
    paths = {artifact.path for artifact in made.artifacts}
    assert "robots/wheel/__init__.py" in paths
    assert "robots/drive/__init__.py" not in paths


TWICE = BUS.replace("{settings}", '[device.other]\neds = "drive.eds"\n{settings}')


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ("", []),
        ('ports = "object"', ["EDS0800"]),
        ('name = "drive"\nports = "object"', ["EDS0800"]),
        ('name = "Other"\nports = "object"', []),
        ('[device.other.values]\n"1600:0" = 0', ["EDS0800"]),
    ],
)
def test_two_kinds_of_one_name(make: Make, settings: str, expected: list[str]) -> None:
    made = make(drive_eds=DRIVE, bus_toml=TWICE.replace("{settings}", settings))
    assert codes(made) == expected


@pytest.mark.parametrize("name", ["Components", "canopen", "RTC", "Networks", "corba"])
def test_names_that_a_device_cannot_have(make: Make, name: str) -> None:
    made = make(drive_eds=DRIVE, bus_toml=BUS.replace("{settings}", f'name = "{name}"'))
    assert codes(made) == ["EDS0801"]


@pytest.mark.parametrize("number", ["2001", "2003", "1018:1"])
def test_objects_that_cannot_be_parameters(make: Make, number: str) -> None:
    text = BUS.replace("{settings}", f'parameters = ["{number}"]')
    assert codes(make(drive_eds=DRIVE, bus_toml=text)) == ["EDS0803"]


def test_two_files_of_one_stem(make: Make, tmp_path: Path) -> None:
    other = eds([Thing("Other")])
    assert "EDS0800" in codes(make(drive_eds=DRIVE, DRIVE_dcf=other))


def test_a_broken_bus_file_and_a_broken_device(make: Make) -> None:
    made = make(drive_eds="[1000]\n", bus_toml="[bus]\nbit_rate = 7\n")
    assert made.failed
    assert {"EDS0701"} < set(codes(made))
    assert made.artifacts == ()


def test_other_toml_files_are_no_bus_files(make: Make) -> None:
    made = make(drive_eds=DRIVE, timeline_toml='[[step]]\nname = "[bus]"\n')
    assert not made.failed
    assert made.inputs.keys() & {"specs/timeline.toml"} == set()


def _alike(declaration: Declaration) -> object:
    """Return a declaration without its positions and texts for readers."""

    def stripped(value: object) -> object:
        if isinstance(value, Span):
            return None
        if isinstance(value, tuple):
            return [stripped(each) for each in value]
        if isinstance(value, msgspec.Struct):
            named = ((n, getattr(value, n)) for n in value.__struct_fields__)
            return [
                (n, stripped(each)) for n, each in named if n not in ("doc", "file")
            ]
        return value

    return stripped(declaration)


@pytest.mark.parametrize("kind", ["pdo", "object"])
def test_the_printed_idl_declares_what_the_lowering_makes(
    make: Make, kind: str, tmp_path: Path
) -> None:
    settings = f'ports = "{kind}"\noperations = ["2001", "2002", "2003", "2000"]'
    assert not make(drive_eds=DRIVE, net_toml=BUS.format(settings=settings)).failed
    lowered = read(load(), lowered=True).model
    made = {d.name: _alike(d) for d in lowered.of_file("Drive.idl")}
    made = {name: each for name, each in made.items() if len(name) == 2}
    assert {name[1] for name in made} >= {"ObjectAccess"}
    including = tmp_path / "user.idl"
    including.write_text('#include "Drive.idl"\ntypedef Drive::ObjectAccess Objects;\n')
    project = with_arguments(load(), paths=(str(including),), add=True)
    printed = read(project).model
    assert {d.name: _alike(d) for d in printed.of_file("Drive.idl")} == made
    both = read(project, lowered=True).model
    assert {
        d.name: _alike(d) for d in both.of_file("Drive.idl") if len(d.name) == 2
    } == made
    [file] = [each for each in both.files if each.name == "Drive.idl"]
    assert file.main
    assert file.sha256 == both.devices[0].sha256


def test_a_name_of_the_device_that_a_definition_declares(make: Make) -> None:
    taken = make(
        drive_eds=DRIVE,
        user_idl="module Drive { struct Tpdo1 { long other; }; };\n"
        "component DriveProxy { attribute long count; };\n",
    )
    assert codes(taken) == ["EDS0806", "EDS0806"]
    clashes = [d for d in taken.diagnostics if d.code == "EDS0806"]
    assert all(d.related[0].span.file.endswith("user.idl") for d in clashes)


def test_a_copy_of_the_devices_idl_is_no_clash(make: Make) -> None:
    first = make(drive_eds=DRIVE)
    [idl] = [a.text for a in first.artifacts if a.path.endswith("/Drive.idl")]
    assert not make(drive_eds=DRIVE, Drive_idl=idl).failed


def test_an_own_file_without_the_types_of_ports(make: Make) -> None:
    made = make(
        drive_eds=DRIVE,
        BasicDataType_idl="module RTC { struct Time { unsigned long sec; }; };\n",
        net_toml=BUS.format(settings='ports = "object"'),
    )
    assert "EDS0807" in codes(made)
    assert any("RTC::TimedLong" in d.message for d in made.diagnostics)
