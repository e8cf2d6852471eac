"""A file that is reached by several paths, some of them through links, is one file."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.frontends import cdl, idl
from rtgen.ros2.rosidl import pipeline as rosidl

TYPES = "module M { struct T { long x; }; const long N = 3; interface I {}; };\n"


@pytest.fixture
def linked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a file, a link to it, and a link to its folder."""
    (tmp_path / "common").mkdir()
    (tmp_path / "idl").mkdir()
    (tmp_path / "common/types.idl").write_text(TYPES)
    (tmp_path / "idl/types.idl").symlink_to("../common/types.idl")
    (tmp_path / "other").symlink_to("common")
    monkeypatch.chdir(tmp_path)
    return tmp_path


PATHS = ["types.idl", "../common/types.idl", "../other/types.idl"]


@pytest.mark.parametrize("paths", list(permutations(PATHS, 2)))
def test_included_by_two_paths(paths: tuple[str, str], linked: Path) -> None:
    includes = "".join(f'#include "{path}"\n' for path in paths)
    main = linked / "idl/a.idl"
    main.write_text(f"{includes}module M {{ struct U {{ T inner; }}; }};\n")
    result = idl.load([main], root=linked)
    assert [d.code for d in result.diagnostics] == ["IDL0024"]
    assert [d.name for d in result.model.declarations] == [
        *(("M", "T"), ("M", "N"), ("M", "I"), ("M", "U")),
    ]
    assert {Path(d.file).name for d in result.model.declarations} == {
        *("types.idl", "a.idl"),
    }


@pytest.mark.parametrize(
    "given", list(permutations(["idl/types.idl", "common/types.idl"]))
)
def test_given_twice_and_included(given: tuple[str, str], linked: Path) -> None:
    """The name of the file is that of the first path given."""
    Path("a.idl").write_text('#include "other/types.idl"\nstruct U { M::T inner; };\n')
    mains = [Path("a.idl"), *map(Path, given)]
    result = idl.load(mains, root=linked)
    assert result.diagnostics == ()
    assert [d.file for d in result.model.declarations] == [given[0]] * 3 + ["a.idl"]
    assert {f.name for f in result.model.files if f.main} == {"a.idl", given[0]}


def test_a_link_that_leads_elsewhere_later(linked: Path) -> None:
    """The result of a run is stored by the contents at all paths."""
    Path("rtgen.toml").write_text('[sources]\npaths = ["idl", "common"]\n')
    Path("idl/a.idl").write_text('#include "types.idl"\nstruct U { M::T inner; };\n')
    assert run(["generate", "-q"]) == 0
    before = Path("generated/robots/_idl/a.py").read_text()
    Path("idl/types.idl").unlink()
    Path("idl/types.idl").write_text(TYPES.replace("M", "Other"))
    assert run(["generate"]) == 2
    Path("idl/types.idl").unlink()
    Path("idl/types.idl").symlink_to("../common/types.idl")
    assert run(["generate", "-q"]) == 0
    assert Path("generated/robots/_idl/a.py").read_text() == before


def test_imports_of_cdl(linked: Path) -> None:
    Path("s.cdl").write_text("signature sMove { void f( void ); };\n")
    Path("link.cdl").symlink_to("s.cdl")
    Path("a.cdl").write_text(
        'import( "s.cdl" ); import( "link.cdl" );\ncelltype t { entry sMove e; };\n'
    )
    result = cdl.load([Path("a.cdl")], root=linked)
    assert result.diagnostics == ()


def test_two_boards_of_one_cdl_file(linked: Path) -> None:
    """A link is a main file of its own: its name is that of the package."""
    Path("left.cdl").write_text("signature sMove { void f( void ); };\n")
    Path("right.cdl").symlink_to("left.cdl")
    result = cdl.load([Path("left.cdl"), Path("right.cdl")], root=linked)
    assert [unit.file for unit in result.model.tecs] == ["left.cdl", "right.cdl"]


def test_interface_files_of_ros(linked: Path) -> None:
    (linked / "pkg/msg").mkdir(parents=True)
    Path("pkg/msg/A.msg").write_text("int32 x\n")
    Path("pkg/package.xml").write_text("<package><name>pkg</name></package>\n")
    Path("again").symlink_to("pkg")
    paths = [Path("pkg/msg/A.msg"), Path("again/msg/A.msg")]
    result = rosidl.load(paths, root=linked)
    assert [d.name for d in result.model.declarations] == [("pkg", "msg", "A")]
