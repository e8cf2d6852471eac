"""Content of a definition file as read by omniidl and rtgen, in one form that can be compared."""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import programs

from rtgen.compiler.model import (
    Const,
    ConstantValue,
    Declaration,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Interface,
    Native,
    Operation,
    Struct,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)

BACKEND = Path(__file__).with_name("omniidl_backend")


def omniidl(
    path: str, include: Sequence[str], folder: Path
) -> subprocess.CompletedProcess[bytes]:
    """Run omniidl to print the facts of a file as JSON."""
    command = [programs.omniidl(), "-p", str(BACKEND), "-b", "rtgen_facts"]
    command += [f"-I{place}" for place in include]
    return subprocess.run(
        [*command, path], cwd=folder, capture_output=True, check=False, timeout=60
    )


def omniidl_batch(requests: list[dict[str, object]]) -> list[dict[str, Any]]:
    """Return exit code, facts and messages of omniidl for many small files.

    Each is given as {folder, file, arguments}.
    """
    run = subprocess.run(
        [sys.executable, BACKEND / "batch.py"],
        input=json.dumps(requests),
        capture_output=True,
        text=True,
        check=True,
    )
    answers: list[dict[str, Any]] = json.loads(run.stdout)
    return answers


def scoped(name: tuple[str, ...]) -> str:
    return "::".join(name)


def value(found: ConstantValue) -> object:
    match found:
        case EnumeratorName(name):
            return scoped(name)
        case bool() | int() | float() | str():
            return found
    return str(found)


def parameters(operation: Operation) -> list[list[str]]:
    """Return direction, name and type of each parameter."""
    return [[str(p.direction), p.name, str(p.type)] for p in operation.parameters]


def callables(declaration: Interface | Valuetype) -> dict[str, object]:
    """Return the operations and the attributes of an interface or valuetype."""
    return {
        "operations": [
            [
                o.name,
                o.repository_id,
                o.oneway,
                str(o.returns),
                parameters(o),
                [scoped(name) for name in o.raises],
                list(o.context),
            ]
            for o in declaration.operations
        ],
        "attributes": [
            [a.name, a.repository_id, str(a.type), a.readonly]
            for a in declaration.attributes
        ],
    }


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
                **callables(declaration),
            }
        case Valuetype():
            return {
                "kind": "valuetype",
                **common,
                "bases": [scoped(base) for base in declaration.bases],
                "supports": [scoped(base) for base in declaration.supports],
                "abstract": declaration.abstract,
                "custom": declaration.custom,
                "truncatable": declaration.truncatable,
                "state": [[m.name, str(m.type), m.public] for m in declaration.state],
                "factories": [
                    [f.name, parameters(f), [scoped(name) for name in f.raises]]
                    for f in declaration.factories
                ],
                **callables(declaration),
            }
        case ValueBox():
            return {"kind": "valuebox", **common, "type": str(declaration.type)}
    raise AssertionError(f"unexpected {declaration}")
