"""Findings that are about others: deviations of vendors' files, and what follows from errors."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rtgen.cli import run

EDS = """\
[FileInfo]
FileName=drive.eds
[DeviceInfo]
[MandatoryObjects]
SupportedObjects=1
1=0x1000
[1000]
ParameterName=Device type
DataType=0x0007
AccessType=ro
{rest}
"""
ODD = "".join(f"[Maker{number}]\nKey=1\n" for number in range(40))
BUS = """\
[bus]
bit_rate = 500

[device.drive]
eds = "files/drive.eds"

[node.left]
device = "drive"
id = 1
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "drive.eds").write_text(EDS.format(rest=ODD))
    (tmp_path / "bus.toml").write_text(BUS)
    (tmp_path / "rtgen.toml").write_text('[sources]\npaths = ["bus.toml", "a.idl"]\n')
    (tmp_path / "a.idl").write_text(
        '#include "Drive.idl"\n#include "CanopenManager.idl"\nstruct S { long x; };\n'
    )
    return tmp_path


@pytest.mark.sampled(1)
@pytest.mark.parametrize("command", [["generate"], ["check"], ["generate", "--diff"]])
def test_deviations_of_a_description_are_one_line(
    command: list[str], project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    if command == ["check"]:
        run(["generate", "-q"])
        capfd.readouterr()
    run(command)
    err = capfd.readouterr().err
    lines = [line for line in err.splitlines() if line.startswith("files/drive.eds")]
    assert len(lines) == 1, err
    assert "deviations are tolerated; rtgen lint shows them" in lines[0]
    number = int(lines[0].split(": ")[1].split()[0])
    run(["lint"])
    shown = capfd.readouterr().err
    assert shown.count("drive.eds:") == number
    run([*command, "--diagnostics", "json"])
    text = capfd.readouterr().err
    found = [d for d in json.loads(text) if d["file"] == "files/drive.eds"]
    assert len(found) == number


def test_few_deviations_are_printed(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    eds = project / "files" / "drive.eds"
    for number in range(40):
        eds.write_text(EDS.format(rest="".join(ODD.splitlines(True)[: 2 * number])))
        run(["generate"])
        err = capfd.readouterr().err
        if "deviations are tolerated" in err:
            break
        assert err.count("drive.eds:") > number
    assert "deviations are tolerated" in err


LOST = """\
[ManufacturerObjects]
SupportedObjects=1
1=0x2000
[2OOO]
ParameterName=Speed
DataType=0x0003
AccessType=rw
"""


def test_an_object_that_is_lost_is_not_folded(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (project / "a.idl").write_text("struct S { long x; };\n")
    (project / "files" / "drive.eds").write_text(EDS.format(rest=LOST + ODD))
    assert run(["generate"]) == 0
    err = capfd.readouterr().err
    assert "[2OOO] is not a section of CiA 306" in err
    assert "did you mean [2000]?" in err
    assert "further deviations are tolerated" in err
    assert run(["check"]) == 1
    assert "did you mean [2000]?" in capfd.readouterr().err
    (project / "files" / "drive.eds").write_text(EDS.format(rest=ODD))
    assert run(["generate"]) == 0
    assert run(["check"]) == 0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("bit_rate = 500", "bit_rate = "),
        ("bit_rate = 500", "bit_rate = 499"),
        ("[bus]", "[bus]\nwidth = 1"),
        ("id = 1", "id = 128"),
        ('device = "drive"', 'device = "driver"'),
        ("files/drive.eds", "files/driver.eds"),
        ("[node.left]", "[node.left"),
    ],
)
def test_an_error_of_a_bus_file_is_the_only_one(
    old: str, new: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (project / "bus.toml").write_text(BUS.replace(old, new))
    assert run(["check"]) == 2
    err = capfd.readouterr().err
    assert err.count(": error[EDS") == 1
    assert "IDL" not in err


def test_an_include_that_is_missing_in_itself_is_reported(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (project / "a.idl").write_text('#include "Driver.idl"\n')
    assert run(["check"]) == 2
    assert "error[IDL0010]" in capfd.readouterr().err
