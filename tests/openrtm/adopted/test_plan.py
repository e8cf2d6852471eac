"""Names common to the parts of the target openrtm: ports, files, behaviours."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.backends import Options
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl import load
from rtgen.openrtm.backend.backend import BACKEND
from rtgen.openrtm.backend.plan import ComponentPlan, Unit, openrtm_port_name, plans

OPTIONS = Options("robots", "behaviours", "0.1.0", target="openrtm")


def planned(
    folder: Path, options: Options = OPTIONS, **files: str
) -> tuple[list[ComponentPlan], list[Diagnostic]]:
    for name, text in files.items():
        (folder / f"{name}.idl").write_text(text)
    read = load([folder / f"{name}.idl" for name in files], root=folder)
    assert not read.diagnostics
    return plans([Unit(read.model, options, options.factories)])


def names(plan: ComponentPlan) -> list[str]:
    return [openrtm_port_name(plan.component, port) for port in plan.component.ports]


TYPES = """
module M { struct T { long x; }; interface I { void f(); }; };
"""


def test_equal_names_are_distinguished_and_warned_of(tmp_path: Path) -> None:
    (plan,), found = planned(
        tmp_path,
        a=TYPES + """component C {
            consumes M::T data; @name("data") publishes M::T sent;
            @name(".positon") publishes M::T positon;
            @port("data") provides M::I one; @port("data") @instance("two") provides M::I two;
        };""",
    )
    assert names(plan) == [
        "data",
        "data_out",
        ".positon",
        "data_service",
        "data_service",
    ]
    assert [d.code for d in found] == ["RTC0560", "RTC0560"]


def test_a_chosen_name_is_taken_without_a_warning(tmp_path: Path) -> None:
    (plan,), found = planned(
        tmp_path,
        a=TYPES + """component C {
            consumes M::T data; @name("data") @openrtm_name("given") publishes M::T sent;
            @port("p") provides M::I one;
            @port("p") @openrtm_name("other") @instance("two") uses M::I two;
        };""",
    )
    assert names(plan) == ["data", "given", "other", "other"]
    assert found == []
    assert [p.name for p in plan.service_ports] == ["other"]


def test_what_cannot_be_distinguished_is_an_error(tmp_path: Path) -> None:
    _, found = planned(
        tmp_path,
        a=TYPES + """component C {
            consumes M::T data; @name("data") publishes M::T sent; publishes M::T data_out;
        };
        component D {
            @openrtm_name("x") @port("p") provides M::I one;
            @openrtm_name("y") @port("p") @instance("two") uses M::I two;
        };""",
    )
    assert [d.code for d in found] == ["RTC0560", "RTC0561", "RTC0562"]


def test_components_of_one_name_need_two_folders(tmp_path: Path) -> None:
    _, found = planned(
        tmp_path, a="module A { component C {}; }; module B { component C {}; };"
    )
    assert [d.code for d in found] == ["RTC0564"]


def test_the_package_cannot_stand_where_the_modules_do(tmp_path: Path) -> None:
    (tmp_path / "a.idl").write_text("component C {};")
    model = load([tmp_path / "a.idl"], root=tmp_path).model
    options = Options("openrtm", "", "0", target="openrtm")
    assert [d.code for d in BACKEND.emit(model, options).diagnostics] == ["RTC0563"]
    embedded = Options("openrtm", "", "0")
    assert BACKEND.emit(model, embedded).artifacts == ()


def test_files_come_after_those_that_they_need(tmp_path: Path) -> None:
    (tmp_path / "BasicDataType.idl").write_text(
        "module RTC { struct Time { long sec; }; };"
    )
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "types.idl").write_text(
        '#include "../BasicDataType.idl"\nstruct Plain { RTC::Time tm; };'
    )
    (plan,), _ = planned(
        tmp_path,
        types='#include "in/types.idl"\n module M { struct T { Plain p; }; };',
        unused="module N { struct U { long x; }; };",
        a='#include "types.idl"\n component C { consumes M::T data; };',
    )
    assert [(f.stem, f.stock) for f in plan.idl_files] == [
        ("BasicDataType", True),
        ("types", False),
        ("types_2", False),
    ]
    assert [f.stem for f in plan.own_idl_files] == ["types", "types_2"]
    assert [f.stem for f in plan.unit.needs(plan.idl_files[2])] == ["types"]


def test_behaviours_stand_in_skeletons_or_where_the_project_says(
    tmp_path: Path,
) -> None:
    (plan,), _ = planned(tmp_path, a="component LineFollower {};")
    assert plan.behaviour == ("behaviours.line_follower", "LineFollower")
    assert plan.folder == "openrtm/LineFollower"
    options = Options("r", "", "0", factories={"LineFollower": "own.module:make"})
    (plan,), _ = planned(tmp_path, options, a="component LineFollower {};")
    assert plan.behaviour == ("own.module", "make")
