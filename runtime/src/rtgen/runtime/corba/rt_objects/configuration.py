"""`SDOPackage::Configuration` of a component: its configuration sets."""

from __future__ import annotations

from typing import Any

from omniORB import any as anys

from rtgen.runtime.corba.rt_objects.wire import (
    ConfigurationSet,
    InternalError,
    InvalidParameter,
    NameValue,
    texts,
    values,
)
from rtgen.runtime.errors import RtcError
from rtgen.runtime.rtc.component import Component


class Configuration:
    """Configuration sets with texts as values, as in OpenRTM. Changes apply between two cycles."""

    def __init__(self, component: Component) -> None:
        self._sets = component.configuration_sets

    def get_configuration_parameter_values(self) -> list[NameValue]:
        """Return the values of the active set."""
        return values(self._sets.texts(self._sets.active))

    def get_configuration_parameter_value(self, name: str) -> Any:
        """Return a value of the active set. Raises InvalidParameter."""
        found = self._sets.texts(self._sets.active)
        if name not in found:
            raise InvalidParameter(f"there is no parameter {name}")
        return anys.to_any(found[name])

    def set_configuration_parameter(self, name: str, value: Any) -> bool:
        """Set a value in the active set. Raises InvalidParameter."""
        given = texts([NameValue(name, value)])
        return self._set(self._sets.active, given, count=1)

    def get_configuration_sets(self) -> list[ConfigurationSet]:
        """Return all sets, `default` first."""
        return [self._shown(each) for each in self._sets.ids]

    def get_configuration_set(self, config_id: str) -> ConfigurationSet:
        """Return a set. Raises InternalError for an unknown one."""
        if config_id not in self._sets.ids:
            raise InternalError(f"there is no configuration set {config_id}")
        return self._shown(config_id)

    def get_active_configuration_set(self) -> ConfigurationSet:
        """Return the active set."""
        return self._shown(self._sets.active)

    def set_configuration_set_values(self, configuration_set: ConfigurationSet) -> bool:
        """Change values of a set, all or none. Raises InvalidParameter."""
        if configuration_set.id not in self._sets.ids:
            raise InvalidParameter(f"there is no set {configuration_set.id}")
        return self.add_configuration_set(configuration_set)

    def add_configuration_set(self, configuration_set: ConfigurationSet) -> bool:
        """Add a set, or change one. Raises InvalidParameter."""
        given = configuration_set.configuration_data
        return self._set(configuration_set.id, texts(given), count=len(given))

    def activate_configuration_set(self, config_id: str) -> bool:
        """Activate a set. Raises InvalidParameter."""
        try:
            self._sets.activate(config_id)
        except RtcError as error:
            raise InvalidParameter(str(error)) from error
        return True

    def remove_configuration_set(self, config_id: str) -> bool:
        """Remove a set; return False for `default`, the active one and an unknown one."""
        try:
            self._sets.remove(config_id)
        except RtcError:
            return False
        return True

    def _set(self, set_id: str, given: dict[str, str], count: int) -> bool:
        if len(given) != count:
            raise InvalidParameter("values of parameters are texts")
        try:
            for name, text in given.items():
                self._sets.check(name, text)
            for name, text in given.items():
                self._sets.set(name, text, set_id)
        except RtcError as error:
            raise InvalidParameter(str(error)) from error
        return True

    def _shown(self, set_id: str) -> ConfigurationSet:
        return ConfigurationSet(set_id, "", values(self._sets.texts(set_id)))


def _refused(self: Configuration, *arguments: object) -> bool:
    """Return False: there are no devices, organizations, and observers; tools poll instead."""
    return False


for _name in (
    *("set_device_profile", "add_service_profile", "remove_service_profile"),
    *("add_organization", "remove_organization"),
):
    setattr(Configuration, _name, _refused)
