"""Components under test: those of the reference build, and a project with everything else."""

from __future__ import annotations

import os
import re
import shutil
from importlib import import_module
from pathlib import Path

from middleware import DATA_TYPES

from rtgen.cli import run
from rtgen.compiler.project.output import component_types
from rtgen.runtime import Component

GENERATED = Path(__file__).parents[2] / "generated"


BEHAVIOURS = component_types(GENERATED).factories
"""The factory of every component of the reference build, `module:name`."""

SETTINGS = """
[sources]
paths = ["idl"]
include = ["stock"]

[output]
target = "openrtm"
package = "conformed"
skeletons = "src/conforming"
"""
OTHERS = {name: f"conforming.{name.lower()}:{name}" for name in ("Limiter", "Stock")}
"""Components of a project made for these tests, with their skeletons as behaviours."""

UNREADABLE = {"TimedWChar", "TimedWCharSeq"}
"""omniORBpy 4.3 cannot read a wchar that it has written."""


def stock_types() -> list[str]:
    """Return the structs of OpenRTM's own files that have a time stamp."""
    found = []
    for file in sorted(DATA_TYPES.glob("*DataType*.idl")):
        text = file.read_text(encoding="utf-8")
        found += re.findall(r"struct (\w+)\s*\{[^}]*?\bTime tm;", text)
    return [name for name in found if name not in UNREADABLE]


def stock_component() -> str:
    """Return a component with an InPort and an OutPort of each type."""
    ports = [
        f"    consumes RTC::{name} in_{name};\n    publishes RTC::{name} out_{name};\n"
        for name in stock_types()
    ]
    return (
        '#include "InterfaceDataTypes.idl"\n'
        '@rtc(category="Tests", vendor="tests", description="Every type", rate=100.0)\n'
        "component Stock {\n" + "".join(ports) + "};\n"
    )


def make_project(folder: Path) -> Path:
    """Generate a project with the other components; return its output folder."""
    (folder / "idl").mkdir()
    (folder / "rtgen.toml").write_text(SETTINGS)
    (folder / "idl/Stock.idl").write_text(stock_component())
    shutil.copy(Path(__file__).with_name("limiter.idl"), folder / "idl")
    (folder / "stock").symlink_to(DATA_TYPES)
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert run(["generate", "-q"]) == 0
    finally:
        os.chdir(before)
    return folder / "generated"


def component_of(name: str) -> Component:
    """Return an embedded component by its definition, with additions of the behaviour."""
    module, _, attribute = {**BEHAVIOURS, **OTHERS}[name].partition(":")
    made: Component = getattr(import_module(module), attribute)(f"{name}0")
    return made
