"""IDL files that OpenRTM installs are found where the generated `idlcompile.sh` finds them."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.library import shipped
from rtgen.compiler.frontends.idl.text.installed import installed_folder
from rtgen.compiler.kit.resources import idl_source

CAMERA = """\
#include "BasicDataType.idl"
#include "Beside.idl"
module Img {{ struct {name} {{ RTC::Time tm; Beside::Part part; }}; }};
"""


def folder_with(place: Path, name: str) -> Path:
    """Return a folder as OpenRTM has it, whose struct has a name."""
    place.mkdir(parents=True)
    # OpenRTM's own copy: other text, the same types, and one of its own.
    stock = idl_source("BasicDataType.idl")
    (place / "BasicDataType.idl").write_text(f"// a copy\n{stock}")
    (place / "CameraCommonInterface.idl").write_text(CAMERA.format(name=name))
    (place / "Beside.idl").write_text("module Beside { struct Part { long x; }; };\n")
    return place


def script(place: Path, name: str, folder: Path, code: int = 0) -> None:
    place.mkdir(exist_ok=True)
    program = place / name
    program.write_text(
        f'#!/bin/sh\n[ "$*" = "--rtm-idldir" ] && echo "{folder}"\nexit {code}\n'
    )
    program.chmod(0o755)


def by_variable(top: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setenv("RTM_IDL", str(folder_with(top / "variable", "Variable")))


def by_script(top: Path, patch: pytest.MonkeyPatch) -> None:
    script(top / "bin", "rtm2-config", folder_with(top / "two", "Script"))
    patch.setenv("PATH", str(top / "bin"))


def by_old_script(top: Path, patch: pytest.MonkeyPatch) -> None:
    script(top / "bin", "rtm-config", folder_with(top / "one", "OldScript"))
    patch.setenv("PATH", str(top / "bin"))


def by_package(top: Path, patch: pytest.MonkeyPatch) -> None:
    package = top / "site" / "OpenRTM_aist"
    folder_with(package / "RTM_IDL", "Package")
    (package / "__init__.py").write_text("raise AssertionError('it is imported')\n")
    patch.setattr(sys, "path", [str(top / "site"), *sys.path])


def by_root(top: Path, patch: pytest.MonkeyPatch) -> None:
    folder_with(top / "root" / "rtm" / "idl", "Root")
    patch.setenv("RTM_ROOT", str(top / "root"))


WAYS: list[tuple[str, Callable[[Path, pytest.MonkeyPatch], None]]] = [
    ("Variable", by_variable),
    ("Script", by_script),
    ("OldScript", by_old_script),
    ("Package", by_package),
    ("Root", by_root),
]
"""In the order of the script."""


@pytest.fixture(autouse=True)
def nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """OpenRTM is not installed."""
    from rtgen.compiler.frontends.idl.text import installed

    installed._folder.cache_clear()
    for name in ("RTM_IDL", "RTM_ROOT"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delitem(sys.modules, "OpenRTM_aist", raising=False)


def names_in(folder: Path, include: str = "CameraCommonInterface.idl") -> list[str]:
    """Return the names of the structs of an IDL file that includes one of OpenRTM."""
    folder.mkdir(exist_ok=True)
    file = folder / "mine.idl"
    file.write_text(f'#include "{include}"\n')
    found = load([file], root=folder)
    assert not found.diagnostics, found.diagnostics
    return [
        each.scoped
        for each in found.model.declarations
        if each.scoped.startswith(("Img", "Beside"))
    ]


@pytest.mark.parametrize(("name", "install"), WAYS)
def test_each_way_leads_to_the_folder(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    install: Callable[[Path, pytest.MonkeyPatch], None],
) -> None:
    install(tmp_path, monkeypatch)
    assert names_in(tmp_path / "project") == ["Beside::Part", f"Img::{name}"]


@pytest.mark.parametrize("first", range(len(WAYS)))
def test_the_first_way_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, first: int
) -> None:
    for _, install in WAYS[first:]:
        install(tmp_path, monkeypatch)
    assert names_in(tmp_path / "project")[-1] == f"Img::{WAYS[first][0]}"


def test_a_folder_without_the_stock_files_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTM_IDL", str(tmp_path))
    by_root(tmp_path, monkeypatch)
    assert installed_folder() == tmp_path / "root" / "rtm" / "idl"


@pytest.mark.parametrize("code", [0, 1])
def test_a_script_that_fails_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    there = folder_with(tmp_path / "two", "Script")
    folder = there if code else Path(f"{there}\nmore")
    script(tmp_path / "bin", "rtm2-config", folder, code)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    assert installed_folder() is None


def test_files_of_the_project_come_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_variable(tmp_path, monkeypatch)
    project = tmp_path / "project"
    project.mkdir()
    own = project / "CameraCommonInterface.idl"
    own.write_text("module Img { struct Mine { long x; }; };\n")
    assert names_in(project) == ["Img::Mine"]


def test_types_of_openrtm_remain_those_of_rtgen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_variable(tmp_path, monkeypatch)
    names_in(tmp_path / "project")
    file = tmp_path / "project" / "mine.idl"
    found = load([file], root=file.parent, virtual=shipped([file], ()))
    keys = {each.key for each in found.model.files}
    assert keys == {
        *("mine.idl", "CameraCommonInterface.idl", "Beside.idl"),
        "rtgen/idl/BasicDataType.idl",
    }


def test_a_missing_file_of_openrtm_is_named_so(tmp_path: Path) -> None:
    file = tmp_path / "mine.idl"
    file.write_text('#include "CameraCommonInterface.idl"\n')
    [finding] = load([file], root=tmp_path).diagnostics
    assert finding.code == "IDL0010"
    assert finding.hint == (
        "OpenRTM installs it; its folder of IDL files is asked of RTM_IDL, rtm2-config, "
        "rtm-config, OpenRTM_aist, RTM_ROOT"
    )


def test_no_path_leads_out_of_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_variable(tmp_path, monkeypatch)
    (tmp_path / "secret.idl").write_text("struct Secret { long x; };\n")
    file = tmp_path / "project.idl"
    file.write_text('#include "../variable/../secret.idl"\n')
    found = load([file], root=tmp_path)
    assert [each.code for each in found.diagnostics] == ["IDL0010"]
