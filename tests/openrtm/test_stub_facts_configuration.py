"""Verified facts about parameters and configuration sets of OpenRTM-aist-Python 2.1."""

from __future__ import annotations

from typing import Any

import pytest
from openrtm_lab import Lab, answers


def bound(lab: Lab, initial: Any, default: str, *sets: str, **callbacks: Any) -> Any:
    """Return a component with the variable `x` bound to the parameter `x`."""
    import RTC

    def initialize(self: Any) -> Any:
        self.x = [initial]
        self.bound = self.bindParameter("x", self.x, default)
        return RTC.RTC_OK

    return lab.component(*sets, onInitialize=initialize, **callbacks)


def written(lab: Lab, initial: Any, default: str, text: str) -> Any:
    """Return the variable after a text was set and the component activated."""
    component = bound(lab, initial, default, "conf.default.x", default)
    assert lab.rtm.set_configuration(component.getObjRef(), "default", "x", text)
    lab.activate(component)
    return component.x[0]


@pytest.mark.parametrize(
    ("initial", "default", "text", "value"),
    [
        (0, "3", "4", 4),
        (0, "3", "-4", -4),
        (0, "3", "0x10", 3),
        (0, "3", "1.0", 3),
        (0.0, "3", "4", 4.0),
        (0.0, "3", "1e-3", 0.001),
        (0.0, "3", "fast", 3.0),
        ("", "a", "b, c", "b, c"),
        ([0], "1", "1, 2 ,3", [1, 2, 3]),
        ([0.0], "1", "1,2.5", [1.0, 2.5]),
        ([""], "a", "a, b", ["a", "b"]),
        ([0], "7", "1,x", [7]),
        (False, "0", "1", 1),
        (False, "0", "true", 0),
    ],
)
def test_texts_convert_by_the_type_of_the_variable(
    lab: Lab, initial: Any, default: str, text: str, value: Any
) -> None:
    found = written(lab, initial, default, text)
    assert found == value
    assert type(found) is type(value)


def test_a_text_that_does_not_convert_gives_the_default_not_the_value_before(
    lab: Lab,
) -> None:
    component = bound(lab, 0, "3", "conf.default.x", "5")
    assert component.x == [5]
    lab.rtm.set_configuration(component.getObjRef(), "default", "x", "five")
    lab.activate(component)
    assert component.x == [3]


def test_an_empty_default_is_not_bound(lab: Lab) -> None:
    component = bound(lab, "old", "", "conf.default.x", "set")
    assert component.bound
    lab.rtm.set_configuration(component.getObjRef(), "default", "x", "new")
    lab.activate(component)
    assert component.x == ["old"]


def test_a_converter_of_ones_own(lab: Lab) -> None:
    import RTC

    def trans(old: Any, text: str) -> tuple[bool, Any]:
        return text in ("yes", "no"), text == "yes"

    def initialize(self: Any) -> Any:
        self.x = [False]
        self.bindParameter("x", self.x, "no", trans)
        return RTC.RTC_OK

    component = lab.component("conf.default.x", "no", onInitialize=initialize)
    lab.rtm.set_configuration(component.getObjRef(), "default", "x", "yes")
    lab.activate(component)
    assert component.x == [True]


def test_a_variable_changes_at_activation_and_after_updates_only(lab: Lab) -> None:
    import RTC

    seen: list[tuple[str, int]] = []

    def note(name: str) -> Any:
        def callback(self: Any, ec_id: int) -> Any:
            seen.append((name, self.x[0]))
            return RTC.RTC_OK

        return callback

    component = bound(
        lab,
        0,
        "1",
        "conf.default.x",
        "1",
        onActivated=note("activated"),
        onExecute=note("execute"),
        onStateUpdate=note("update"),
    )
    reference = component.getObjRef()
    lab.rtm.set_configuration(reference, "default", "x", "2")
    assert component.x == [1]
    lab.activate(component)
    assert seen[0] == ("activated", 2)
    seen.clear()
    lab.rtm.set_configuration(reference, "default", "x", "3")
    assert component.x == [2]
    lab.tick(component)
    assert seen == [("execute", 2), ("update", 2)]
    assert component.x == [3]


def test_a_variable_changes_after_on_error(lab: Lab) -> None:
    import RTC

    component = bound(
        lab, 0, "1", "conf.default.x", "1", onExecute=answers(RTC.RTC_ERROR)
    )
    lab.activate(component)
    lab.tick(component)
    lab.rtm.set_configuration(component.getObjRef(), "default", "x", "2")
    assert component.x == [1]
    lab.tick(component)
    assert component.x == [2]


def test_values_wait_for_their_set_to_be_activated(lab: Lab) -> None:
    component = bound(lab, 0, "1", "conf.default.x", "1")
    configuration = component.getObjRef().get_configuration()
    values = configuration.get_configuration_set("default")
    values.configuration_data = [lab.rtm.NVUtil.newNV("x", "2")]
    configuration.set_configuration_set_values(values)
    lab.activate(component)
    assert component.x == [1]
    configuration.activate_configuration_set("default")
    lab.tick(component)
    assert component.x == [2]


def test_the_active_set_is_named_by_a_property(lab: Lab) -> None:
    component = bound(
        lab,
        0,
        "1",
        *("conf.default.x", "1", "conf.fast.x", "9"),
        *("configuration.active_config", "fast"),
    )
    assert component.x == [9]
    name = lab.rtm.get_active_configuration_name(component.getObjRef())
    assert name == "fast"


def test_sets_are_added_activated_and_removed(lab: Lab) -> None:
    import SDOPackage

    component = bound(lab, 0, "1", "conf.default.x", "1")
    configuration = component.getObjRef().get_configuration()
    added = SDOPackage.ConfigurationSet("slow", "", [lab.rtm.NVUtil.newNV("x", "4")])
    assert configuration.add_configuration_set(added)
    assert configuration.activate_configuration_set("slow")
    lab.activate(component)
    assert component.x == [4]
    assert configuration.activate_configuration_set("default")
    assert configuration.remove_configuration_set("slow")
    with pytest.raises(SDOPackage.InternalError):
        configuration.activate_configuration_set("slow")


def test_widgets_constraints_and_types_look_like_sets(lab: Lab) -> None:
    component = bound(
        lab,
        0,
        "1",
        *("conf.default.x", "1", "conf.__widget__.x", "spin"),
        *("conf.__constraints__.x", "0<x<9", "conf.__type__.x", "int"),
    )
    sets = component.getObjRef().get_configuration().get_configuration_sets()
    found = {each.id: each.configuration_data[0].value.value() for each in sets}
    assert found == {
        "default": "1",
        "__widget__": "spin",
        "__constraints__": "0<x<9",
        "__type__": "int",
    }
