"""Findings of the target openrtm about types that omniORB does not support."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.compiler.backends import Emission, Options
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.openrtm.backend.backend import BACKEND


def emission(folder: Path, text: str) -> Emission:
    path = folder / "case.idl"
    path.write_text(text)
    read = load([path], root=folder)
    assert not has_errors(read.diagnostics), read.diagnostics
    options = Options("robots", "behaviours", "0.1.0", target="openrtm")
    return BACKEND.emit(read.model, options)


@pytest.mark.parametrize(
    ("declared", "reason"),
    [
        (
            "struct T { map<string, long> m; };",
            "`M::T` has a `map`, which IDL has since version 4",
        ),
        ("struct T { int8 x; };", "`M::T` has `int8`, which IDL has since"),
        ("struct T { sequence<uint8> x; };", "`M::T` has `uint8`, which IDL has since"),
        ("struct T { long double x; };", "`long double`, which omniORBpy has not"),
        ("struct T { @optional long x; };", "has the optional member `x`"),
        ("struct T { long self; };", "has a member `self`, which breaks"),
        ("struct T {};", "`M::T` has no members"),
        ("bitmask B { one }; struct T { B set; };", "`M::B` is a bitmask"),
        ("bitset B { bitfield<3> x; }; struct T { B set; };", "`M::B` is a bitset"),
        ("enum E { @value(2) two }; struct T { E e_; };", "with values of their own"),
        ("union T switch (octet) { case 1: long x; };", "is switched by `octet`"),
        (
            "native N; interface I { void f(in N n_); }; struct T { I i_; };",
            "`M::N` is native",
        ),
        (
            "local interface I { void f(); }; struct T { I i_; };",
            "is a local interface",
        ),
        ("interface I; struct T { I i_; };", "is declared, but not defined"),
        ("abstract interface I {}; struct T { I i_; };", "is an abstract interface"),
        (
            "custom valuetype V { public long x; }; struct T { V v_; };",
            "custom valuetype",
        ),
        ("abstract valuetype V {}; struct T { V v_; };", "is an abstract valuetype"),
        ("struct A { int8 x; }; typedef A B; struct T { B b_; };", "`M::A` has `int8`"),
    ],
)
def test_types_that_omniorb_has_not(tmp_path: Path, declared: str, reason: str) -> None:
    text = f"module M {{ {declared} }};\ncomponent C {{ consumes M::T data; }};"
    found = emission(tmp_path, text)
    assert not found.artifacts
    (finding,) = found.diagnostics
    assert finding.code == "RTC0570"
    assert finding.message.startswith("OpenRTM cannot have the port `data`: ")
    assert reason in finding.message
    assert finding.span is not None
    assert finding.span.line == 2


@pytest.mark.parametrize(
    ("operations", "reason"),
    [
        ("M::T f();", "`M::T` has a `map`"),
        ("void f(in M::T x);", "`M::T` has a `map`"),
        ("attribute M::T x;", "`M::T` has a `map`"),
        ("void f() raises (M::X);", "`M::T` has a `map`"),
        ("attribute long x setraises (M::X);", "`M::T` has a `map`"),
    ],
)
def test_interfaces_that_omniorb_has_not(
    tmp_path: Path, operations: str, reason: str
) -> None:
    declared = "struct T { map<string, long> m; }; exception X { T given; };"
    text = f"""
    module M {{ {declared} interface I {{ {operations} }}; interface J : I {{}}; }};
    component C {{ provides M::J one; uses M::I two; }};
    """
    found = emission(tmp_path, text)
    assert [d.code for d in found.diagnostics] == ["RTC0570", "RTC0570"]
    assert all(reason in d.message for d in found.diagnostics)


def test_what_no_port_has_may_be_of_idl_4(tmp_path: Path) -> None:
    text = """
    module M { struct New { map<string, long> m; }; struct T { long x; }; };
    component C { consumes M::T data; };
    """
    found = emission(tmp_path, text)
    assert not found.diagnostics
    (idl,) = (a.text for a in found.artifacts if a.path.endswith("case.idl"))
    assert "struct T" in idl
    assert "New" not in idl


def test_interfaces_that_need_each_other(tmp_path: Path) -> None:
    text = """
    module M {
        interface B;
        interface A { void give(in B other); };
        interface B { void give(in A other, in int8 small); };
    };
    component C { uses M::B one; uses M::A two; };
    """
    found = emission(tmp_path, text)
    assert [d.code for d in found.diagnostics] == ["RTC0570", "RTC0570"]
    assert all("`M::B` has `int8`" in d.message for d in found.diagnostics)


def test_modules_that_python_has_as_well(tmp_path: Path) -> None:
    text = """
    module typing { struct T { long x; }; struct U { long x; }; };
    struct calendar { long x; };
    module logging { struct Unused { long x; }; };
    component C { consumes typing::T data; publishes calendar out_; };
    component D { consumes typing::U data; };
    """
    found = emission(tmp_path, text)
    assert found.artifacts
    assert [d.code for d in found.diagnostics] == ["RTC0571", "RTC0571"]
    first = found.diagnostics[0]
    assert first.message.startswith("`typing::T` is in the module `typing`: omniORB")


@pytest.mark.parametrize(
    "declared",
    [
        "interface I { attribute long assert; };",
        "interface I { readonly attribute long assert; };",
        "interface J { attribute long assert; }; interface I : J {};",
        "exception assert {}; interface I { void f() raises (assert); };",
        "interface assert { exception lambda {}; };"
        " interface I { void f() raises (assert::lambda); };",
        "interface assert {}; interface I : assert {};",
        "valuetype assert { public long x; }; valuetype V : assert { public long y; };"
        " interface I { void f(in V v_); };",
        "interface assert {}; valuetype V supports assert { public long y; };"
        " interface I { void f(in V v_); };",
    ],
)
def test_keywords_that_break_the_stubs(tmp_path: Path, declared: str) -> None:
    found = emission(
        tmp_path, f"module M {{ {declared} }}; component C {{ uses M::I i_; }};"
    )
    (finding,) = found.diagnostics
    assert finding.code == "RTC0570"
    assert "a keyword of Python, which breaks omniORBpy's module" in finding.message


POSSIBLE = """
module {0} {{ struct S {{ long x; }}; exception E {{}}; interface B {{}}; }};
module M {{
    module constants {{ const long {0} = 3; }};
    struct T {{ long {0}; }};
    module inner {{ struct {0} {{ long x; }}; }};
    module unions {{ union {0} switch (long) {{ case 1: long a; }}; }};
    module enums {{ enum {0} {{ other, next_ }}; }};
    module enumerators {{ enum E {{ {0}, more }}; }};
    interface I : {0}::B {{
        long {0}(in long {0}, in inner::{0} a, in T b, in unions::{0} c);
        void g(in enums::{0} d, in enumerators::E e);
    }};
    interface J {{ void f() raises ({0}::E); }};
}};
component C {{ uses M::I i_; uses M::J j_; }};
"""


@pytest.mark.parametrize("name", ["assert", "raise", "None", "lambda", "async"])
def test_keywords_that_are_possible(tmp_path: Path, name: str) -> None:
    assert not emission(tmp_path, POSSIBLE.format(name)).diagnostics
