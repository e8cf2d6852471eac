"""The number of files that rtgen writes for one function of CDL, and for one EDS."""

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
