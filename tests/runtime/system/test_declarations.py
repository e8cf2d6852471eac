"""Ports and parameters declared in the class of a component."""

from __future__ import annotations

from enum import IntEnum

import pytest

from refrobots import rtc
from refrobots.canopen import Manager
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    Configuration,
    ConfigurationError,
    DuplicatePortError,
    InPort,
    ParameterProfile,
    System,
    configuration,
    consumer,
    inport,
    outport,
    parameter,
    provider,
)


class Sort(IntEnum):
    """An enumeration."""

    LEFT = 0


class Gains(Configuration):
    """Parameters of Lamp."""

    p: float = parameter(
        0.5,
        """Proportional gain.
        Of the inner loop.
        """,
        minimum=0.0,
        unit="1/s",
    )
    steps: int = parameter(3, type="short", name="loop.steps")
    on: bool = parameter(True)
    limits: list[float] = parameter([1.0, 2.5], type="sequence<double>")


class Lamp(Component, type_name="Lamp", category="Demo", rate=100.0):
    config = configuration(Gains)
    target = inport(rtc.TimedDouble, "Brightness.\nOf the lamp.", unit="cd")
    positon = outport(rtc.TimedLong, name=".positon")
    service = provider(Manager, port="Lamp", type_name="Lab::Boss")
    other = consumer(Manager)


def test_the_profile_follows_from_the_declarations() -> None:
    profile = Lamp.profile
    assert (profile.type_name, profile.category, profile.rate) == ("Lamp", "Demo", 100)
    assert [(p.kind, p.name, p.python_name, p.type) for p in profile.ports] == [
        ("inport", "target", "target", "RTC::TimedDouble"),
        ("outport", ".positon", "positon", "RTC::TimedLong"),
        ("provider", "service", "service", "CANopen::Manager"),
        ("consumer", "other", "other", "CANopen::Manager"),
    ]
    assert [(p.port, p.instance, p.type_name) for p in profile.ports] == [
        ("", "", ""),
        ("", "", ""),
        ("Lamp", "service", "Lab::Boss"),
        ("other", "other", ""),
    ]
    assert profile.ports[0].description == "Brightness."
    assert profile.ports[0].unit == "cd"
    assert profile.ports[0].repository_id == "IDL:RTC/TimedDouble:1.0"
    assert profile.configuration == (
        ParameterProfile(
            *("p", "p", "double", "0.5", 0.0),
            unit="1/s",
            description="Proportional gain.",
        ),
        ParameterProfile("loop.steps", "steps", "short", "3"),
        ParameterProfile("on", "on", "boolean", "1"),
        ParameterProfile("limits", "limits", "sequence<double>", "1.0,2.5"),
    )


def test_each_instance_has_its_own_ports_and_values() -> None:
    one, two = Lamp("Lamp0"), Lamp("Lamp1")
    assert isinstance(one.target, InPort)
    assert one.in_ports == {"target": one.target}
    assert one.out_ports == {".positon": one.positon}
    assert one.providers == {("Lamp", "service"): one.service}
    assert one.consumers == {("other", "other"): one.other}
    assert one.target is not two.target
    one.config.limits.append(3.0)
    assert two.config == Gains()
    with System() as system:
        system.add(one)
        one.configuration_sets.set("loop.steps", "7")
        system.run(until_ns=1_000_000_000)
        assert (one.config.steps, two.config.steps) == (7, 3)


def test_a_subclass_inherits_and_adds() -> None:
    class Dimmer(Gains):
        """Further parameters; another default of an inherited one."""

        p: float = 2.0
        name: str = parameter("left")

    class Behaviour(Lamp):
        def on_execute(self, ec_id: int) -> int:  # type: ignore[override]
            return RTC_OK

    class Wide(Lamp, type_name="Wide"):
        config = configuration(Dimmer)
        target = inport(rtc.TimedDouble, unit="lm")
        more = inport(rtc.TimedLong)

    assert Behaviour.profile is Lamp.profile
    wide = Wide()
    assert wide.instance_name == "Wide0"
    assert Wide.profile.category == "Demo"
    assert [p.name for p in Wide.profile.ports] == [
        *("target", ".positon", "service", "other", "more"),
    ]
    assert Wide.profile.ports[0].unit == "lm"
    assert [(p.name, p.default) for p in Wide.profile.configuration] == [
        ("p", "2.0"),
        ("loop.steps", "3"),
        ("on", "1"),
        ("limits", "1.0,2.5"),
        ("name", "left"),
    ]
    assert (wide.config.p, wide.config.name, Lamp().config.p) == (2.0, "left", 0.5)
    assert wide.configuration_sets.texts()["p"] == "2.0"
    assert Wide.profile.configuration[0].minimum == 0.0


def test_declarations_of_several_bases_are_joined() -> None:
    class Speaking(Component):
        said = outport(rtc.TimedLong)

    class Hearing(Component):
        heard = inport(rtc.TimedLong)

    class Both(Speaking, Hearing):
        own = outport(rtc.TimedLong)

    both = Both()
    assert [*both.out_ports] == ["said", "own"]
    assert [*both.in_ports] == ["heard"]
    assert {p.name for p in Both.profile.ports} == {"said", "heard", "own"}


def test_a_written_profile_and_ports_added_by_the_constructor() -> None:
    class Old(Component):
        profile = ComponentProfile("Old", rate=5.0)

        def __init__(self, instance_name: str | None = None) -> None:
            super().__init__(instance_name)
            self.a = self.add_in_port("a", rtc.TimedLong)

    assert Old.profile.rate == 5.0
    assert [*Old().in_ports] == ["a"]


def test_two_ports_of_one_name_are_refused() -> None:
    class Twice(Component, type_name="Twice"):
        a = inport(rtc.TimedLong)
        b = inport(rtc.TimedLong, name="a")

    with pytest.raises(DuplicatePortError, match=r"has a port Twice0\.a already"):
        Twice()


def test_unknown_facts_are_refused() -> None:
    with pytest.raises(TypeError, match="colour"):

        class Wrong(Component, colour="red"):
            pass


@pytest.mark.parametrize("default", [[1.0], Sort.LEFT, 1j])
def test_a_default_without_a_type_of_its_own_needs_one(default: object) -> None:
    with pytest.raises(ConfigurationError, match="parameter 'p' does not state"):

        class Wrong(Configuration):
            p: object = parameter(default)
