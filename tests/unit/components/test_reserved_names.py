"""The names that ports cannot have, against the runtime that has them."""

from rtgen.runtime import Component
from rtgen.typemap.component_actions import ACTIONS
from rtgen.typemap.component_names import COMPONENT_NAMES


def test_names_are_those_of_the_component_class() -> None:
    found = {
        name
        for name in (*dir(Component), *vars(Component()))
        if not name.startswith("_")
    }
    assert found | {"config"} == COMPONENT_NAMES


def test_actions_are_callbacks_of_the_component_class() -> None:
    methods = {name for name in dir(Component) if name.startswith("on_")}
    assert {action.method for action in ACTIONS} == methods
