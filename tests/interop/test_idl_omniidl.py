"""The IDL front end reads what omniidl reads: declarations, repository ids, constants, types."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rtgen.diagnostics import has_errors
from rtgen.frontends.idl import load
from rtgen.model import (
    Const,
    ConstantValue,
    Declaration,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Interface,
    Native,
    Struct,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)

ROOT = Path(__file__).parents[2]
BACKEND = Path(__file__).with_name("omniidl_backend")
OMNIIDL = shutil.which(
    "omniidl", path=str(Path(sys.executable).parent)
) or shutil.which("omniidl")
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("specs/idl", "tests/golden/idl")
    for path in (ROOT / folder).glob("*.idl")
    if "component" not in path.stem and "idl4" not in path.stem
)

pytestmark = pytest.mark.skipif(
    OMNIIDL is None, reason="omniidl (jeteve-omniorb) is missing"
)


def by_omniidl(path: str) -> list[dict[str, object]]:
    command = [
        str(OMNIIDL),
        "-p",
        str(BACKEND),
        "-b",
        "rtgen_facts",
        "-Ispecs/idl",
        path,
    ]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    facts: list[dict[str, object]] = json.loads(run.stdout)
    return facts


def scoped(name: tuple[str, ...]) -> str:
    return "::".join(name)


def value(found: ConstantValue) -> object:
    match found:
        case EnumeratorName(name):
            return scoped(name)
        case bool() | int() | float() | str():
            return found
    return str(found)


def facts(declaration: Declaration) -> dict[str, object]:
    common = {"name": declaration.scoped, "id": declaration.repository_id}
    match declaration:
        case Struct(members=members) | ExceptionDecl(members=members):
            kind = "struct" if isinstance(declaration, Struct) else "exception"
            return {
                "kind": kind,
                **common,
                "members": [[m.name, str(m.type)] for m in members],
            }
        case Union():
            cases = []
            for case in declaration.cases:
                labels = [str(value(label)) for label in case.labels]
                labels += ["default"] * case.default
                cases.append([sorted(labels), case.name, str(case.type)])
            return {
                "kind": "union",
                **common,
                "switch": str(declaration.switch),
                "cases": cases,
            }
        case Enum():
            names = [member.name for member in declaration.members]
            return {"kind": "enum", **common, "members": names}
        case Typedef():
            return {"kind": "typedef", **common, "type": str(declaration.type)}
        case Const():
            found = value(declaration.value)
            return {
                "kind": "const",
                **common,
                "type": str(declaration.type),
                "value": found,
            }
        case Native():
            return {"kind": "native", **common}
        case Interface():
            return {
                "kind": "interface",
                **common,
                "bases": [scoped(base) for base in declaration.bases],
                "abstract": declaration.abstract,
                "local": declaration.local,
                "operations": [
                    [
                        operation.name,
                        operation.repository_id,
                        operation.oneway,
                        str(operation.returns),
                        [
                            [str(p.direction), p.name, str(p.type)]
                            for p in operation.parameters
                        ],
                        [scoped(name) for name in operation.raises],
                        list(operation.context),
                    ]
                    for operation in declaration.operations
                ],
                "attributes": [
                    [a.name, str(a.type), a.readonly] for a in declaration.attributes
                ],
            }
        case Valuetype():
            return {
                "kind": "valuetype",
                **common,
                "bases": [scoped(base) for base in declaration.bases],
                "state": [
                    [member.name, str(member.type)] for member in declaration.state
                ],
            }
        case ValueBox():
            return {"kind": "valuebox", **common, "type": str(declaration.type)}
    raise AssertionError(f"unexpected {declaration}")


def by_name(found: list[dict[str, object]]) -> dict[object, dict[str, object]]:
    return {fact["name"]: fact for fact in found}


@pytest.mark.parametrize("path", FILES)
def test_same_declarations(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    result = load([Path(path)], root=ROOT, include=[Path("specs/idl")])
    assert not has_errors(result.diagnostics), result.diagnostics
    ours = by_name([facts(declaration) for declaration in result.model.declarations])
    theirs = by_name(by_omniidl(path))
    assert ours.keys() == theirs.keys()
    for name, fact in theirs.items():
        assert ours[name] == fact
