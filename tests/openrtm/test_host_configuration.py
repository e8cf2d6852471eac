"""Configuration parameters: rtgen converts texts, at the times of OpenRTM."""

from __future__ import annotations

import logging
from typing import Any

import pytest
from hosting import Relay
from openrtm_lab import Lab

DEFAULTS = {
    "gain": "2.0",
    "on": "1",
    "note": "",
    "level": "5",
    "gains": "0.1, 0.2",
    "nothing": "",
    "speed": "SLOW",
    "properties": "x",
}


def sets(relay: Relay) -> dict[str, dict[str, str]]:
    """Return the configuration sets as tools see them."""
    configuration = relay.rtc.getObjRef().get_configuration()
    return {
        found.id: {each.name: each.value.value() for each in found.configuration_data}
        for found in configuration.get_configuration_sets()
    }


def test_tools_see_the_definition(relay: Relay) -> None:
    configured = sets(relay)
    assert configured["default"] == DEFAULTS
    assert configured["__widget__"]["gain"] == "slider.0.1"
    assert configured["__constraints__"] == {
        "gain": "0.0<=x<=10.0",
        "level": "0<=x<=9",
        "speed": "(SLOW,FAST)",
    }
    assert configured["__type__"]["gains"] == "std::vector<double>"


def test_defaults(relay: Relay) -> None:
    config = relay.behaviour.config
    assert (config.gain, config.on, config.note, config.level) == (2.0, True, "", 5)
    assert (config.gains, config.nothing) == ([0.1, 0.2], [])
    assert (config.speed.name, config.properties) == ("SLOW", "x")
    assert relay.rtc._c_gain == [2.0]
    assert relay.rtc.getInstanceName()  # its own properties are untouched


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("gain", "3", 3.0),
        ("gain", " 3.5e0 ", 3.5),
        ("on", "false", False),
        ("on", "0", False),
        ("on", "OFF", False),
        ("note", "こんにちは", "こんにちは"),
        ("level", "+7", 7),
        ("gains", "1,2 , 3", [1.0, 2.0, 3.0]),
        ("gains", "", []),
        ("nothing", "4", [4]),
        ("speed", "FAST", 1),
        ("properties", "y", "y"),
    ],
)
def test_a_value_is_there_at_the_next_callback(
    relay: Relay, name: str, text: str, value: Any
) -> None:
    seen = []

    def note() -> int:
        seen.append(getattr(relay.behaviour.config, name))
        return 0

    old = getattr(relay.behaviour.config, name)
    relay.activate()
    relay.answer("on_execute", note)
    relay.configure(**{name: text})
    assert getattr(relay.behaviour.config, name) == old
    relay.tick()
    relay.tick()
    assert seen == [old, value]
    assert sets(relay)["default"][name] == text


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("gain", "fast", "it must be a number"),
        ("gain", "10.5", "it must be at most 10.0 m"),
        ("on", "maybe", "it must be true or false"),
        ("level", "0x07", "it must be a decimal integer"),
        ("level", "1.0", "it must be a decimal integer"),
        ("level", "-1", "its constraint is 0<=x<=9"),
        ("gains", "1,two", "element 2"),
        ("speed", "RAPID", "it must be one of SLOW, FAST"),
    ],
)
def test_a_text_that_is_no_value_leaves_the_old_one(
    relay: Relay, name: str, text: str, reason: str, caplog: pytest.LogCaptureFixture
) -> None:
    relay.activate()
    relay.configure(gain="4.0", level="6")
    relay.tick()
    relay.tick()
    before = getattr(relay.behaviour.config, name)
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        relay.configure(**{name: text})
        relay.tick()
        relay.tick()
    assert getattr(relay.behaviour.config, name) == before
    assert reason in caplog.text


def test_an_empty_default_is_bound(relay: Relay) -> None:
    assert relay.behaviour.config.note == ""
    relay.configure(note="something")
    relay.activate()
    assert relay.behaviour.config.note == "something"
    relay.configure(note="")
    relay.tick()
    relay.tick()
    assert relay.behaviour.config.note == ""


def test_an_inactive_component_takes_it_over_when_it_is_activated(
    relay: Relay,
) -> None:
    seen = []

    def note() -> int:
        seen.append(relay.behaviour.config.gain)
        return 0

    relay.answer("on_activated", note)
    relay.configure(gain="4.5")
    relay.activate()
    assert seen == [4.5]


def test_a_behaviour_is_notified_once_of_several_changes(relay: Relay) -> None:
    notified = []
    relay.behaviour.configuration_sets.on_change = lambda: notified.append(
        relay.behaviour.config.gain
    )
    relay.activate()
    relay.configure(gain="4.5", level="1")
    relay.tick()
    relay.tick()
    assert notified == [4.5]


def test_values_of_the_instance(relay_module: Any, lab: Lab) -> None:
    made = Relay(
        lab.create("Relay?instance_name=Set0&conf.default.gain=7.5&conf.mode.gain=1.5"),
        lab,
    )
    assert made.behaviour.config.gain == 7.5
    configuration = made.rtc.getObjRef().get_configuration()
    configuration.activate_configuration_set("mode")
    made.activate()
    assert made.behaviour.config.gain == 1.5
    assert made.behaviour.config.level == 5


def test_the_profile_is_the_definitions(relay: Relay) -> None:
    profile = relay.rtc.getObjRef().get_component_profile()
    assert profile.type_name == "Relay"
    assert (profile.category, profile.vendor) == ("Tests", "rtgen")
    assert (profile.version, profile.description) == ("1.2.0", "Relay, 中継")
