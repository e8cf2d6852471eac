"""Each fact of a component, an instance and a bus is compared, or is none of the definition's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Component, Model, System, SystemComponent
from rtgen.compiler.model.can_bus import Bus
from rtgen.tools.diff.buses import compare_buses
from rtgen.tools.diff.changes import Change
from rtgen.tools.diff.components import compare_components
from rtgen.tools.diff.systems import compare_systems
from rtgen.tools.diff.versions import Version

SPAN = Span("a.idl", 1, 1, 1, 2)
COMPONENT = Component(
    name=("Lamp",), repository_id="IDL:Lamp:1.0", file="a.idl", span=SPAN
)
INSTANCE = SystemComponent(
    instance="Lamp0", type="Lamp", id="RTC:a:b:Lamp:1.0", path_uri="", span=SPAN
)
BUS = Bus(
    *(), name="arm", file="arm.toml", key="arm.toml", sha256="", bit_rate=500, manager=1,
    sync=0.0, heartbeat=0.0, event=0.0, kinds=(), nodes=(), links=(),
)  # fmt: skip


def _components(old: Any, new: Any) -> Iterator[Change]:
    one, other = (Version(Model(declarations=(each,))) for each in (old, new))
    return compare_components(one, other, {})


def _instances(old: Any, new: Any) -> Iterator[Change]:
    one, other = (
        Version(Model(systems=(replace(SYSTEM, components=(each,)),)))
        for each in (old, new)
    )
    return compare_systems(one, other)


def _buses(old: Any, new: Any) -> Iterator[Change]:
    one, other = (Version(Model(buses=(each,))) for each in (old, new))
    return compare_buses(one, other)


SYSTEM = System(
    *(), name="s", id="RTSystem:a:s:1", file="s.xml", key="s.xml", sha256="",
    abstract="", components=(), connections=(), activation=(),
)  # fmt: skip

PLACES = {"span", "file", "key", "sha256", "places"}
"""Where a definition is."""
NAMES = {"name", "instance", "repository_id"}
"""Another name is another item."""
TABLES = {"ports", "configuration", "annotations", "kinds", "nodes", "links"}
"""Compared item by item."""
NONE = {
    *("created", "updated", "doc", "language"),  # profile texts
    *("runtime_base", "configuration_base", "factory", "module", "other_file"),
    "kind",  # of the component's execution context, which has it from its definition
    "conf_files",  # where the configuration was read from
}
"""No fact of the definition, but of its text, or of what is generated for it."""

CASES: list[tuple[Any, Callable[[Any, Any], Iterator[Change]]]] = [
    (COMPONENT, _components),
    (INSTANCE, _instances),
    (BUS, _buses),
]


def _other(name: str, value: object) -> object:
    match value:
        case bool():
            return not value
        case int() | float():
            return value + 1
        case str():
            return value + "x"
    return {
        "base": ("Lights", "Lamp"),
        "supports": (("Lights", "Switch"),),
        "location": (1, 2, 3, 4),
        "rate": 10.0,
    }[name]


@pytest.mark.parametrize(
    ("item", "compare", "name"),
    [
        pytest.param(
            item, compare, field.name, id=f"{type(item).__name__}-{field.name}"
        )
        for item, compare in CASES
        for field in msgspec.structs.fields(item)
        if field.name not in PLACES | NAMES | TABLES | NONE
    ],
)
def test_each_fact_is_compared(
    item: Any, compare: Callable[[Any, Any], Iterator[Change]], name: str
) -> None:
    before = getattr(item, name)
    assert [*compare(item, item)] == []
    assert [*compare(item, replace(item, **{name: _other(name, before)}))]
