"""The files and lines that rtgen writes for a function of CDL, an EDS, and a small IDL file."""

from __future__ import annotations

from pathlib import Path

from generated_projects import project

EDS = Path(__file__).parents[3] / "specs/canopen/epos_drive.eds"
CDL = """\
signature sMotor {
    ER setSpeed([in] int32_t speed);
};
celltype tMotor { entry sMotor eMotor; };
celltype tUser { call sMotor cMotor; };
cell tMotor Motor {};
cell tUser User {
    [through(RTCPlugin, "")]
    cMotor = Motor.eMotor;
};
"""
IDL = """\
#include "BasicDataType.idl"

module arm {
    struct JointState {
        RTC::Time tm;
        double angle;  //< Angle [rad].
        double speed;
    };
    struct Limits {
        double lowest;
        double highest;
    };
    interface Control {
        void restrict(in Limits range);
        Limits range();
    };
};

component Swing {
    publishes arm::JointState state;
    provides arm::Control control;
    attribute double amplitude;
};
"""
MAX_FILES = 12
"""docs/decisions/0001 lists them, including the manifest, without the user's skeleton."""


def files(generated: Path) -> set[str]:
    found = (path for path in generated.rglob("*") if path.is_file())
    return {path.relative_to(generated).as_posix() for path in found}


def test_for_one_function_of_cdl(tmp_path: Path) -> None:
    with project(tmp_path, {"board.cdl": CDL}) as generated:
        made = files(generated)
    assert made == {
        *(".rtgen.json", "mine/__init__.py", "mine/py.typed", "mine/tecs/__init__.py"),
        *(
            f"mine/tecs/board/{name}"
            for name in (
                *("__init__.py", "Motor.idl", "RTC.xml", "RTCPlugin.rb"),
                *("motor_codec.py", "motor_marshaller.py", "motor_server.py"),
                "OpaqueRpcCommunication0.conf",
            )
        ),
    }
    assert len(made) <= MAX_FILES


def test_for_one_eds(tmp_path: Path) -> None:
    text = EDS.read_text(encoding="utf-8")
    with project(tmp_path, {"epos_drive.eds": text}) as generated:
        made = files(generated)
    assert made == {
        *(".rtgen.json", "mine/__init__.py", "mine/py.typed"),
        *("mine/components/__init__.py",),
        *(
            f"mine/components/epos_drive_{role}/{name}"
            for role in ("proxy", "device")
            for name in ("__init__.py", "RTC.xml")
        ),
        *(
            f"mine/eposdrive/{name}"
            for name in ("__init__.py", "EposDrive.idl", "EposDriveProxy.eds")
        ),
    }
    assert len(made) <= MAX_FILES


def test_for_a_further_signature(tmp_path: Path) -> None:
    lamp = (
        CDL.replace("Motor", "Lamp")
        .replace("User", "Hand")
        .replace("int32_t", "int8_t")
    )
    made = []
    for number, text in enumerate((CDL, CDL + lamp)):
        with project(tmp_path / str(number), {"board.cdl": text}) as generated:
            made.append(files(generated))
    assert made[1] - made[0] == {
        f"mine/tecs/board/{name}"
        for name in (
            *("Lamp.idl", "Lamp.RTC.xml", "OpaqueRpcCommunication1.conf"),
            *("lamp_codec.py", "lamp_marshaller.py", "lamp_server.py"),
        )
    }


def lines(generated: Path) -> int:
    """Return the number of lines of all files, with the user's skeletons."""
    project = generated.parent
    trees = (generated, project / "mine_nodes")
    found = (path for tree in trees for path in tree.rglob("*") if path.is_file())
    return sum(path.read_bytes().count(b"\n") for path in found)


def test_the_lines_for_two_structs_an_interface_and_a_component(
    tmp_path: Path,
) -> None:
    with project(tmp_path, {"arm.idl": IDL}) as generated:
        assert lines(generated) < 350


def gripper() -> str:
    """Return an EDS of five objects, two PDOs, and what CiA 301 requires."""
    sections = {
        "DeviceInfo": ["VendorNumber=0x1", "ProductNumber=0x2", "NrOfRXPDO=1"],
        "MandatoryObjects": numbered(0x1000, 0x1001, 0x1018),
        "OptionalObjects": numbered(0x1400, 0x1600, 0x1800, 0x1A00),
        "ManufacturerObjects": numbered(*range(0x2000, 0x2005)),
        "1000": variable("Device type", 7, "ro"),
        "1001": variable("Error register", 5, "ro"),
        "1018": record("Identity", 2),
        "1018sub0": variable("Highest", 5, "ro", "1"),
        "1018sub1": variable("Vendor", 7, "ro", "0x1"),
    }
    for index, cob_id, mapped in ((0x1400, 0x200, 0x2000), (0x1800, 0x180, 0x2001)):
        name, mapping = f"{index:X}", f"{index + 0x200:X}"
        sections |= {
            name: record("Communication", 3),
            f"{name}sub0": variable("Highest", 5, "ro", "2"),
            f"{name}sub1": variable("COB-ID", 7, "rw", f"$NODEID+0x{cob_id:X}"),
            f"{name}sub2": variable("Transmission", 5, "rw", "255"),
            mapping: record("Mapping", 2),
            f"{mapping}sub0": variable("Number", 5, "rw", "1"),
            f"{mapping}sub1": variable("First", 7, "rw", f"0x{mapped:X}0010"),
        }
    accesses = ("rww", "ro", "rw", "rw", "ro")
    for place, access in enumerate(accesses, 0x2000):
        mappable = [f"PDOMapping={int(place < 0x2002)}"]
        sections[f"{place:X}"] = variable(f"Value {place:X}", 3, access) + mappable
    return "".join(f"[{n}]\n" + "\n".join(s) + "\n\n" for n, s in sections.items())


def numbered(*indices: int) -> list[str]:
    entries = (f"{n}=0x{index:X}" for n, index in enumerate(indices, 1))
    return [f"SupportedObjects={len(indices)}", *entries]


def record(name: str, subs: int) -> list[str]:
    return [f"ParameterName={name}", "ObjectType=0x9", f"SubNumber={subs}"]


def variable(name: str, type_: int, access: str, default: str = "0") -> list[str]:
    facts = f"ParameterName={name}", f"DataType=0x{type_:04X}", f"AccessType={access}"
    return [*facts, f"DefaultValue={default}"]


def test_the_lines_for_an_eds_of_five_objects_and_two_pdos(tmp_path: Path) -> None:
    with project(tmp_path, {"gripper.eds": gripper()}) as generated:
        assert lines(generated) <= 700
