"""The names that ports cannot have, compared with the runtime that defines them."""

from rtgen.compiler.typemap.components.actions import ACTIONS
from rtgen.compiler.typemap.components.names import CANOPEN_NAMES, COMPONENT_NAMES
from rtgen.runtime import Component
from rtgen.runtime.canopen.master.manager import CanopenManager
from rtgen.runtime.canopen.master.proxy import CanopenProxy
from rtgen.runtime.canopen.node.device import CanopenDevice


def test_names_are_those_of_the_component_class() -> None:
    found = {
        name
        for name in (*dir(Component), *vars(Component()))
        if not name.startswith("_")
    }
    assert found | {"config"} == COMPONENT_NAMES


def test_names_are_those_of_the_bases_of_canopen() -> None:
    found = {
        name
        for base in (CanopenProxy, CanopenDevice, CanopenManager)
        for class_ in base.__mro__
        for name in (*vars(class_), *vars(class_).get("__annotations__", ()))
        if not name.startswith("_") and class_ is not object
    }
    # Attributes of instances, and ports of managers.
    own = {"node", "objects", "station"}
    assert (found | own) - COMPONENT_NAMES - {"manager", "states"} == CANOPEN_NAMES


def test_actions_are_callbacks_of_the_component_class() -> None:
    methods = {name for name in dir(Component) if name.startswith("on_")}
    assert {action.method for action in ACTIONS} == methods
