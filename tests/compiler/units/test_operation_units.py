"""Units of operations' parameters, of IDL and of TECS functions, in the generated text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.model import Interface

CDL = """
/** A wheel. */
signature sWheel {
    /** Turns the wheel. */
    ER turn( [in] double64_t speed, /**< Speed [rad/s] */
             /** Angle, "as measured" [rad] */
             [out] double64_t *angle );
    ER stop( [in] int32_t ramp );
};
celltype tWheel { entry sWheel eWheel; };
[active]
celltype tSwitch { call sWheel cWheel; };
cell tWheel Wheel { };
cell tSwitch Switch {
    [through( RTCPlugin, "" )]
    cWheel = Wheel.eWheel;
};
"""
IDL = """interface Wheel {
    void turn(@unit("{unit}") in double speed, in double force /**< Limit [N] */);
};"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "rtgen.toml").write_text('[sources]\npaths = ["definitions"]\n')
    (tmp_path / "definitions").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_units_of_a_board_are_in_idl_and_python(folder: Path) -> None:
    (folder / "definitions/wheel.cdl").write_text(CDL)
    assert run(["generate"]) == 0
    (idl,) = folder.glob("generated/**/Wheel.idl")
    declared = load([idl], root=idl.parent).model.declarations
    (wheel,) = (d for d in declared if isinstance(d, Interface))
    operations = {o.name: o for o in wheel.operations}
    docs = [p.doc for p in operations["turn"].parameters]
    assert docs == ["Speed [rad/s]", 'Angle, "as measured" [rad]']
    assert [p.doc for p in operations["stop"].parameters] == [""]
    (marshaller,) = folder.glob("generated/**/wheel_marshaller.py")
    shown = re.sub(r"\s+", " ", marshaller.read_text())
    assert (
        '"""Turns the wheel. speed: Speed [rad/s] angle: Angle, "as measured" [rad] """'
        in shown
    )


@pytest.mark.parametrize(("unit", "findings"), [("rad/s", 0), ("radiants", 1)])
def test_units_of_idl_are_in_python_and_linted(
    folder: Path, capsys: pytest.CaptureFixture[str], unit: str, findings: int
) -> None:
    (folder / "definitions/wheel.idl").write_text(IDL.replace("{unit}", unit))
    assert run(["generate"]) == 0
    (made,) = folder.glob("generated/**/_idl/wheel.py")
    assert f"speed: [{unit}]\n        force: Limit [N]\n" in made.read_text()
    capsys.readouterr()
    run(["lint"])
    assert capsys.readouterr().err.count("LINT002") == findings
