"""Random types start with the same values in classes, decoders, `inspect` and TypeScript."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from math import prod
from pathlib import Path
from random import Random
from typing import Any

import emitted
import pytest
from node import node
from random_defaults import Definitions, Struct
from seeds import budget, seed

from rtgen import api
from rtgen.compiler.backends import Options
from rtgen.compiler.backends.typescript.backend import BACKEND
from rtgen.compiler.inspection.models import inspect
from rtgen.runtime import xcdr
from rtgen.runtime.marshalling.descriptors import (
    BitsetDescriptor,
    EnumDescriptor,
    FlagsDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.ui.protocol import ui
from rtgen.ui.type_table import NO_TYPE, TypeTable

pytestmark = pytest.mark.random

HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "ui/src"
TYPES = 30
"""Structs in one file, with as many other types."""


@pytest.fixture(scope="module", params=range(budget(1)))
def drawn(request: pytest.FixtureRequest) -> Definitions:
    """Draw definitions."""
    definitions = Definitions(Random(seed() * 1000 + request.param))
    definitions.lines.append("module R {")
    definitions.draw(TYPES)
    definitions.lines.append("};")
    return definitions


@pytest.fixture(scope="module")
def classes(
    drawn: Definitions, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """Return the generated classes by name."""
    package = emitted.emit_text(tmp_path_factory.mktemp("drawn"), drawn.idl)
    return {t._descriptor_.name: t for t in emitted.classes(package)}


def normal(value: Any) -> Any:
    """Return a value of Python in the normal form of `random_defaults`."""
    match getattr(value, "_descriptor_", None):
        case EnumDescriptor(members=members):
            return {n: name for name, n in members}[int(value)]
        case FlagsDescriptor():
            return int(value)
        case StructDescriptor(members=parts) | BitsetDescriptor(fields=parts):
            return {p.name: normal(getattr(value, p.attribute)) for p in parts}
        case UnionDescriptor() as union:
            branch = union.branch(value.discriminator)
            name = None if branch is None else branch.name
            return [normal(value.discriminator), name, normal(value.value)]
    if isinstance(value, bytes):
        return [*value]
    if isinstance(value, dict):
        return [[normal(k), normal(v)] for k, v in value.items()]
    if isinstance(value, str | int | float) or value is None:
        return value
    return [normal(item) for item in value]


def test_constructors(drawn: Definitions, classes: dict[str, Any]) -> None:
    for struct in drawn.structs:
        found = classes[f"R::{struct.name}"]()
        assert normal(found) == struct.initial, struct.name


def older(
    drawn: Definitions, classes: dict[str, Any]
) -> Iterator[tuple[Struct, int, bytes, dict[str, Any]]]:
    """Yield octets of older versions, and the values that readers make of them."""
    for struct in drawn.structs:
        if struct.extensibility == "final":
            continue
        expected = struct.initial
        value = classes[f"R::{struct.name}Old"]() if struct.old else None
        for member in struct.old:
            described = getattr(value, member.name)
            if type(described) is int:
                setattr(value, member.name, 1)
                expected[member.name] = 1
        for version in (1, 2):
            empty = bytes(4 * (version - 1))
            if value is not None:
                yield struct, version, xcdr.encode(
                    type(value), value, version, True
                ), expected
            elif struct.extensibility == "appendable":
                yield struct, version, empty, expected


def test_decoders_of_older_data(drawn: Definitions, classes: dict[str, Any]) -> None:
    count = 0
    for struct, version, octets, expected in older(drawn, classes):
        type_ = classes[f"R::{struct.name}"]
        found = xcdr.decode(type_, octets, version, True)
        assert normal(found) == expected, (struct.name, version)
        count += 1
    assert count


class Inspected:
    """The values that types start with, by the JSON of `rtgen inspect`."""

    def __init__(self, content: dict[str, Any]) -> None:
        self._named = {d["name"]: d for d in content["declarations"]}

    def start(self, type_: str, initial: Any) -> Any:
        """Return the value of a type, or a default of it, in the normal form."""
        declared = self._named.get(type_)
        while declared is not None and declared["kind"] == "typedef":
            initial = declared["initial"] if initial is None else initial
            type_ = declared["type"]
            declared = self._named.get(type_)
        array = re.fullmatch(r"(.*?)((?:\[\d+\])+)", type_)
        if array or type_.startswith("sequence<"):
            element = array[1] if array else type_[9:-1].partition(",")[0]
            sizes = array[2][1:-1].split("][") if array else [len(initial or ())]
            shape = [int(size) for size in sizes]
            items = initial
            if items is None:
                items = [self.start(element, None) for _ in range(prod(shape))]
            items = [self._scalar(element, item) for item in items]
            return _nested(items, shape, self._plain(element) == "char")
        if declared is None:
            if initial is not None:
                return initial
            return [] if type_.startswith("map<") else _ZEROS[type_.partition("<")[0]]
        match declared["kind"]:
            case "enum":
                return self._scalar(type_, initial) or declared["initial"]
            case "bitmask":
                return initial or 0
            case "struct":
                return dict(self._members(declared))
            case "bitset":
                members = declared["members"]
                return {m["name"]: m["initial"] or 0 for m in members}
        return self._union(declared)

    def _scalar(self, type_: str, value: Any) -> Any:
        """Return the last part of an enumerator's name."""
        is_enum = isinstance(value, str) and "::" in value
        return value.rpartition("::")[2] if is_enum else value

    def _plain(self, type_: str) -> str:
        while self._named.get(type_, {}).get("kind") == "typedef":
            type_ = self._named[type_]["type"]
        return type_

    def _members(self, struct: dict[str, Any]) -> Iterator[tuple[str, Any]]:
        if struct["base"]:
            yield from self._members(self._named[struct["base"]])
        for m in struct["members"]:
            value = None if m["optional"] else self.start(m["type"], m["initial"])
            yield m["name"], value

    def _union(self, union: dict[str, Any]) -> list[Any]:
        label = union["initial"]
        texts = {"TRUE": True, "FALSE": False, "0": 0, r"'\x00'": "\0"}
        first = texts.get(label, label.rpartition("::")[2])
        for case in (
            *(c for c in union["cases"] if label in c["labels"]),
            *(c for c in union["cases"] if "default" in c["labels"]),
        ):
            return [first, case["name"], self.start(case["type"], case["initial"])]
        return [first, None, None]


_ZEROS = {
    **dict.fromkeys(("float", "double"), 0.0),
    **dict.fromkeys(("short", "long", "long long", "octet", "int8", "uint8"), 0),
    **dict.fromkeys(("unsigned short", "unsigned long", "unsigned long long"), 0),
    "boolean": False,
    "char": "\0",
    "wchar": "\0",
    "string": "",
    "wstring": "",
}


def _nested(items: list[Any], shape: list[int], joined: bool) -> Any:
    if len(shape) == 1:
        return "".join(items) if joined else items
    step = len(items) // shape[0]
    rows = (items[at : at + step] for at in range(0, len(items), step))
    return [_nested(row, shape[1:], joined) for row in rows]


def test_inspect(drawn: Definitions) -> None:
    found = Inspected(inspect(api.compile(drawn.idl), []))
    for struct in drawn.structs:
        assert found.start(f"R::{struct.name}", None) == struct.initial, struct.name


def test_typescript(
    drawn: Definitions, classes: dict[str, Any], tmp_path: Path
) -> None:
    model = api.compile(drawn.idl)
    options = Options("robots", "", "0", target="typescript")
    for artifact in BACKEND.emit(model, options).artifacts:
        path = tmp_path / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    lines, expected = [], []
    for struct, version, octets, value in older(drawn, classes):
        if struct.portable:
            lines.append(f"{struct.name} {version} {octets.hex()}")
            expected.append((struct, version, value))
    script = HERE / "defaults_peer.mjs"
    answers = node(script, "\n".join(lines), str(tmp_path / "typescript"))
    for line, (struct, version, value) in zip(
        answers.splitlines(), expected, strict=True
    ):
        initial, decoded = _of_typescript(json.loads(line))
        assert initial == struct.initial, struct.name
        assert decoded == value or (decoded is None and version == 1), struct.name


def test_forms_of_the_page(drawn: Definitions, classes: dict[str, Any]) -> None:
    table = TypeTable()
    structs = [struct for struct in drawn.structs if struct.portable]
    types = [classes[f"R::{struct.name}"]._descriptor_ for struct in structs]
    numbers = [table.number(type_) for type_ in types]
    assert NO_TYPE not in numbers
    added = ui.AddedTypes(first=0, nodes=table.nodes).to_cdr().hex()
    answers = node(
        HERE / "forms_peer.mjs", "\n".join([added, *map(str, numbers)]), str(PAGE)
    )
    for line, struct in zip(answers.splitlines(), structs, strict=True):
        initial, form = json.loads(line)
        assert _of_typescript(initial) == struct.initial, struct.name
        # A form shows a character that cannot be seen as a space, and always a branch.
        if not re.search(r'\\u0000|"case":null', line):
            assert form == _without_discriminators(initial), struct.name


def _without_discriminators(value: Any) -> Any:
    """Return a value as a form gives it: a branch stands for its first label, if it has one."""
    if isinstance(value, dict):
        return {
            name: _without_discriminators(part)
            for name, part in value.items()
            if name != "discriminator" or value.get("case", "other") == "other"
        }
    if isinstance(value, list):
        return [_without_discriminators(part) for part in value]
    return value


def _of_typescript(value: Any) -> Any:
    """Return a value of TypeScript in the normal form."""
    if isinstance(value, dict) and "case" in value:
        part = _of_typescript(value.get("value"))
        return [_of_typescript(value["discriminator"]), value["case"], part]
    if isinstance(value, dict):
        return {name: _of_typescript(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_of_typescript(part) for part in value]
    if isinstance(value, str) and re.fullmatch(r"-?\d+n", value):
        return int(value[:-1])
    return value
