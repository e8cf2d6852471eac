"""rtgen.toml: search, checks, and folders."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.project import Project, load, require_sources, with_arguments
from rtgen.compiler.project.file import SCHEMA

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "idl" / "deep").mkdir(parents=True)
    for name in (
        "idl/b.idl",
        "idl/a.IDL",
        "idl/deep/c.idl",
        "idl/notes.txt",
        "idl/.hidden.idl",
    ):
        (tmp_path / name).write_text("")


def written(text: str) -> Project:
    Path("rtgen.toml").write_text(text)
    return load()


def findings(text: str | bytes) -> list[Diagnostic]:
    Path("rtgen.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as error:
        load()
    return list(error.value.diagnostics)


@pytest.mark.parametrize("define", ['["B=1", "A=x", "C"]', '{B = 1, A = "x", C = "1"}'])
def test_macros_are_a_list_as_on_the_command_line_or_a_table(define: str) -> None:
    project = written(f"[sources]\ndefine = {define}\n")
    assert project.define == (("A", "x"), ("B", "1"), ("C", "1"))


def test_without_a_file_there_are_defaults(tmp_path: Path) -> None:
    project = load()
    assert (project.root, project.package, project.skeleton_package) == (
        tmp_path,
        "robots",
        "",
    )
    assert project.output == tmp_path / "generated"
    assert project.import_folders == (tmp_path / "generated", tmp_path / "src")
    with pytest.raises(InputError) as error:
        require_sources(project)
    assert error.value.diagnostics[0].code == "PRJ0007"


def test_a_whole_file(tmp_path: Path) -> None:
    project = written(
        '[sources]\npaths = ["idl"]\ninclude = ["idl/deep"]\ndefine = {B = 1, A = "x"}\n'
        '[output]\ndir = "out"\nskeletons = "src/mine"\npackage = "bots"\ntarget = "embedded"\n'
        '[components]\nDrive = "mine.drive:Drive"\n[adapter.Speed]\n'
        'from = "A"\nto = "M::B"\nmap = {"data.v" = "v"}\n'
        '[lint]\nignore = ["X"]\n'
    )
    assert [p.as_posix() for p in project.sources] == [
        "idl/a.IDL",
        "idl/b.idl",
        "idl/deep/c.idl",
    ]
    assert project.include == (Path("idl/deep"),)
    [adapter] = project.adapters
    assert (adapter.name, adapter.source, adapter.target) == ("Speed", "A", "M::B")
    assert adapter.mapping == (("data.v", "v"),)
    assert adapter.span.line == 12
    alone = with_arguments(project, paths=["idl/a.IDL"])
    assert alone.adapters == ()
    assert with_arguments(project, paths=["idl/a.IDL"], add=True).adapters == (adapter,)
    assert project.define == (("A", "x"), ("B", "1"))
    assert project.import_folders == (tmp_path / "out", tmp_path / "src")
    assert project.skeleton_package == "mine"
    assert project.components == (("Drive", "mine.drive:Drive"),)


def test_the_file_is_found_upwards_and_paths_are_shown_from_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["idl/deep", "idl/b.idl", "idl/b.idl"]\n'
    )
    monkeypatch.chdir(tmp_path / "idl")
    project = load()
    assert project.root == tmp_path
    assert [p.as_posix() for p in project.sources] == ["deep/c.idl", "b.idl"]


@pytest.mark.parametrize(
    ("text", "code", "line", "column", "message"),
    [
        ("[sources\n", "PRJ0001", 1, 9, "Expected"),
        ("a = 'x", "PRJ0001", 1, 7, "Expected"),
        ("a = " + "[" * 20000, "PRJ0001", 1, 1, "deeply"),
        ("a = " + "1" * 20000, "PRJ0001", 1, 1, "number is too long"),
        ("\n[ouput]\n", "PRJ0002", 2, 2, "ouput"),
        ("sorces = 1\n", "PRJ0002", 1, 1, "sorces"),
        ('[output]\n  pakage = "x"\n', "PRJ0002", 2, 3, "pakage"),
        ("sources = 1\n", "PRJ0003", 1, 1, "section"),
        ('[sources]\npaths = "idl"\n', "PRJ0003", 2, 1, "list"),
        ("[sources]\ndefine = [1]\n", "PRJ0003", 2, 1, "table"),
        ("[sources.define]\n1x = 1\n", "PRJ0003", 1, 2, "1x"),
        ('[output]\ntarget = "ros"\n', "PRJ0003", 2, 1, "embedded"),
        ('[output]\nrepresentation = "xcdr"\n', "PRJ0003", 2, 1, "xcdr2"),
        ("[output]\nextensibility = 1\n", "PRJ0003", 2, 1, "appendable"),
        ('[components]\nA = "no factory"\n', "PRJ0003", 2, 1, "module:attribute"),
        ('[components]\nA = "a.b:C\\nD = x:y"\n', "PRJ0003", 2, 1, "module:attribute"),
        ('[components]\nA = "a.class:if"\n', "PRJ0003", 2, 1, "module:attribute"),
        ('[components]\nA = "a:\u00b2"\n', "PRJ0003", 2, 1, "module:attribute"),
        ('[output]\npackage = "my-bots"\n', "PRJ0004", 2, 1, "identifier"),
        ('[output]\npackage = "class"\n', "PRJ0004", 2, 1, "identifier"),
        ('[output]\npackage = "generated"\n', "PRJ0004", 2, 1, "hide"),
        ('[output]\npackage = "RTC"\n', "PRJ0004", 2, 1, "hide"),
        ('[output]\npackage = "json"\n', "PRJ0004", 2, 1, "hide"),
        ('[output]\npackage = "acme.con"\n', "PRJ0004", 2, 1, "device"),
        ('[output]\npackage = "a"\nskeletons = "src/a"\n', "PRJ0004", 3, 1, "both"),
        ('[output]\nskeletons = "src/1a"\n', "PRJ0004", 2, 1, "identifier"),
        ('[sources]\npaths = ["idl",\n  "gone"]\n', "PRJ0005", 3, 3, "gone"),
        ('[sources]\ninclude = ["gone"]\n', "PRJ0005", 2, 12, "gone"),
        ('[output]\ndir = "."\n', "PRJ0006", 2, 1, "below"),
        ('[output]\ndir = "../other"\n', "PRJ0006", 2, 1, "below"),
        ('[output]\nskeletons = "/tmp/x"\n', "PRJ0006", 2, 1, "below"),
        (
            '[sources]\npaths = ["idl/deep"]\n[output]\ndir = "idl"\n',
            "PRJ0006",
            4,
            1,
            "holds",
        ),
        ('[output]\ndir = "src"\nskeletons = "src/a"\n', "PRJ0006", 2, 1, "holds"),
    ],
)
def test_what_is_wrong_has_its_code_and_place(
    text: str | bytes, code: str, line: int, column: int, message: str
) -> None:
    found = findings(text)[0]
    assert found.code == code
    assert found.span is not None
    assert (found.span.file, found.span.line, found.span.column) == (
        "rtgen.toml",
        line,
        column,
    )
    assert message in found.message


def test_all_mistakes_are_reported_at_once() -> None:
    found = findings('[output]\npakage = "x"\ndir = 3\n[lnt]\n')
    assert [d.code for d in found] == ["PRJ0002", "PRJ0003", "PRJ0002"]
    assert [d.hint for d in found] == [
        "did you mean 'package'?",
        "`rtgen explain PRJ0003` and docs/project.md show values of each kind",
        "did you mean 'lint'?",
    ]


def test_other_folders_on_the_command_line(tmp_path: Path) -> None:
    project = written('[output]\nskeletons = "src/mine"\n')
    moved = with_arguments(project, output="there", paths=["idl/deep"], include=["inc"])
    assert moved.base == tmp_path / "there"
    assert moved.output == tmp_path / "there" / "generated"
    assert moved.skeletons == tmp_path / "there" / "src" / "mine"
    assert moved.sources == (Path("idl/deep/c.idl"),)
    assert moved.include == (Path("inc"),)
    plain = with_arguments(written(""), output="there")
    assert plain.skeletons == tmp_path / "there" / "src"


def test_a_definition_on_the_command_line_wins() -> None:
    project = written('[sources]\ndefine = {A = "1", B = "2"}\n')
    changed = with_arguments(project, define=[("A", "3")])
    assert changed.define == (("A", "3"), ("B", "2"))


def test_paths_of_other_kinds_are_refused() -> None:
    with pytest.raises(InputError) as error:
        with_arguments(load(), paths=["idl/notes.txt", "idl/b.idl", "x.cpp"])
    assert [d.code for d in error.value.diagnostics] == ["PRJ0008", "PRJ0008"]


def test_xml_that_is_no_profile_is_refused_with_the_forms_that_are_read(
    tmp_path: Path,
) -> None:
    (tmp_path / "s.xml").write_text("<x/>")
    with pytest.raises(InputError) as error:
        with_arguments(load(), paths=[str(tmp_path / "s.xml")])
    (finding,) = error.value.diagnostics
    assert finding.code == "PRJ0008"
    assert "RtcProfile or RtsProfile is its root element" in str(finding.hint)


def test_the_output_folder_is_not_searched_for_sources(tmp_path: Path) -> None:
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "x.idl").write_text("")
    assert [p.name for p in with_arguments(load(), paths=["."]).sources] == [
        "a.IDL",
        "b.idl",
        "c.idl",
    ]


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_folders_that_link_to_themselves_are_read_once(tmp_path: Path) -> None:
    (tmp_path / "idl" / "loop").symlink_to(tmp_path / "idl")
    assert len(with_arguments(load(), paths=["idl"]).sources) == 3


def test_paths_beside_those_of_the_project() -> None:
    project = written("[sources]\npaths = ['idl/deep']\n")
    alone = [p.name for p in with_arguments(project, paths=["idl/b.idl"]).sources]
    beside = with_arguments(project, paths=["idl/b.idl", "idl/deep"], add=True)
    assert alone == ["b.idl"]
    assert [p.name for p in beside.sources] == [
        *(p.name for p in project.sources),
        "b.idl",
    ]


def test_systems_alone_are_read_with_the_definitions_of_the_project() -> None:
    project = written("[sources]\npaths = ['idl/deep']\n")
    Path("idl/s.xml").write_text(
        '<r:RtsProfile xmlns:r="http://www.openrtp.org/namespaces/rts"/>'
    )
    asked = with_arguments(project, paths=["idl/s.xml"], target="openrtm")
    assert asked.sources == project.sources
    assert [p.name for p in asked.systems] == ["s.xml"]
    both = with_arguments(project, paths=["idl/s.xml", "idl/b.idl"], target="openrtm")
    assert [p.name for p in both.sources] == ["b.idl"]


def test_ignore_case_clashes_is_a_boolean() -> None:
    assert not written("").ignore_case_clashes
    assert written("[sources]\nignore_case_clashes = true\n").ignore_case_clashes
    (wrong,) = findings('[sources]\nignore_case_clashes = "yes"\n')
    assert "true or false" in wrong.message


@pytest.mark.parametrize("older", ["", "[sources]\nignore_case_clashes = true\n"])
def test_the_case_of_names_is_strict_or_that_of_dds(older: str) -> None:
    assert written(f'{older}[idl]\ncase = "dds"\n').ignore_case_clashes
    assert not written(f'{older}[idl]\ncase = "strict"\n').ignore_case_clashes
    (wrong,) = findings('[idl]\ncase = "DDS"\n')
    assert "must be one of 'strict', 'dds'" in wrong.message


def test_the_documentation_lists_each_section_and_key() -> None:
    page = (ROOT / "docs" / "project.md").read_text()
    table = page.partition("## rtgen.toml")[2].partition("\n## ")[0]
    rows = [line.split("|")[1:3] for line in table.splitlines() if line[:1] == "|"]
    listed: dict[str, set[str]] = {}
    section = ""
    for first, keys in rows[2:]:
        section = first.strip(" `[]").partition(".")[0] or section
        listed.setdefault(section, set()).update(re.findall(r"`([^`]+)`", keys))
    assert listed.keys() == SCHEMA.keys()
    for name, known in SCHEMA.items():
        if isinstance(known, dict):
            assert listed[name] == known.keys()
