"""Offsets and sizes of members: the octets that change with a member are those of its place."""

from __future__ import annotations

from typing import Any

import emitted
import pytest

from rtgen.frontends.idl import load
from rtgen.layouts.offsets import StructLayout, layout
from rtgen.layouts.representations import Representations
from rtgen.model import Model, Struct

TEXT = """
module o {
  enum Colour { RED, GREEN };
  @bit_bound(8) enum Small { ONE, TWO };
  @bit_bound(12) bitmask Flags { A, B };
  bitset Fields { bitfield<3> low; bitfield<9> high; };
  struct Inner { octet first; double second; };
  struct Late { double first; octet second; };
  struct Plain { octet a; double b; short c; long d; boolean e; long long f; };
  struct Enums { octet a; Colour b; octet c; Small d; octet e; Flags f; octet g; Fields h; };
  struct Nested { octet a; Inner b; octet c; Late d; octet e; };
  struct Arrays { octet a; short b[3]; octet c; double d[2]; octet e; Inner f[2]; octet g; };
  struct Base { octet a; long b; };
  struct Derived : Base { octet c; double d; };
  struct Open { octet a; double b; sequence<long> c; long d; };
  @data_representation(XCDR2) struct Plain2 { octet a; double b; short c; long long d; };
  @data_representation(XCDR2) @appendable struct Grows { octet a; double b; short c; };
  @data_representation(XCDR2) struct Holds { octet a; Grows b; octet c; Inner d[2]; octet e; };
};
"""
HEADER = 4
"""Octets of the encapsulation before the value."""

CHANGED = {"bool": True, "int": 1, "float": 1.5}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("offsets"), TEXT).o


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    path = tmp_path_factory.mktemp("model") / "case.idl"
    path.write_text(TEXT, encoding="utf-8")
    return load([path], root=path.parent).model


def laid_out(model: Model, name: str) -> StructLayout:
    struct = model.find(("o", name))
    assert isinstance(struct, Struct)
    return layout(model, struct, Representations(model))


def octets(value: Any) -> bytes:
    made: bytes = value.to_cdr()
    return made


def changed(value: Any) -> Any:
    """Another value of the same type."""
    name = type(value).__name__
    if name in CHANGED:
        return CHANGED[name]
    if hasattr(value, "__members__") or hasattr(type(value), "__members__"):
        return list(type(value))[-1]
    return None


@pytest.mark.parametrize(
    "name",
    [
        *("Plain", "Enums", "Nested", "Arrays", "Derived", "Plain2", "Grows", "Holds"),
    ],
)
def test_a_member_changes_the_octets_of_its_place(
    name: str, package: Any, model: Model
) -> None:
    laid = laid_out(model, name)
    type_ = getattr(package, name)
    before = octets(type_())
    assert laid.size == len(before)
    for place in laid.members:
        assert place.offset is not None
        assert place.size is not None
        value = type_()
        other = changed(getattr(value, place.member.name))
        if other is None or other == getattr(value, place.member.name):
            continue
        setattr(value, place.member.name, other)
        after = octets(value)
        different = [
            i for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b
        ]
        assert different
        assert place.offset <= different[0]
        assert different[-1] < place.offset + place.size


def test_places_follow_each_other(model: Model) -> None:
    for declaration in model.declarations:
        if isinstance(declaration, Struct):
            end = 0
            for place in laid_out(model, declaration.name[-1]).members:
                if place.offset is None:
                    break
                assert place.offset >= end
                end = place.offset + (place.size or 0)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("Plain", [(0, 1), (8, 8), (16, 2), (20, 4), (24, 1), (32, 8)]),
        ("Plain2", [(0, 1), (4, 8), (12, 2), (16, 8)]),
        ("Grows", [(4, 1), (8, 8), (16, 2)]),
        ("Open", [(0, 1), (8, 8), (16, None), (None, 4)]),
        ("Derived", [(0, 1), (4, 4), (8, 1), (16, 8)]),
    ],
)
def test_places(
    name: str, wanted: list[tuple[int | None, int | None]], model: Model
) -> None:
    assert [(p.offset, p.size) for p in laid_out(model, name).members] == wanted
