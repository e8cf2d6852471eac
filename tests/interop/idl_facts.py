"""What omniidl and rtgen say of a definition file, in one form that can be compared."""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

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

BACKEND = Path(__file__).with_name("omniidl_backend")
OMNIIDL = shutil.which(
    "omniidl", path=str(Path(sys.executable).parent)
) or shutil.which("omniidl")


def omniidl(
    path: str, include: Sequence[str], folder: Path
) -> subprocess.CompletedProcess[bytes]:
    """Have omniidl print the facts of a file as JSON."""
    command = [str(OMNIIDL), "-p", str(BACKEND), "-b", "rtgen_facts"]
    command += [f"-I{place}" for place in include]
    return subprocess.run(
        [*command, path], cwd=folder, capture_output=True, check=False, timeout=60
    )


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
