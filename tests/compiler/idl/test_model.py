"""The front end's model of definitions: ids, docs, components, files, dependencies."""

from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.inspection.models import inspect, tree
from rtgen.compiler.model import (
    Component,
    Const,
    EnumeratorName,
    Interface,
    NamedType,
    PortKind,
    Struct,
    Union,
)

GOLDEN = Path(__file__).parents[2] / "golden" / "idl"


def read(folder: Path, text: str, **more: str) -> FrontendResult:
    for name, content in more.items():
        (folder / f"{name}.idl").write_text(content, encoding="utf-8")
    path = folder / "input.idl"
    path.write_text(text, encoding="utf-8")
    return load([path], root=folder)


def ids(result: FrontendResult) -> dict[str, str]:
    return {d.scoped: d.repository_id for d in result.model.declarations}


def test_repository_ids_of_the_rtc_interfaces() -> None:
    found = ids(load([GOLDEN / "RTC.idl"], root=GOLDEN))
    assert found["RTC::RTObject"] == "IDL:omg.org/RTC/RTObject:1.0"
    assert found["RTC::ReturnCode_t"] == "IDL:omg.org/RTC/ReturnCode_t:1.0"
    assert found["SDOPackage::SDO"] == "IDL:org.omg/SDOPackage/SDO:1.0"
    assert found["OpenRTM::InPortCdr"] == "IDL:OpenRTM/InPortCdr:1.0"


@pytest.mark.parametrize(
    ("text", "name", "expected"),
    [
        (
            '#pragma prefix "p"\nmodule M { struct S { long a; }; };',
            "M::S",
            "IDL:p/M/S:1.0",
        ),
        (
            'module M {\n#pragma prefix "b"\nstruct S { long a; }; };',
            "M::S",
            "IDL:b/S:1.0",
        ),
        (
            'module M {\n#pragma prefix "b"\nmodule N { struct S { long a; }; }; };',
            "M::N::S",
            "IDL:b/N/S:1.0",
        ),
        ('struct S { long a; };\n#pragma ID S "IDL:x:2.0"', "S", "IDL:x:2.0"),
        ("struct S { long a; };\n#pragma version S 2.3", "S", "IDL:S:2.3"),
        ("struct _struct { long a; };", "struct", "IDL:struct:1.0"),
        ('#pragma prefix "p"\n#include "other.idl"\n', "O", "IDL:O:1.0"),
    ],
)
def test_repository_ids(text: str, name: str, expected: str, tmp_path: Path) -> None:
    assert ids(read(tmp_path, text, other="struct O { long a; };"))[name] == expected


@pytest.mark.parametrize(
    ("comment", "expected"),
    [
        ("/** One. */\n{}", "One."),
        ("/// One.\n/// Two.\n{}", "One.\nTwo."),
        ("// One.\n{}", "One."),
        ("// Not this.\n\n{}", ""),
        ("/* Not this. */\n{}", ""),
        ("/**\n * One.\n *\n *   Two.\n */\n{}", "One.\n\n  Two."),
        ("{} ///< Behind.", "Behind."),
        ("{} // Behind.", "Behind."),
        ("const long Z = 1; // Of Z.\n{}", ""),
        ("/** @file */\n{}", ""),
    ],
)
def test_docs(comment: str, expected: str, tmp_path: Path) -> None:
    result = read(tmp_path, comment.replace("{}", "const long A = 1;"))
    assert result.model.find(("A",)).doc == expected


def test_a_comment_can_make_a_key_as_before_annotations(tmp_path: Path) -> None:
    text = "struct S {\n    long a; //@key\n    long b; //@Key\n    long c; //@keys\n};"
    struct = read(tmp_path, text).model.declarations[0]
    assert isinstance(struct, Struct)
    assert [(m.name, m.key, m.doc) for m in struct.members] == [
        ("a", True, "@key"),
        ("b", True, "@Key"),
        ("c", False, "@keys"),
    ]


def test_docs_of_members(tmp_path: Path) -> None:
    result = read(
        tmp_path, "struct S {\n  /// One.\n  long a; ///< Two.\n  long b; // Three.\n};"
    )
    struct = result.model.find(("S",))
    assert isinstance(struct, Struct)
    assert [member.doc for member in struct.members] == ["One.\n\nTwo.", "Three."]


def test_component() -> None:
    result = load([GOLDEN / "components.idl"], root=GOLDEN)
    assert result.diagnostics == ()
    component = result.model.find(("Demo", "Follower"))
    assert isinstance(component, Component)
    assert component.doc == "Follows a path.\n\nMore about it."
    assert component.description == "Follows a path."
    assert (component.rate, component.max_instances, component.version) == (
        50.0,
        2,
        "1.2.3",
    )
    assert [(p.kind, p.name, p.identifier) for p in component.ports] == [
        (PortKind.INPORT, "status", "status"),
        (PortKind.OUTPORT, "status", "status"),
        (PortKind.OUTPORT, ".positon", "positon"),
        (PortKind.PROVIDER, "Stop", "Stop"),
        (PortKind.CONSUMER, "Other", "Other"),
    ]
    assert [p.port for p in component.ports[3:]] == ["Safety", "Safety"]
    assert [p.instance for p in component.ports[3:]] == ["stop", "FsmObject"]
    radius, first, gear, gains, file = component.configuration
    assert (radius.default, radius.minimum, radius.maximum) == (0.5, 0.0, 2.0)
    assert (radius.unit, radius.widget) == ("m", "slider.0.05")
    assert (first.name, first.identifier) == ("01_x", "first")
    assert gear.default == EnumeratorName(("Demo", "FAST"))
    assert gains.default == "1.0,2.0"
    assert file.default is None


def test_component_inherits() -> None:
    special = load([GOLDEN / "components.idl"], root=GOLDEN).model.find(
        ("Demo", "Special")
    )
    assert isinstance(special, Component)
    assert special.base == ("Demo", "Follower")
    assert len(special.ports) == 5
    assert [p.name for p in special.configuration][-2:] == ["file", "extra"]


def test_files_and_dependencies(tmp_path: Path) -> None:
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc" / "far.idl").write_text("struct Far { long a; };")
    (tmp_path / "near.idl").write_text("#pragma once\nstruct Near { long a; };")
    main = tmp_path / "main.idl"
    main.write_text('#include "near.idl"\n#include "near.idl"\n#include "far.idl"\n')
    result = load([main], root=tmp_path, include=[tmp_path / "inc"])
    assert result.diagnostics == ()
    assert [f.key for f in result.model.files] == [
        "near.idl",
        "inc/far.idl",
        "main.idl",
    ]
    assert [f.main for f in result.model.files] == [False, False, True]
    assert len(result.model.files[2].includes) == 2
    looked = {
        d.path.relative_to(tmp_path).as_posix(): d.sha256 for d in result.dependencies
    }
    assert looked.pop("far.idl") is None
    assert all(looked.values())
    assert set(looked) == {"main.idl", "near.idl", "inc/far.idl"}


def test_file_included_in_a_scope_belongs_to_its_includer(tmp_path: Path) -> None:
    result = read(
        tmp_path, 'module M {\n#include "part.idl"\n};', part="struct S { long a; };"
    )
    declaration = result.model.find(("M", "S"))
    part, whole = sorted(result.model.files, key=lambda file: file.main)
    assert declaration.file == whole.name
    assert part.belongs_to == whole.name
    assert declaration.span.file == part.name


def test_one_declaration_for_many_translation_units(tmp_path: Path) -> None:
    (tmp_path / "a.idl").write_text(
        "#ifndef A\n#define A\nstruct S { long x; };\n#endif\n"
    )
    (tmp_path / "b.idl").write_text('#include "a.idl"\nstruct T { S s_; };\n')
    paths = [tmp_path / "a.idl", tmp_path / "b.idl"]
    result = load(paths, root=tmp_path)
    assert result.diagnostics == ()
    assert [d.scoped for d in result.model.declarations] == ["S", "T"]


def test_different_declarations_in_two_files_are_reported(tmp_path: Path) -> None:
    (tmp_path / "a.idl").write_text("struct S { long x; };")
    (tmp_path / "b.idl").write_text("struct S { short x; };")
    result = load([tmp_path / "a.idl", tmp_path / "b.idl"], root=tmp_path)
    assert [d.code for d in result.diagnostics] == ["IDL0217"]


def test_a_macro_of_the_includer_changes_what_is_included(tmp_path: Path) -> None:
    (tmp_path / "a.idl").write_text("#ifdef WIDE\nstruct W { long x; };\n#endif\n")
    (tmp_path / "b.idl").write_text('#include "a.idl"\n')
    (tmp_path / "c.idl").write_text('#define WIDE\n#include "a.idl"\n')
    result = load([tmp_path / "b.idl", tmp_path / "c.idl"], root=tmp_path)
    assert [d.scoped for d in result.model.declarations] == ["W"]


def test_missing_file(tmp_path: Path) -> None:
    result = load([tmp_path / "no.idl", tmp_path], root=tmp_path)
    assert [d.code for d in result.diagnostics] == ["IDL0001", "IDL0001"]


def test_order_of_declarations(tmp_path: Path) -> None:
    text = "struct S { enum E { A } e_; }; interface I { typedef long T; void f(in T t_); };"
    result = read(tmp_path, text)
    assert [d.scoped for d in result.model.declarations] == ["S::E", "S", "I", "I::T"]


def test_values_and_types(tmp_path: Path) -> None:
    text = "enum E { X, Y }; const E C = Y; union U switch (E) { case X: default: long a; };"
    model = read(tmp_path, text).model
    constant = model.find(("C",))
    union = model.find(("U",))
    assert isinstance(constant, Const)
    assert isinstance(union, Union)
    assert constant.value == EnumeratorName(("Y",))
    assert constant.type == NamedType(("E",))
    assert union.cases[0].default
    assert union.cases[0].labels == (EnumeratorName(("X",)),)


def test_an_interface_that_is_never_defined_can_be_referred_to(tmp_path: Path) -> None:
    result = read(tmp_path, "interface I; struct S { I i_; };")
    assert isinstance(result.model.find(("I",)), Interface)


def test_names_outside_the_working_folder_are_only_inputs(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "outside.idl").write_text("struct S { long a; };")
    main = tmp_path / "deep" / "main.idl"
    main.write_text('#include "../outside.idl"\n')
    result = load([main], root=tmp_path / "deep")
    assert [file.key for file in result.model.files] == ["outside.idl", "main.idl"]


def test_what_a_file_includes_does_not_depend_on_other_units(tmp_path: Path) -> None:
    (tmp_path / "inner.idl").write_text("#pragma once\nstruct Inner { long a; };\n")
    (tmp_path / "outer.idl").write_text(
        '#pragma once\n#include "inner.idl"\nstruct Outer { Inner part; };\n'
    )
    # In the first unit the inner file is read before the outer one includes it.
    (tmp_path / "first.idl").write_text('#include "inner.idl"\n#include "outer.idl"\n')
    (tmp_path / "second.idl").write_text(
        '#include "outer.idl"\nstruct Both { Inner one; Outer two; };\n'
    )
    paths = [tmp_path / "first.idl", tmp_path / "second.idl"]
    assert not load(paths, root=tmp_path).diagnostics


def test_a_file_without_guard_is_read_once(tmp_path: Path) -> None:
    result = read(
        tmp_path,
        '#include "pose.idl"\n#include "time.idl"\nstruct Sample { Time stamp; Pose place; };',
        pose='#include "time.idl"\nstruct Pose { Time stamp; };',
        time="struct Time { long sec; };",
    )
    assert [d.scoped for d in result.model.declarations] == ["Time", "Pose", "Sample"]
    (found,) = result.diagnostics
    assert (found.code, found.severity) == ("IDL0024", Severity.NOTE)
    assert found.span is not None
    assert (found.span.line, found.message) == (
        2,
        "the file is included again, and has no include guard",
    )


def test_what_a_repeated_file_includes_is_still_read(tmp_path: Path) -> None:
    result = read(
        tmp_path,
        '#include "all.idl"\n#define MORE\n#include "all.idl"\nstruct Sample { B b; };',
        all='struct A { long a; };\n#ifdef MORE\n#include "more.idl"\n#endif',
        more="struct B { long b; };",
    )
    assert [d.scoped for d in result.model.declarations] == ["A", "B", "Sample"]


@pytest.mark.parametrize("names", [("user", "maker"), ("maker", "user")])
def test_an_interface_that_another_file_defines(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    (tmp_path / "user.idl").write_text(
        "interface Maker; interface User { void take(in Maker one); };"
    )
    (tmp_path / "maker.idl").write_text("interface Maker { void make(); };")
    result = load([tmp_path / f"{name}.idl" for name in names], root=tmp_path)
    assert not result.diagnostics
    maker = result.model.find(("Maker",))
    assert isinstance(maker, Interface)
    assert not maker.forward
    assert [operation.name for operation in maker.operations] == ["make"]


def test_what_is_only_declared_is_not_listed(tmp_path: Path) -> None:
    result = read(
        tmp_path, "interface I; valuetype V; interface J { void f(in I i_, in V v_); };"
    )
    assert [d["name"] for d in inspect(result.model, ())["declarations"]] == ["J"]
    assert "interface I" not in tree(result.model)


def test_files_that_declare_the_same(tmp_path: Path) -> None:
    """The first declaration is used if two files have the same; doc comments may differ."""
    for name, comment in (("left", "/** In Hz. */"), ("right", "")):
        (tmp_path / f"{name}.idl").write_text(
            f"module M {{ struct Clock {{ {comment} long rate; }}; typedef long Row[3]; }};\n"
            f"struct {name.title()} {{ M::Clock clock_; M::Row row_; }};"
        )
    result = load([tmp_path / "left.idl", tmp_path / "right.idl"], root=tmp_path)
    assert result.diagnostics == ()
    clock = result.model.find(("M", "Clock"))
    assert Path(clock.file).name == "left.idl"
    assert [d.scoped for d in result.model.declarations] == [
        *("M::Clock", "M::Row", "Left", "Right")
    ]


def test_a_name_that_is_unknown_in_many_places_is_one_finding(tmp_path: Path) -> None:
    uses = "".join(f"Speed v{number};\n" for number in range(6))
    result = read(tmp_path, f"struct S {{\n{uses}}}; interface I {{ Speed get(); }};")
    (found,) = result.diagnostics
    assert (found.code, found.message) == ("IDL0200", "Speed is unknown")
    assert [r.span.line for r in found.related] == [3, 4, 5]
    assert found.related[-1].label == "used here, too, and in 3 more places"
