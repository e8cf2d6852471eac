"""The content of descriptors: names, member ids, extensibility, aliases."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.marshalling.descriptors import AliasDescriptor, plain

IDL = """
module M {
  typedef double Metres;
  typedef sequence<Metres> Path;
  @appendable @nested struct Base { @key long a; @id(7) long b; long c; };
  @mutable @autoid(HASH) struct Hashed {
    @key long from; @hashid("color") long other; @id(3) @must_understand long x;
    @external Path route;
  };
  struct Derived : Base { long d; };
  @extensibility(MUTABLE) union U switch (long) {
    case 1: long a; @id(9) case 2: Path b; case 3: Metres class;
  };
  @bit_bound(8) enum Small { ONE, None };
  struct Node; typedef sequence<Node> Nodes;
  struct Node { Nodes children; Metres size; };
};
"""


@pytest.fixture(scope="module")
def m(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("descriptors"), IDL).m


def test_members_carry_the_facts_of_the_definition(m: Any) -> None:
    base = m.Base._descriptor_
    assert (base.extensibility, base.nested) == ("appendable", True)
    assert [(x.name, x.id, x.key) for x in base.members] == [
        ("a", 0, True),
        ("b", 7, False),
        ("c", 8, False),
    ]
    assert [x.id for x in m.Derived._descriptor_.members] == [0, 7, 8, 9]
    assert m.Derived._descriptor_.extensibility == "appendable"  # the base's hash
    hashed = m.Hashed._descriptor_
    assert hashed.extensibility == "mutable"
    # DDS-XTypes 1.3, 7.3.1.2.1.1 has the hash of `color` for its example.
    assert [x.id for x in hashed.members[1:3]] == [0x0FA5DD70, 3]
    first = hashed.members[0]
    assert (first.name, first.attribute, first.key) == ("from", "from_", True)
    assert hashed.members[2].must_understand
    assert hashed.members[3].external


def test_branches_and_enums(m: Any) -> None:
    union = m.U._descriptor_
    assert union.extensibility == "mutable"
    facts = [(b.name, b.attribute, b.id) for b in union.branches]
    assert facts == [("a", "a", 1), ("b", "b", 9), ("class", "class_", 10)]
    assert m.Small._descriptor_.bound == 8
    assert m.Small._descriptor_.members == (("ONE", 0), ("None", 1))


def test_aliases_are_named_and_looked_through(m: Any, tmp_path: Path) -> None:
    path = m.Hashed._descriptor_.members[3].type
    assert isinstance(path, AliasDescriptor)
    assert (path.repository_id, path.name) == ("IDL:M/Path:1.0", "M::Path")
    assert str(path) == "sequence<double>"
    assert str(plain(path)) == "sequence<double>"
    assert m.PathCodec._descriptor_ is path
    text = IDL.replace("sequence<Metres>", "sequence<double>")
    other = emitted.emit_text(tmp_path, text).m
    for name in ("Hashed", "U", "Node"):
        ours, theirs = getattr(m, name), getattr(other, name)
        assert difference(ours._descriptor_, theirs._descriptor_) is None
    assert difference(m.Base._descriptor_, m.Derived._descriptor_) is not None


def test_generated_values_are_pickled(m: Any) -> None:
    value = m.Node([m.Node([], 2.0)], 1.0)
    assert pickle.loads(pickle.dumps(value)) == value


def test_names_that_two_files_have(tmp_path: Path) -> None:
    """An imported name never replaces one that the module defines."""
    first = tmp_path / "first.idl"
    first.write_text("module A { typedef long Id; interface Role { Id get(); }; };")
    second = tmp_path / "second.idl"
    second.write_text(
        '#include "first.idl"\n'
        "module B { typedef A::Id Id; interface Role : A::Role { Id own(); };\n"
        "struct Both { A::Id theirs; Id ours; }; };"
    )
    package = emitted.emit(tmp_path, [first, second])
    members = package.b.Both._descriptor_.members
    assert [member.type.name for member in members] == ["A::Id", "B::Id"]
    assert package.b.RoleStub.__mro__[1:4] == (
        package.b.Role,
        package.a.RoleStub,
        package.a.Role,
    )
    text = (tmp_path / package.__name__ / "_idl" / "second.py").read_text()
    assert "RoleStub as RoleStub_" in text
    assert "class RoleStub(Role, RoleStub_):" in text


def test_annotations_of_modules_are_the_defaults_of_their_types(tmp_path: Path) -> None:
    package = emitted.emit_text(
        tmp_path,
        """
@mutable @autoid(HASH) @default_nested module Outer {
  struct A { long color; };
  @nested(FALSE) @final @autoid(SEQUENTIAL) struct B { long color; };
  @topic union U switch (long) { case 1: long color; };
  @appendable @data_representation(XCDR2) module Inner {
    struct C { octet a; double b; };
    @data_representation(XCDR) @final struct D { octet a; double b; };
    interface I { struct E { long a; }; };
  };
  struct Derived : B { long d; };
  struct Later;
};
module Outer { struct F { long a; }; struct Later { long a; }; };
""",
    )
    outer, inner = package.outer, package.outer.inner
    found = {
        t.__name__: (t._descriptor_.extensibility, t._descriptor_.nested)
        for t in (outer.A, outer.B, outer.U, inner.C, inner.D, inner.I.E)
    }
    assert found == {
        "A": ("mutable", True),
        "B": ("final", False),
        "U": ("mutable", False),
        "C": ("appendable", True),
        "D": ("final", True),
        "I_E": ("appendable", True),
    }
    assert outer.Derived._descriptor_.extensibility == "final"
    for type_ in (outer.F, outer.Later):  # an opening without annotations
        assert (type_._descriptor_.extensibility, type_._descriptor_.nested) == (
            "final",
            False,
        )
    hashed = outer.A._descriptor_.members[0].id
    assert hashed == 0x0FA5DD70
    assert inner.C(1, 2.0).to_cdr() == inner.C(1, 2.0).to_xcdr2()
    assert inner.D(1, 2.0).to_cdr() != inner.D(1, 2.0).to_xcdr2()
