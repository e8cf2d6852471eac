"""Properties that a running component must have, according to its definition."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from itertools import groupby
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.backends.components.locations import summary
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Declaration,
    Model,
    NamedType,
    Port,
    PortKind,
)
from rtgen.compiler.model.rtc_profile import EVENT_PORT
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.facts.activities import ACTIVITIES, EVENT_DRIVEN
from rtgen.facts.constraints import parse, text_of
from rtgen.facts.openrtm_ports import IN, OUT, SERVICE, known_name, registered_names
from rtgen.runtime.errors import ParameterValueError
from rtgen.runtime.rtc.parameter_values import Converter
from rtgen.runtime.rtc.profiles import ParameterProfile

_PLAIN = re.compile(r"[\w. :-]+")
_ANY = "any"
"""The type with which OpenRTM registers ports for events."""
_WAYS = {PortKind.INPORT: IN, PortKind.OUTPORT: OUT}
_TYPES = {IN: "DataInPort", OUT: "DataOutPort", SERVICE: "CorbaPort"}


@dataclass(frozen=True, slots=True)
class ExpectedInterface:
    """An interface of a service port: the names that its type may have, and its repository id."""

    names: tuple[str, ...]
    identity: str


@dataclass(frozen=True, slots=True)
class ExpectedPort:
    """A port: OpenRTM's `port.port_type`, and the accepted names of its data type.

    `interfaces` has the interfaces, by instance name and whether they are provided.
    """

    port_type: str
    data_types: tuple[str, ...] = ()
    interfaces: Mapping[tuple[str, bool], ExpectedInterface] | None = None


class ExpectedParameter:
    """A parameter, with texts that it must accept or reject."""

    def __init__(
        self, parameter: ConfigurationParameter, parameters: Parameters
    ) -> None:
        constraint = parse(parameter.constraint)
        profile = ParameterProfile(
            parameter.name,
            parameter.name,
            parameters.canonical_type(parameter.type),
            minimum=_bound(parameter.minimum),
            maximum=_bound(parameter.maximum),
            unit=parameter.unit,
            constraint="" if constraint is None else text_of(constraint),
        )
        names = parameters.enumerators(parameters.item_type(parameter.type))
        example: Any = None
        if names:
            # Written as a call, since mypy knows the functional form only so.
            make: Any = IntEnum
            example = next(iter(make("Values", names, start=0)))
            if parameters.is_sequence(parameter.type):
                example = [example]
        self.name = parameter.name
        self.default = parameters.default_text(parameter)
        self.value = Converter(profile, example)
        free = replace(profile, minimum=None, maximum=None, constraint="")
        self._free = Converter(free, example)
        bounds = [b for b in (profile.minimum, profile.maximum) if b is not None]
        steps = [number + step for number in bounds for step in (-1, 0, 1)]
        self._texts = [*map(str, steps), *_TEXTS, *names]

    def problem(self, text: str) -> str | None:
        """Return why the parameter cannot have a text; None if it can."""
        return _refusal(self.value, text)

    def is_default(self, text: str) -> bool:
        """Return whether a text is the default value of the definition."""
        return bool(self._free(text) == self._free(self.default))

    def others(self, text: str) -> Iterator[str]:
        """Yield texts of other valid values."""
        for other in self._texts:
            if self.problem(other) is None and self.value(other) != self.value(text):
                yield other

    def beyond(self) -> str | None:
        """Return a text of its type beyond its limits; None without limits."""
        return next(
            (
                text
                for text in self._texts
                if _refusal(self._free, text) is None and self.problem(text)
            ),
            None,
        )

    def of_no_type(self) -> str | None:
        """Return a text that is not a value of its type; None if every text is one."""
        wrong = (text for text in _WRONG if _refusal(self._free, text))
        return next(wrong, None)


_TEXTS = (
    *("0", "1", "2", "0.5", "1.5", "-1", "1000000", "-1000000"),
    *("true", "false", "x", "y", "0,0", "0,0,0", "1,1", "1,1,1"),
)
_WRONG = ("no value", "[", "1e")


def _refusal(converter: Converter, text: str) -> str | None:
    try:
        converter(text)
    except ParameterValueError as error:
        return str(error)
    return None


def _bound(value: object) -> float | int | None:
    return value if isinstance(value, int | float) else None


class Expected:
    """A component's definition as visible to another process."""

    def __init__(self, model: Model, component: Component) -> None:
        parameters = Parameters(model)
        self.type_name = component.name[-1]
        self.texts = {
            "type_name": self.type_name,
            "category": component.category,
            "vendor": component.vendor,
            "version": component.version,
            "description": summary(component),
        }
        self.properties = {
            # Many modules of OpenRTM state the type or the kind of the component there.
            "activity_type": (
                (component.activity_type,)
                if component.activity_type
                else (component.activity, component.component_type, component.kind)
            ),
            "max_instance": (str(component.max_instances),),
        }
        self.rate = component.rate
        is_event_driven = component.activity == EVENT_DRIVEN
        periodic = component.execution.startswith("Periodic")
        self.is_periodic = periodic and not is_event_driven
        self.parameters = {
            each.name: ExpectedParameter(each, parameters)
            for each in component.configuration
        }
        self.ports = _ports(model, component)

    @staticmethod
    def saying(name: str, text: str) -> str:
        """Return how a definition says the text of a property; empty if it cannot."""
        if name == "max_instance":
            says = f"max_instances={text}" if text.isdecimal() else ""
        elif text in ACTIVITIES:
            says = f'activity="{text}"'
        else:
            says = f'activity_type="{text}"' if _PLAIN.fullmatch(text) else ""
        return f"; @rtc({says}) says so" if says else ""


def _ports(model: Model, component: Component) -> dict[str, ExpectedPort]:
    """Return the ports by OpenRTM's names."""

    def key(port: Port) -> tuple[str, str]:
        way = _WAYS.get(port.kind, SERVICE)
        return way, (port.port or port.name) if way == SERVICE else port.name

    ordered = sorted(component.ports, key=key)
    names = registered_names(map(key, component.ports))
    by_name = {}
    for (way, name), group in groupby(ordered, key):
        ports = list(group)
        if way == SERVICE:
            interfaces = {
                (port.instance, port.kind is PortKind.PROVIDER): ExpectedInterface(
                    _names(model, port), _declaration(model, port).repository_id
                )
                for port in ports
            }
            expected = ExpectedPort(_TYPES[way], interfaces=interfaces)
        else:
            types = _names(model, ports[0])
            if any(each.name == EVENT_PORT for each in ports[0].annotations):
                types += (_ANY,)
            expected = ExpectedPort(_TYPES[way], types)
        by_name[known_name(names[way, name])] = expected
    return by_name


def _names(model: Model, port: Port) -> tuple[str, ...]:
    """Return the accepted names of a port's type.

    These are the chosen one, the repository id, and the names with and without scope.
    """
    declaration = _declaration(model, port)
    names = (
        port.type_name,
        declaration.repository_id,
        declaration.scoped,
        declaration.name[-1],
    )
    return tuple(dict.fromkeys(name for name in names if name))


def _declaration(model: Model, port: Port) -> Declaration:
    type_ = model.unalias(port.type)
    assert isinstance(type_, NamedType), "the front end has checked it"
    return model.find(type_.name)
