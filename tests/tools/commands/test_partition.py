"""`--only`: the remaining part of a system, its timeline and its conditions."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.model import Connection, PortReference, System, SystemComponent
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.measures import parse
from rtgen.compiler.systems.timeline import (
    Connect,
    Disconnect,
    SetParameter,
    StateRequest,
    Step,
)
from rtgen.tools.running import partition

PLACE = Span("s.xml", 1, 1, 1, 2)


def port(text: str) -> PortReference:
    instance, _, name = text.partition(".")
    return PortReference(instance=instance, port=name)


def link(name: str, source: str, target: str, *, service: bool = True) -> Connection:
    ends = {"source": port(source), "target": port(target)}
    return Connection(name=name, service=service, span=PLACE, **ends)


def system(*connections: Connection) -> System:
    parts = [
        SystemComponent(instance=name, type="T", id="", path_uri="", span=PLACE)
        for name in ("A0", "B0", "C0")
    ]
    return System(
        name="s",
        id="",
        file="s.xml",
        abstract="",
        components=tuple(parts),
        connections=connections,
        properties=(
            ("rtgen.run.pose", "B0.pose"),
            ("rtgen.run.goal", "A0.goal"),
            ("rtgen.run.until", "B0=ERROR,5"),
            ("rtgen.run.tolerance", "0.05"),
        ),
    )


def test_components_connections_and_properties() -> None:
    whole = system(
        link("ab", "A0.x", "B0.x"),
        link("bc", "B0.y", "C0.y"),
        link("aa", "A0.out", "A0.in", service=False),
        link("bb", "B0.out", "B0.in", service=False),
    )
    here = partition.named(" A0 ", whole)
    part = partition.share(whole, here)
    assert [c.instance for c in part.components] == ["A0"]
    assert [c.name for c in part.connections] == ["ab", "aa"]
    assert dict(part.properties) == {
        "rtgen.run.goal": "A0.goal",
        "rtgen.run.until": "B0=ERROR,5",
    }
    assert partition.share(whole, partition.named("A0,B0,C0", whole)) == whole


def test_of_several_robots_those_of_the_process_are_shown_and_measured() -> None:
    poses = (("rtgen.run.pose", "A0.truth, B0.truth,C0.truth"),)
    whole = replace(system(), properties=poses)
    part = partition.share(whole, {"A0", "C0"})
    assert part.properties == (("rtgen.run.pose", "A0.truth, C0.truth"),)
    alone, far = (
        parse({"name": "m", "kind": "moved", "of": f"{name}.truth"}, lambda _: PLACE)
        for name in ("A0", "B0")
    )
    both = {"name": "m", "kind": "alike", "of": "A0.truth", "to": "B0.truth"}
    measures = [alone, far, parse(both, lambda _: PLACE)]
    assert partition.measures_here(measures, {"A0", "C0"}) == [alone]


@pytest.mark.parametrize("text", ["D0", "A0,D0", "", "A0,,B0"])
def test_unknown_names(text: str) -> None:
    with pytest.raises(InputError) as caught:
        partition.named(text, system())
    assert [d.code for d in caught.value.diagnostics] == ["SYS0005"]


def test_data_between_processes() -> None:
    crossing = [
        link("one", "A0.out", "B0.in", service=False),
        link("two", "C0.out", "A0.in", service=False),
    ]
    with pytest.raises(InputError) as caught:
        partition.share(system(*crossing), {"A0"})
    assert [d.code for d in caught.value.diagnostics] == ["SYS0009"] * 2
    assert caught.value.diagnostics[0].span == PLACE


def step(action: Any) -> Step:
    return Step(0, action, PLACE)


def test_steps_of_a_timeline() -> None:
    whole = system(link("ab", "A0.x", "B0.x"), link("bc", "B0.y", "C0.y"))
    ends = port("B0.y"), port("A0.y")
    mine = [
        step(StateRequest("activate", "A0")),
        step(SetParameter("A0", "p", "1")),
        step(Disconnect("ab")),
        step(Connect("new", *ends, {})),
        step(Disconnect("new")),
    ]
    others = [
        step(StateRequest("activate", "B0")),
        step(SetParameter("C0", "p", "1")),
        step(Disconnect("bc")),
        step(Connect("other", port("B0.z"), port("C0.z"), {})),
        step(Disconnect("other")),
    ]
    mixed = [s for pair in zip(mine, others, strict=True) for s in pair]
    assert partition.steps_here(mixed, whole, {"A0"}) == mine


def test_a_step_that_connects_data_ports_of_two_processes() -> None:
    whole = system(link("data", "B0.out", "A0.in", service=False))
    again = step(Connect("data", port("B0.out"), port("A0.in"), {}))
    with pytest.raises(InputError) as caught:
        partition.steps_here([again], whole, {"A0"})
    assert [d.code for d in caught.value.diagnostics] == ["SYS0009"]


def test_conditions_and_values() -> None:
    condition = Condition(5, "B0", "ERROR")
    assert partition.condition_here(condition, {"B0"}, asked=True) == condition
    assert partition.condition_here(condition, {"A0"}, asked=False) == Condition(5)
    assert partition.condition_here(Condition(5), {"A0"}, asked=True) == Condition(5)
    with pytest.raises(InputError, match="SYS0009"):
        partition.condition_here(condition, {"A0"}, asked=True)
    value = SetParameter("B0", "p", "1")
    partition.require_here([value], {"B0"})
    with pytest.raises(InputError, match="--set: B0 is not among"):
        partition.require_here([value], {"A0"})
