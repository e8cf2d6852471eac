"""Codecs of types whose names are no identifiers of Python, and calls of services in all scopes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import emitted
import pytest

from rtgen.runtime import idl, xcdr
from rtgen.runtime.cdr import Aggregated, field
from rtgen.runtime.services.calls import calls_of
from rtgen.ui.calls import carried_out
from rtgen.ui.protocol import ui

NAMES = [
    *("M::S", "M::I.operation reply", "a.b.c", "class", "lambda", "a-b", "1st", ""),
    *(
        " ",
        "\ufb01",
        "\u65e5\u672c",
        "S\n",
        'a"b',
        "a'b",
        "\\",
        "{x}",
        "read",
        "out",
        "self",
    ),
    "x" * 300,
]
FORMATS = [1, 2]


def made(outer: str, inner: str, class_name: str) -> Any:
    """Return a type with a sequence of structs, whose descriptors have these names."""

    class Inner(Aggregated):
        _descriptor_: ClassVar = idl.struct(
            inner, idl.traits(), text=idl.STRING, words=idl.sequence(idl.STRING)
        )
        text: str = ""
        words: Sequence[str] = field(default_factory=list)

    class Outer(Aggregated):
        _descriptor_: ClassVar = idl.struct(
            outer,
            idl.traits(),
            items=idl.sequence(Inner._descriptor_),
            one=Inner._descriptor_,
        )
        items: Sequence[Any] = field(default_factory=list)
        one: Any = field(default_factory=Inner)

    Inner.__name__ = Outer.__name__ = class_name
    items = [Inner("a", ["b", "c"]), Inner("d", [])]
    return Outer, Outer(items, Inner("e", ["f"]))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_codecs(name: str) -> None:
    for names in ((name, name), (name, "M::Inner"), ("M::Outer", name)):
        for class_name in ("Same", name.strip() or "Same"):
            if "\n" in class_name or not class_name.isprintable():
                continue
            type_, value = made(*names, class_name)
            assert type_.from_cdr(value.to_cdr()) == value
            copy = type_._snapshot_(value)
            assert copy == value
            assert copy.items[0] is not value.items[0]
            for version in FORMATS:
                octets = xcdr.serialize(value, xcdr.representation_of(type_, version))
                assert xcdr.deserialize(type_, octets) == value


IDL = """
module {outer} {{
    struct Note {{ string text; sequence<string> words; }};
    typedef sequence<Note> NoteList;
    typedef sequence<string> WordList;
    module {inner} {{
        struct Note {{ NoteList notes; }};
        interface {interface} {{
            Note {operation}(in Note given, in WordList {argument}, out NoteList rest);
            attribute WordList {attribute};
        }};
    }};
}};
"""
SCOPES = [
    ("SimpleService", "Deeper", "MyService", "echo_history", "words", "all_of_them"),
    ("lambda", "class", "def", "import", "in_", "yield"),
    ("None", "global", "is", "pass", "self", "value"),
    ("data", "outer", "list", "size", "offset", "read"),
]


@pytest.mark.parametrize("names", SCOPES, ids=lambda names: names[2])
def test_calls_of_a_page(tmp_path: Path, names: Sequence[str]) -> None:
    keys = ("outer", "inner", "interface", "operation", "argument", "attribute")
    text = IDL.format(**dict(zip(keys, names, strict=True)))
    package = emitted.emit_text(tmp_path, text)
    [interface] = [each for each in emitted.classes(package) if "_calls_" in vars(each)]
    calls = calls_of(interface)
    operation, attribute = names[3], names[5]
    assert {*calls} == {operation, f"_get_{attribute}", f"_set_{attribute}"}
    request: Any = calls[operation].request
    note = request._descriptor_.members[0].type.class_
    plain = next(
        each
        for each in emitted.classes(package)
        if each._descriptor_.name == f"{names[0]}::Note"
    )
    given = note([plain("a", ["b"]), plain("c", [])])
    arguments = request(given, ["d"])
    octets = xcdr.serialize(arguments, xcdr.representation_of(request, 1))
    seen: list[Any] = []

    def invoke(name: str, values: tuple[object, ...]) -> object:
        seen.append((name, values))
        if name == operation:
            return given, [plain("e", ["f"])]
        return ["g", "h"] if name.startswith("_get") else None

    def called(name: str, data: bytes = b"") -> bytes:
        address = ui.PortAddress("instance", "port")
        return carried_out(interface, invoke, ui.Call(address, "", name, data))

    reply_type: Any = calls[operation].reply
    reply = xcdr.deserialize(reply_type, called(operation, octets))
    assert seen == [(operation, (given, ["d"]))]
    assert reply == reply_type(given, [plain("e", ["f"])])
    getter: Any = calls[f"_get_{attribute}"].reply
    answer = called(f"_get_{attribute}")
    assert xcdr.deserialize(getter, answer) == getter(["g", "h"])
    setter: Any = calls[f"_set_{attribute}"].request
    value = setter(["i"])
    data = xcdr.serialize(value, xcdr.representation_of(setter, 1))
    assert called(f"_set_{attribute}", data) == b""
    assert seen[-1] == (f"_set_{attribute}", (["i"],))
