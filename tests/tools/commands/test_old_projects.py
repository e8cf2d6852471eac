"""Projects of OpenRTM as they are found: what `rtgen convert` writes is read at the first try."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

ROOT = Path(__file__).parents[3]
SYSTEM = ROOT / "specs" / "navigation" / "rh3_path.xml"
LOAD = "module Yard { struct Load { RTC::Time tm; long mass; }; };\n"
COPY = """\
#ifndef BasicDataType_idl
#define BasicDataType_idl
module RTC {
    struct Time { unsigned long sec; unsigned long nsec; };
    struct TimedLong { Time tm; long data; };
};
#endif
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A component whose type is in a folder `idl`, with a copy of a file of OpenRTM."""
    (tmp_path / "idl").mkdir()
    (tmp_path / "idl/BasicDataType.idl").write_text(COPY)
    (tmp_path / "idl/Yard.idl").write_text(f'#include "BasicDataType.idl"\n{LOAD}')
    (tmp_path / "Crane.idl").write_text(
        '#include "Yard.idl"\n#include "ExtendedDataTypes.idl"\n'
        "component Crane { publishes Yard::Load load; publishes RTC::TimedLong number;\n"
        "    publishes RTC::TimedPose2D pose; };\n"
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


def printed(capfd: pytest.CaptureFixture[str], *words: str) -> str:
    assert run([*words]) == 0, capfd.readouterr().err
    return capfd.readouterr().out


def test_the_form_by_default_is_the_other_one(
    capfd: pytest.CaptureFixture[str],
) -> None:
    profile = printed(capfd, "convert", "Crane.idl")
    assert profile == printed(capfd, "convert", "Crane.idl", "--to", "rtc-xml")
    Path("RTC.xml").write_text(profile)
    idl = printed(capfd, "convert", "RTC.xml")
    assert idl == printed(capfd, "convert", "RTC.xml", "--to", "idl")
    assert "component Crane" in idl
    text = printed(capfd, "convert", str(SYSTEM))
    assert text.startswith("rtsProfile:")
    Path("system.yaml").write_text(text)
    assert printed(capfd, "convert", "system.yaml").startswith("<?xml")


@pytest.mark.parametrize("converted", ["Crane.idl", "RTC.xml"])
def test_a_folder_idl_and_a_copy_of_openrtms_file(
    converted: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("RTC.xml").write_text(printed(capfd, "convert", "Crane.idl"))
    assert run(["generate", converted, "-o", "made", "--target", "openrtm", "-q"]) == 0
    assert capfd.readouterr().err == ""
    assert Path("made/generated/openrtm/Crane/Crane.py").is_file()


def test_the_folder_of_the_includes_is_named(capfd: pytest.CaptureFixture[str]) -> None:
    Path("RTC.xml").write_text(printed(capfd, "convert", "Crane.idl"))
    Path("Crane.idl").unlink()
    assert run(["convert", "RTC.xml", "-o", "."]) == 0
    assert capfd.readouterr().err == "Crane.idl written\n"
    assert run(["convert", "RTC.xml", "-o", "new"]) == 0
    assert capfd.readouterr().err == (
        "new/Crane.idl written\n"
        "to generate from it, name the folder of its includes: -I idl\n"
    )
    assert run(["generate", "new/Crane.idl", "-o", "made", "-q"]) == 2
    assert "IDL0010" in capfd.readouterr().err
    assert run(["generate", "new/Crane.idl", "-I", "idl", "-o", "made", "-q"]) == 0
    Path("old files").mkdir()
    Path("idl").rename("old files/idl")
    Path("RTC.xml").rename("old files/RTC.xml")
    assert run(["convert", "old files/RTC.xml", "-o", "newer"]) == 0
    assert capfd.readouterr().err.endswith(": -I 'old files/idl'\n")
