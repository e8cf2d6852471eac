"""Definitions that are refused before a component is emitted, by rule."""

import pytest
from component_models import (
    BOOLEAN,
    DOUBLE,
    DOUBLES,
    LONG,
    MODE,
    OPTIONS,
    SPAN,
    STRING,
    component,
    model,
    parameter,
    port,
)
from msgspec.structs import replace

from rtgen.compiler.backends.components import rules
from rtgen.compiler.backends.components.backend import BACKEND
from rtgen.compiler.backends.components.checks import check
from rtgen.compiler.backends.profiles import rtc_profile
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    EnumeratorName,
    NamedType,
    Port,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
)
from rtgen.compiler.model.rtc_profile import EVENT

CLIP = EnumeratorName(("Safety", "CLIP"))
BELL = (Annotation(EVENT, (("name", "press"), ("source", "Off\a"))),)


def codes(*components: Component) -> list[str]:
    return [d.code for d in check(model(*components))]


SOUND = (
    port("inport", "status"),
    port("outport", "status", identifier="status_out"),
    port("provider", "brake", "Safety::Brake"),
    port("consumer", "brake", "Safety::Brake", identifier="other"),
    parameter(
        "01_x",
        DOUBLE,
        3.4,
        identifier="x",
        minimum=0.0,
        maximum=5.0,
        widget="slider.0.1",
    ),
    parameter("n", LONG, 2, constraint="(1,2,3)", widget="radio"),
    parameter("mode", MODE, CLIP, widget="radio"),
    parameter("first", MODE),
    parameter("on", BOOLEAN, True, widget="checkbox", constraint="(0,1)"),
    parameter("text", STRING, "a,b", widget="text"),
    parameter("gains", DOUBLES, "0.5, 1.5", constraint="x>0,1<=x<2"),
    parameter("empty", DOUBLES, widget="ordered_list", constraint="(1,2)"),
    parameter("spin", LONG, minimum=-1, maximum=1, widget="spin."),
)


def test_a_sound_component() -> None:
    assert (
        codes(component(*SOUND, version="1.2.0-rc1", created="2025-02-11T10:30:00.25Z"))
        == []
    )


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ({"name": "__init__"}, "RTC0101"),
        ({"name": "../evil"}, "RTC0101"),
        ({"name": "a" * 121}, "RTC0101"),
        ({"version": "one two"}, "RTC0103"),
        ({"version": "1:0"}, "RTC0103"),
        ({"version": ""}, "RTC0103"),
        ({"created": "2025-02-30T10:00:00"}, "RTC0104"),
        ({"updated": "yesterday"}, "RTC0104"),
        ({"updated": "2025-02-11"}, "RTC0104"),
        ({"activity": "NEVER"}, "RTC0105"),
        ({"component_type": "dynamic"}, "RTC0105"),
        ({"vendor": "a:b"}, "RTC0106"),
        ({"category": "a\nb"}, "RTC0106"),
        ({"rate": 0.0}, "RTC0107"),
        ({"rate": float("inf")}, "RTC0107"),
        ({"max_instances": -1}, "RTC0107"),
        ({"doc": "bell \a"}, "RTC0108"),
        ({"description": "\ud800"}, "RTC0108"),
        ({"version": "1\a"}, "RTC0108"),
    ],
)
def test_component(more: dict[str, object], code: str) -> None:
    assert codes(component(**more)) == [code]


def test_two_components_with_one_package() -> None:
    first, second = component(name="LineFollower"), component(name="Line_Follower")
    (found,) = check(model(first, second))
    assert found.code == "RTC0102"
    assert found.related


@pytest.mark.parametrize(
    ("items", "code"),
    [
        ([port("inport", "a"), port("inport", "a", identifier="b")], "RTC0201"),
        ([port("outport", "a"), port("outport", "a", identifier="b")], "RTC0201"),
        ([port("inport", "a", "Safety::Mode")], "RTC0202"),
        ([port("outport", "a", "Safety::Brake")], "RTC0202"),
        ([port("provider", "a", "RTC::Time")], "RTC0203"),
        ([port("consumer", "a", "Safety::Mode")], "RTC0203"),
        (
            [
                port("provider", "a", "Safety::Brake", port="P"),
                port("provider", "b", "Safety::Brake", port="P"),
            ],
            "RTC0204",
        ),
        ([port("inport", "\0")], "RTC0108"),
        ([replace(port("inport", "a"), annotations=BELL)], "RTC0108"),
    ],
)
def test_ports(items: list[Port], code: str) -> None:
    assert codes(component(*items)) == [code]


@pytest.mark.parametrize(
    ("item", "code"),
    [
        (parameter("a", NamedType(("RTC", "Time"))), "RTC0302"),
        (parameter("a", SequenceType(MODE)), "RTC0302"),
        (parameter("a", SequenceType(DOUBLES)), "RTC0302"),
        (parameter("a", PrimitiveType(Primitive.ANY)), "RTC0302"),
        (parameter("a", LONG, "x"), "RTC0303"),
        (parameter("a", LONG, 1.5), "RTC0303"),
        (parameter("a", LONG, 2**31), "RTC0303"),
        (parameter("a", LONG, True), "RTC0303"),
        (parameter("a", PrimitiveType(Primitive.OCTET), -1), "RTC0303"),
        (parameter("a", PrimitiveType(Primitive.FLOAT), 1e39), "RTC0303"),
        (parameter("a", DOUBLE, float("nan")), "RTC0303"),
        (parameter("a", DOUBLE, 10**400), "RTC0303"),
        (parameter("a", BOOLEAN, 1), "RTC0303"),
        (parameter("a", STRING, 1), "RTC0303"),
        (parameter("a", StringType(bound=2), "abc"), "RTC0303"),
        (parameter("a", MODE, "CLIP"), "RTC0303"),
        (parameter("a", MODE, EnumeratorName(("Safety", "NONE"))), "RTC0303"),
        (parameter("a", DOUBLES, 1.0), "RTC0303"),
        (parameter("a", DOUBLES, "1,two"), "RTC0303"),
        (parameter("a", SequenceType(DOUBLE, 1), "1,2"), "RTC0303"),
        (parameter("a", DOUBLE, 0.5, minimum=1.0), "RTC0304"),
        (parameter("a", DOUBLE, minimum=1.0), "RTC0304"),
        (parameter("a", DOUBLE, 9.0, maximum=1.0, constraint="x>0"), "RTC0304"),
        (parameter("a", LONG, 4, constraint="(1,2)"), "RTC0304"),
        (parameter("a", STRING, constraint="(a,b)"), "RTC0304"),
        (parameter("a", LONG, minimum=2, maximum=1), "RTC0305"),
        (parameter("a", LONG, minimum=0.5), "RTC0305"),
        (parameter("a", STRING, minimum=1), "RTC0305"),
        (parameter("a", LONG, maximum=2**40), "RTC0305"),
        (parameter("a", LONG, constraint="x>>1"), "RTC0306"),
        (parameter("a", STRING, "b", constraint="x>1"), "RTC0306"),
        (parameter("a", LONG, constraint="(a,b)"), "RTC0306"),
        (parameter("a", MODE, constraint="(CLIP,STOP)"), "RTC0306"),
        (parameter("a", LONG, widget="knob"), "RTC0307"),
        (parameter("a", LONG, widget="slider.0"), "RTC0307"),
        (parameter("a", LONG, widget="slider"), "RTC0307"),
        (parameter("a", LONG, widget="spin.0"), "RTC0307"),
        (parameter("a", LONG, widget="spin.x"), "RTC0307"),
        (parameter("a", LONG, widget="text.1"), "RTC0307"),
        (parameter("a", LONG, widget="spin"), "RTC0308"),
        (parameter("a", LONG, widget="spin.2"), "RTC0308"),
        (parameter("a", LONG, widget="slider.1", minimum=0), "RTC0308"),
        (parameter("a", LONG, widget="radio"), "RTC0308"),
    ],
)
def test_configuration(item: ConfigurationParameter, code: str) -> None:
    assert codes(component(item)) == [code]


def test_two_parameters_of_one_name() -> None:
    items = parameter("a", LONG), parameter("a", LONG, identifier="b")
    assert codes(component(*items)) == ["RTC0301"]


def test_several_findings_in_one_run() -> None:
    found = codes(
        component(
            port("inport", "a", "Safety::Mode"), parameter("p", LONG, "x"), rate=-1.0
        )
    )
    assert found == ["RTC0107", "RTC0202", "RTC0303"]


def test_nothing_is_emitted_for_errors() -> None:
    broken = model(component(version="1: 0"))
    for backend in (BACKEND, rtc_profile.BACKEND):
        emission = backend.emit(broken, OPTIONS)
        assert not emission.artifacts
        assert [(d.code, d.span) for d in emission.diagnostics] == [("RTC0103", SPAN)]


def test_components_of_included_files_are_left_to_them() -> None:
    included = component(file="inc/Types.idl", version="?")
    assert check(model(included)) == []


def test_rules_are_distinguished() -> None:
    assert len({rule.code for rule in rules.RULES}) == len(rules.RULES)
    assert all(rule.explanation.endswith("\n") and rule.title for rule in rules.RULES)
    warnings = {r.code for r in rules.RULES if r.severity is Severity.WARNING}
    assert warnings == {"RTC0110", "RTC0308"}
