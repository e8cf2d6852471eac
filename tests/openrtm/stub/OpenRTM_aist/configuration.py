"""Configuration sets, the variables bound to them, and both over CORBA."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import SDOPackage
import SDOPackage__POA

from .NVUtil import list_of, properties_of
from .properties import Properties
from .values import stringTo

Trans = Callable[[Any, str], tuple[bool, Any]]


class Parameter:
    """A variable, a list of one element, and the text it was last converted from."""

    def __init__(self, name: str, var: list[Any], default: str, trans: Trans) -> None:
        self.name = name
        self.default = default
        self._var = var
        self._trans = trans
        self._text = ""

    def update(self, text: str) -> None:
        """Set the variable; a text that does not convert gives the default."""
        if text == self._text:
            return
        self._text = text
        done, self._var[0] = self._trans(self._var[0], text)
        if not done:
            _, self._var[0] = self._trans(self._var[0], self.default)


class ConfigAdmin:
    """The sets of a component (the node `conf` of its properties) and its bound variables."""

    def __init__(self, sets: Properties) -> None:
        self._sets = sets
        self._active_id = "default"
        self._active = True
        self._changed = False
        self._added: set[str] = set()
        self._parameters: dict[str, Parameter] = {}
        self._lock = threading.RLock()

    def bindParameter(
        self, name: str, var: list[Any], default: str, trans: Trans | None = None
    ) -> bool:
        """Bind a variable; False if the default is empty or does not convert."""
        trans = trans or stringTo
        with self._lock:
            if not name or not default or name in self._parameters:
                return False
            done, var[0] = trans(var[0], default)
            if not done:
                return False
            parameter = Parameter(name, var, default, trans)
            self._parameters[name] = parameter
            parameter.update(self._sets.getProperty(f"{self._active_id}.{name}"))
            return True

    def update(self) -> None:
        """Set the variables by the active set, if something has changed."""
        with self._lock:
            if not (self._changed and self._active):
                return
            self._changed = False
            active = self._sets.getNode(self._active_id)
            for name, parameter in self._parameters.items():
                if active.hasKey(name):
                    parameter.update(active.getProperty(name))

    def getActiveId(self) -> str:
        return self._active_id

    def getConfigurationSets(self) -> list[Properties]:
        return self._sets.getLeaf()

    def getConfigurationSet(self, name: str) -> Properties | None:
        return self._sets.findNode(name)

    def setConfigurationSetValues(self, values: Properties) -> bool:
        """Set values, which take effect when their set is activated."""
        with self._lock:
            if not values.name or not self._sets.hasKey(values.name):
                return False
            self._sets.getNode(values.name).mergeProperties(values)
            self._changed = True
            self._active = False
            return True

    def addConfigurationSet(self, values: Properties) -> bool:
        with self._lock:
            if not values.name or self._sets.hasKey(values.name):
                return False
            self._sets.getNode(values.name).mergeProperties(values)
            self._added.add(values.name)
            self._changed = True
            self._active = False
            return True

    def removeConfigurationSet(self, name: str) -> bool:
        """Remove an added set that is not active."""
        with self._lock:
            if name == self._active_id or name not in self._added:
                return False
            self._added.remove(name)
            self._sets.removeNode(name)
            self._changed = True
            self._active = False
            return True

    def activateConfigurationSet(self, name: str) -> bool:
        with self._lock:
            if not name or name.startswith("_") or not self._sets.hasKey(name):
                return False
            self._active_id = name
            self._active = True
            self._changed = True
            return True


class ConfigurationServant(SDOPackage__POA.Configuration):
    """The sets for tools; all values are texts."""

    def __init__(self, admin: ConfigAdmin) -> None:
        self._admin = admin

    def get_configuration_parameter_value(self, name: str) -> Any:
        """Return None, which omniORBpy cannot marshal: OpenRTM has no single values."""
        return None

    def set_configuration_parameter(self, name: str, value: Any) -> bool:
        return True

    def get_configuration_sets(self) -> list[Any]:
        return [_as_set(node) for node in self._admin.getConfigurationSets()]

    def get_configuration_set(self, name: str) -> Any:
        if not name:
            raise SDOPackage.InvalidParameter("the name of the set is empty")
        node = self._admin.getConfigurationSet(name)
        if node is None:
            raise SDOPackage.InternalError(f"there is no set {name}")
        return _as_set(node)

    def set_configuration_set_values(self, values: Any) -> bool:
        return self._done(self._admin.setConfigurationSetValues(_as_node(values)))

    def get_active_configuration_set(self) -> Any:
        return self.get_configuration_set(self._admin.getActiveId())

    def add_configuration_set(self, values: Any) -> bool:
        return self._done(self._admin.addConfigurationSet(_as_node(values)))

    def remove_configuration_set(self, name: str) -> bool:
        if not name:
            raise SDOPackage.InvalidParameter("the name of the set is empty")
        return self._done(self._admin.removeConfigurationSet(name))

    def activate_configuration_set(self, name: str) -> bool:
        if not name:
            raise SDOPackage.InvalidParameter("the name of the set is empty")
        return self._done(self._admin.activateConfigurationSet(name))

    @staticmethod
    def _done(done: bool) -> bool:
        if not done:
            raise SDOPackage.InternalError("the configuration refused")
        return True


def _as_set(node: Properties) -> Any:
    return SDOPackage.ConfigurationSet(node.name, "", list_of(node))


def _as_node(values: Any) -> Properties:
    if not values.id:
        raise SDOPackage.InvalidParameter("the name of the set is empty")
    node = properties_of(values.configuration_data)
    node.name = values.id
    return node
