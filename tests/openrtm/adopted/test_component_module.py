"""The text of modules: name clashes of any kind, and black's form."""

from __future__ import annotations

import ast
from pathlib import Path

import black
import pytest
from test_plan import OPTIONS, planned

from rtgen.compiler.frontends.idl import load
from rtgen.openrtm.backend.backend import BACKEND
from rtgen.openrtm.backend.component_module import component_module

LONG = "A_very_long_name_" + "x" * 100

HOSTILE = f"""
module path {{
    struct main {{ long value; }};
    interface profile {{ void call(); }};
}};
module place {{
    struct {LONG} {{ long value; }};
    interface Any_service {{ void call(); }};
}};
struct Path_data {{ long value; }};
interface manager {{ void call(); }};

component Host {{
    consumes path::main RTC;
    publishes path::main sys;
    publishes place::{LONG} {LONG}_out;
    consumes Path_data self;
    consumes Path_data lambda;
    provides path::profile main;
    provides place::Any_service stubs;
    uses manager Any;
    attribute long properties;
    attribute string configsets;
    attribute sequence<string> rtcout;
    attribute double {LONG};
}};
"""


def test_names_that_clash(tmp_path: Path) -> None:
    (plan,), found = planned(tmp_path, hostile=HOSTILE)
    assert found == []
    text = component_module(plan)
    assert black.format_str(text, mode=black.Mode()) == text
    tree = ast.parse(text)
    bound: dict[str, ast.AST] = {}
    for node in tree.body:
        names = []
        match node:
            case ast.Import() | ast.ImportFrom():
                names = [alias.asname or alias.name for alias in node.names]
            case ast.ClassDef() | ast.FunctionDef():
                names = [node.name]
        for name in names:
            assert name not in bound, name
            bound[name] = node
    for name in ("Host_", "HostInit", "MyModuleInit"):
        assert name in bound
    members = {
        target.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in getattr(node, "targets", None) or [node.target]
        if isinstance(target, ast.Attribute)
    }
    assert members.isdisjoint({"_properties", "_configsets", "_rtcout", "_profile"})


def test_a_factory_that_is_an_attribute(tmp_path: Path) -> None:
    from msgspec.structs import replace

    options = replace(OPTIONS, factories={"Relay": "own.parts:Relays.make"})
    (plan,), _ = planned(tmp_path, options, a="component Relay {};")
    text = component_module(plan)
    assert "from own.parts import Relays as RelaysBehaviour\n" in text
    assert "Host(self, RelaysBehaviour.make)" in text


def test_a_component_without_anything(tmp_path: Path) -> None:
    (plan,), _ = planned(tmp_path, a="component Nothing {};")
    text = component_module(plan)
    assert black.format_str(text, mode=black.Mode()) == text
    assert "stubs" not in text


@pytest.mark.parametrize("name", ["RTC", "OpenRTM_aist", "queue", "rtgen"])
def test_a_module_hides_none_that_it_needs(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.idl").write_text(f"component {name} {{}};")
    model = load([tmp_path / "a.idl"], root=tmp_path).model
    assert "RTC0566" in [d.code for d in BACKEND.emit(model, OPTIONS).diagnostics]


def test_an_in_port_and_an_out_port_of_one_identifier(tmp_path: Path) -> None:
    (plan,), _ = planned(
        tmp_path,
        a="struct T { long x; }; component C { consumes T data; publishes T data; };",
    )
    text = component_module(plan)
    assert 'self._dataIn = OpenRTM_aist.InPort("data", self._d_data)\n' in text
    assert 'self._data_Out = OpenRTM_aist.OutPort("data_out", self._d_data_)\n' in text


def test_ports_and_parameters_have_members_of_their_own(tmp_path: Path) -> None:
    """Also if their names become equal as identifiers."""
    (plan,), _ = planned(
        tmp_path,
        a="""struct T { long x; }; interface I { void go(); };
        component C {
            @port("a b") provides I one; @port("a_b") provides I two;
            consumes T c_x; attribute long xIn; consumes T a_bPort;
        };""",
    )
    tree = ast.parse(component_module(plan))
    members = [
        target.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name == "__init__"
        for statement in node.body
        if isinstance(statement, ast.Assign | ast.AnnAssign)
        for target in getattr(statement, "targets", None) or [statement.target]
    ]
    assert len(members) == len(set(members)) == 1 + 2 * 2 + 2 + 1
