"""Configuration sets: texts are validated when set, values change only between two cycles."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from rtgen.facts.threads import Threads
from rtgen.runtime.errors import UnknownConfigurationSetError, UnknownParameterError
from rtgen.runtime.rtc.conf_file import ConfFile
from rtgen.runtime.rtc.parameter_values import Converter
from rtgen.runtime.rtc.profiles import ParameterProfile
from rtgen.runtime.timing.traffic import ParameterChange, Traffic

DEFAULT_SET = "default"
ACTIVE_SET = "configuration.active_config"
"""Name under which tools find the id of the active set among parameters, as in OpenRTM."""


class ConfigurationSets:
    """The configuration sets of one component.

    A set has some parameters and falls back to the set `default`, which falls back to the
    definition. Changes are copied to the configuration object by `apply`: before `on_initialize`
    and `on_activated`, and at the end of each cycle, so that no callback sees a partial change.
    `schedule` requests a call of `apply` at the end of the next cycle.
    """

    def __init__(
        self, owner: str, schedule: Callable[[Callable[[], None]], None]
    ) -> None:
        self.rate: float | None = None
        """Rate in Hz from a `.conf` file (`exec_cxt.periodic.rate`)."""
        self.threads: Threads | None = None
        """Thread of the context from a `.conf` file (`rtgen.threads`)."""
        self.on_change: Callable[[], None] | None = None
        """Called when values of the configuration object have changed."""
        self.traffic: Traffic | None = None
        """Receiver of changes; None before the component joins a system."""
        self._owner = owner
        self._schedule = schedule
        self._target: object = None
        self._converters: dict[str, Converter] = {}
        # Replaced as a whole by every change, because another thread may be in `apply`.
        self._texts: dict[str, dict[str, str]] = {DEFAULT_SET: {}}
        self._lock = threading.Lock()
        self._initial: dict[str, Any] = {}
        self._applied: dict[str, Any] = {}
        self._active = DEFAULT_SET

    def bind(self, target: object, profiles: tuple[ParameterProfile, ...]) -> None:
        """Bind the fields of `target` to the parameters; its values are the defaults."""
        self._target = target
        for profile in profiles:
            value = getattr(target, profile.python_name)
            self._converters[profile.name] = Converter(profile, value)
            self._initial[profile.name] = value
        self._applied = dict(self._initial)

    @property
    def active(self) -> str:
        """Id of the active set."""
        return self._active

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of all sets, `default` first."""
        return tuple(self._texts)

    @property
    def parameters(self) -> tuple[ParameterProfile, ...]:
        """The parameters, in the order of the definition."""
        return tuple(converter.profile for converter in self._converters.values())

    def texts(self, set_id: str = DEFAULT_SET) -> Mapping[str, str]:
        """Return a set's texts, completed by `default`. Raises UnknownConfigurationSetError."""
        self._require(set_id, self._texts)
        defaults = {profile.name: profile.default for profile in self.parameters}
        return defaults | self._texts[DEFAULT_SET] | self._texts[set_id]

    def set(self, parameter: str, text: str, set_id: str = DEFAULT_SET) -> None:
        """Set a parameter in a set, which is created if necessary.

        Raises UnknownParameterError or ParameterValueError, leaving the old value.
        """
        self.set_all({parameter: text}, set_id)

    def set_all(self, values: Mapping[str, str], set_id: str = DEFAULT_SET) -> None:
        """Set parameters of one set, all between the same two cycles, or none. Raises as `set`."""
        for parameter, text in values.items():
            self.check(parameter, text)
        with self._lock:
            texts = self._texts.get(set_id, {}) | dict(values)
            self._texts = self._texts | {set_id: texts}
        self._schedule(self.apply)

    def check(self, parameter: str, text: str) -> None:
        """Validate a value without setting it. Raises as `set`."""
        self.value(parameter, text)

    def value(self, parameter: str, text: str) -> Any:
        """Return the value of a text for a parameter. Raises as `set`."""
        if parameter not in self._converters:
            names = ", ".join(self._converters) or "none"
            raise UnknownParameterError(
                f"{self._owner} has no configuration parameter {parameter!r}; known: {names}"
            )
        return self._converters[parameter](text)

    def activate(self, set_id: str) -> None:
        """Activate a set. Raises UnknownConfigurationSetError."""
        self._require(set_id, self._texts)
        self._active = set_id
        self._schedule(self.apply)

    def remove(self, set_id: str) -> None:
        """Remove a set but `default` and the active one. Raises UnknownConfigurationSetError."""
        removable = {*self._texts} - {DEFAULT_SET, self._active}
        if set_id not in removable:
            raise UnknownConfigurationSetError(
                f"{self._owner} has no configuration set {set_id!r} that can be removed;"
                f" such are: {', '.join(sorted(removable)) or 'none'}"
            )
        with self._lock:
            self._texts = {k: v for k, v in self._texts.items() if k != set_id}

    def load(self, conf: ConfFile) -> None:
        """Load values, active set and rate of a `.conf` file, all or nothing.

        Raises UnknownParameterError, ParameterValueError or UnknownConfigurationSetError.
        """
        for values in conf.sets.values():
            for parameter, text in values.items():
                self.check(parameter, text)
        if conf.active_set is not None:
            self._require(conf.active_set, {**self._texts, **conf.sets})
        for set_id, values in conf.sets.items():
            for parameter, text in values.items():
                self.set(parameter, text, set_id)
        if conf.active_set is not None:
            self.activate(conf.active_set)
        if conf.rate is not None:
            self.rate = conf.rate
        self.threads = conf.threads or self.threads

    def apply(self) -> None:
        """Copy the values that changed since the last call to the configuration object."""
        # In this order, since a set exists before it becomes active.
        active, texts = self._active, self._texts
        effective = texts[DEFAULT_SET] | texts[active]
        changed = False
        for name, converter in self._converters.items():
            text = effective.get(name)
            value = self._initial[name] if text is None else converter(text)
            if value != self._applied[name]:
                self._applied[name] = value
                own = list(value) if isinstance(value, list) else value
                setattr(self._target, converter.profile.python_name, own)
                changed = True
                if self.traffic is not None and self.traffic.watchers:
                    text = converter.profile.default if text is None else text
                    self.traffic.report(ParameterChange(self._owner, name, text))
        if changed and self.on_change is not None:
            self.on_change()

    def _require(self, set_id: str, parameters: Mapping[str, object]) -> None:
        if set_id not in parameters:
            raise UnknownConfigurationSetError(
                f"{self._owner} has no configuration set {set_id!r}; known: {', '.join(parameters)}"
            )
