"""The target typescript: octets equal to those of the Python codecs, both ways."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import emitted
import pytest
import samples
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as with_seed
from hypothesis import strategies as st
from node import node
from seeds import budget, seed

import rtgen
from rtgen.backends import Options
from rtgen.backends.typescript.backend import BACKEND
from rtgen.runtime import xcdr
from rtgen.ui.protocol import ui
from rtgen.ui.type_table import NO_TYPE, TypeTable

HERE = Path(__file__).parent
PROTOCOL = HERE.parents[2] / "ui/src/protocol"
OPTIONS = Options("robots", "", "0", target="typescript")
FORMATS = [(1, True), (1, False), (2, True), (2, False)]
OPTIONAL = ("T Growing", "T Maybe", "T Either", "T Whole")
LEFT_OUT = {
    "T::Price": "fixed<5,2>",
    "T::Loose": "the mutable type T::Loose",
    "T::Holder": "the mutable type T::Loose",
    "T::Circle": "any",
    "T::Circles": "any",
}


@dataclass
class Both:
    """The types in Python, and the folder that has them in TypeScript."""

    types: dict[str, type[Any]]
    folder: Path


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Both:
    folder = tmp_path_factory.mktemp("typescript")
    path = HERE / "typescript.idl"
    package = emitted.emit(folder, [path])
    types = {t._descriptor_.repository_id: t for t in emitted.classes(package)}
    emission = BACKEND.emit(rtgen.compile(path), OPTIONS)
    found = [d.message for d in emission.diagnostics]
    assert sorted(found) == sorted(
        f"`{name}` is left out: {what} has no codec" for name, what in LEFT_OUT.items()
    )
    assert all(d.span is not None for d in emission.diagnostics)
    for artifact in emission.artifacts:
        file = folder / artifact.path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(artifact.text, encoding="utf-8")
    return Both(types, folder / "typescript")


def drawn(type_: type[Any], types: dict[str, type[Any]], count: int) -> list[Any]:
    """Values of a type."""
    found: list[Any] = []

    @with_seed(seed())
    @settings(
        max_examples=budget(count),
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(samples.values(type_._descriptor_))
    def draw(tree: Any) -> None:
        found.append(samples.build(type_._descriptor_, tree, types))

    draw()
    return found


def octets(value: Any, version: int, little_endian: bool) -> str:
    """A body in hexadecimal digits."""
    return xcdr.encode(type(value), value, version, little_endian).hex()


def structs(both: Both) -> list[type[Any]]:
    return [
        type_
        for type_ in both.types.values()
        if hasattr(type_, "to_cdr") and type_._descriptor_.name not in LEFT_OUT
    ]


def place(type_: type[Any]) -> str:
    """Module and name in TypeScript."""
    *scope, name = type_._descriptor_.name.split("::")
    return f"{'/'.join(scope) or 'index'} {name}"


def test_octets_are_those_of_python(both: Both) -> None:
    lines: list[str] = []
    expected: list[list[str]] = []
    for type_ in structs(both):
        if not hasattr(type_, "_snapshot_"):
            continue
        for value in drawn(type_, both.types, 12):
            every = [octets(value, *each) for each in FORMATS]
            # Optional members have headers in version 1, which TypeScript does not have.
            known = every[2:] if place(type_) in OPTIONAL else every
            for (version, little), text in zip(
                FORMATS[-len(known) :], known, strict=True
            ):
                lines.append(f"{place(type_)} {version} {little:d} {text}")
                expected.append(known)
    assert len(lines) > 500
    script = HERE / "typescript_peer.mjs"
    answers = node(script, "\n".join(lines), str(both.folder)).splitlines()
    for line, answer, every in zip(lines, answers, expected, strict=True):
        made = json.loads(answer)
        assert made["all"][-len(every) :] == every, line
        assert made["same"], line


def test_messages_of_any_length(both: Both) -> None:
    lists = both.types["IDL:T/Lists:1.0"]
    expected = []
    for count in range(40, 80):
        value = lists()
        value.longs, value.names = [1] * count, ["a"] * (count % 4)
        expected.append(octets(value, 1, True))
    lines = "\n".join(f"T Lists 1 1 {text}" for text in expected)
    answers = node(HERE / "typescript_peer.mjs", lines, str(both.folder)).splitlines()
    assert [json.loads(answer)["all"][0] for answer in answers] == expected


def test_the_table_of_types_gives_the_same_codecs(both: Both) -> None:
    table = TypeTable()
    numbers = {type_: table.number(type_._descriptor_) for type_ in structs(both)}
    assert NO_TYPE not in numbers.values()
    assert len(table.nodes) < 120
    added = ui.AddedTypes(first=0, nodes=table.nodes)
    lines, expected = [f"0 {added.to_cdr().hex()}"], []
    for type_ in numbers:
        if not hasattr(type_, "_snapshot_"):
            continue
        version = 2 if place(type_) in OPTIONAL else 1
        for value in drawn(type_, both.types, 4):
            expected.append(octets(value, version, True))
            lines.append(f"{numbers[type_]} {version} {expected[-1]}")
    script = HERE / "type_table_peer.mjs"
    answers = node(script, "\n".join(lines), str(PROTOCOL)).splitlines()
    assert answers == expected


def test_types_without_a_codec_have_no_number(both: Both) -> None:
    table = TypeTable()
    for name in LEFT_OUT:
        type_ = both.types[f"IDL:{name.replace('::', '/')}:1.0"]
        assert table.number(type_._descriptor_) == NO_TYPE, name
    assert table.nodes == []


def test_damaged_octets_give_a_value_or_a_coded_error(both: Both) -> None:
    lines: list[str] = []

    @with_seed(seed())
    @settings(
        max_examples=budget(200),
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(
        st.sampled_from(structs(both)), st.binary(max_size=60), st.sampled_from(FORMATS)
    )
    def draw(type_: type[Any], data: bytes, form: tuple[int, bool]) -> None:
        lines.append(f"{place(type_)} {form[0]} {form[1]:d} {data.hex()}")

    draw()
    script = HERE / "typescript_peer.mjs"
    answers = node(script, "\n".join(lines), str(both.folder)).splitlines()
    assert len(answers) == len(lines)
    errors = {json.loads(answer).get("error", "CdrError") for answer in answers}
    assert errors == {"CdrError"}


def test_types_are_erased_and_texts_quoted(both: Both) -> None:
    text = (both.folder / "_idl" / "typescript.ts").read_text(encoding="utf-8")
    assert 'export const T$NAME = "a \\"quoted\\" */ name";' in text
    assert "export const T$VAST = 5000000000n;" in text
    assert 'export const T$FIRST = "GREEN";' in text
    assert "export interface delete$ {" in text
    assert "  /** [m] */\n  height: number;" in text
    assert 'lazy("T::Tree", () => T$Tree)' in text
    public = (both.folder / "index.ts").read_text(encoding="utf-8")
    assert "delete$ as delete," in public


def test_comments_end_where_they_should() -> None:
    model = rtgen.compile("/** a *\\/ b\n */ struct A { long x; };")
    model_text = BACKEND.emit(model, OPTIONS).artifacts[-1].text
    assert model_text.count("*/") == model_text.count("/**")
