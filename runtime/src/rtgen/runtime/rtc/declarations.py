"""Declarations of ports and parameters in the class of a component, from which its profile follows.

```python
class Gains(Configuration):
    p: float = parameter(0.5, "Proportional gain.", minimum=0.0)

class Lamp(Component, type_name="Lamp", category="Demo", rate=100.0):
    config = configuration(Gains)
    target = inport(rtc.TimedDouble, "Brightness.", unit="cd")
    control = provider(arm.Control)
```
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from enum import Enum
from typing import Any, ClassVar, TypeVar, cast

from msgspec import Struct, StructMeta, field
from msgspec.structs import replace

from rtgen.facts.comments import first_sentence
from rtgen.facts.parameter_texts import default_text
from rtgen.runtime.errors import ConfigurationError
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.rtc.profiles import ComponentProfile, ParameterProfile, PortProfile
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import Servant

T = TypeVar("T", bound=DataType)
S = TypeVar("S", bound=Servant)
V = TypeVar("V")

_TYPES: Mapping[type, str] = {
    bool: "boolean",
    int: "long",
    float: "double",
    str: "string",
}
"""The IDL types of parameters whose declaration names none."""


class Declaration(ABC):
    """A port or the configuration, declared in the class of a component.

    Each instance has its own in the attribute `name`.
    """

    name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @abstractmethod
    def add_to(self, component: Any) -> None:
        """Add what is declared to a component, as an attribute."""


class PortDeclaration(Declaration):
    """A data port, or one interface of a service port."""

    def __init__(self, type_: Any, profile: PortProfile) -> None:
        self.type = type_
        self._profile = profile

    def profile(self) -> PortProfile:
        """Return the profile of the port."""
        known, descriptor = self._profile, self.type._descriptor_
        name = known.name or self.name
        is_service = known.kind in ("provider", "consumer")
        return PortProfile(
            name,
            self.name,
            known.kind,
            descriptor.name,
            descriptor.repository_id,
            known.port or name if is_service else "",
            known.instance or name if is_service else "",
            known.unit,
            known.description,
            known.type_name,
        )

    def add_to(self, component: Any) -> None:
        profile = self.profile()
        match profile.kind:
            case "inport":
                port = component.add_in_port(profile.name, self.type)
            case "outport":
                port = component.add_out_port(profile.name, self.type)
            case "provider":
                port = component.add_provider(profile.port, profile.instance, self.type)
            case _:
                port = component.add_consumer(profile.port, profile.instance, self.type)
        setattr(component, self.name, port)


class _ConfigurationDeclaration(Declaration):
    def __init__(self, type_: type[Configuration]) -> None:
        self.type = type_

    def add_to(self, component: Any) -> None:
        setattr(component, self.name, component.add_configuration(self.type()))


def inport(
    type_: type[T], description: str = "", *, name: str = "", unit: str = ""
) -> InPort[T]:
    """Declare an InPort. `name` is its name outside, if it differs from that of the attribute."""
    return cast("InPort[T]", _port("inport", type_, description, name, unit))


def outport(
    type_: type[T], description: str = "", *, name: str = "", unit: str = ""
) -> OutPort[T]:
    """Declare an OutPort; see `inport`."""
    return cast("OutPort[T]", _port("outport", type_, description, name, unit))


def provider(
    interface: Callable[..., S],
    description: str = "",
    *,
    name: str = "",
    port: str = "",
    instance: str = "",
    type_name: str = "",
    unit: str = "",
) -> Provider[S]:
    """Declare a provided interface of a service port.

    `port` is the service port and `instance` the name of the instance, each if it differs from the
    name; `type_name` is OpenRTM's name of the interface's type, if it is not the scoped one.
    """
    service = (port, instance, type_name)
    declared = _port("provider", interface, description, name, unit, *service)
    return cast("Provider[S]", declared)


def consumer(
    interface: Callable[..., S],
    description: str = "",
    *,
    name: str = "",
    port: str = "",
    instance: str = "",
    type_name: str = "",
    unit: str = "",
) -> Consumer[S]:
    """Declare a required interface of a service port; see `provider`."""
    service = (port, instance, type_name)
    declared = _port("consumer", interface, description, name, unit, *service)
    return cast("Consumer[S]", declared)


def _port(
    kind: str,
    type_: Any,
    description: str,
    name: str,
    unit: str,
    port: str = "",
    instance: str = "",
    type_name: str = "",
) -> PortDeclaration:
    summary = first_sentence(description)
    profile = PortProfile(
        name, "", kind, "", "", port, instance, unit, summary, type_name
    )
    return PortDeclaration(type_, profile)


def configuration(type_: type[V]) -> V:
    """Declare the configuration of a component, by its class."""
    return cast("V", _ConfigurationDeclaration(cast("type[Configuration]", type_)))


class _Parameter(Struct, frozen=True, gc=False):
    default: Any
    profile: ParameterProfile
    text: str | None

    def named(self, attribute: str) -> ParameterProfile:
        """Return the profile with the names, the type and the text that are not declared.

        Raises ConfigurationError for a default without a type of its own.
        """
        profile = self.profile
        type_ = profile.type or _TYPES.get(type(self.default))
        if type_ is None:
            raise ConfigurationError(
                f"parameter {attribute!r} does not state the IDL type of {self.default!r},"
                ' such as type="sequence<double>"'
            )
        text = default_text(self.default) if self.text is None else self.text
        return ParameterProfile(
            profile.name or attribute,
            attribute,
            type_,
            text,
            profile.minimum,
            profile.maximum,
            profile.unit,
            profile.constraint,
            profile.widget,
            profile.description,
        )


def parameter(
    default: V,
    description: str = "",
    *,
    name: str = "",
    type: str = "",  # noqa: A002  # the field's word
    text: str | None = None,
    minimum: float | None = None,
    maximum: float | None = None,
    unit: str = "",
    constraint: str = "",
    widget: str = "",
) -> V:
    """Declare a parameter of a `Configuration`.

    `name` is its name outside, if it differs from that of the attribute; `type` the IDL type, if it
    is none of boolean, long, double and string; `text` the default's text, if it is another one
    than that of the value; `constraint` a text as in RTC.xml (`0.0<x<=2.0`).
    """
    profile = ParameterProfile(
        *(name, "", type, "", minimum, maximum, unit, constraint, widget),
        first_sentence(description),
    )
    return cast("V", _Parameter(default, profile, text))


class _ConfigurationMeta(StructMeta):
    def __new__(
        mcls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        **options: Any,
    ) -> Any:
        declared = {n: v for n, v in namespace.items() if isinstance(v, _Parameter)}
        fields = {name: _field(each.default) for name, each in declared.items()}
        class_: Any = super().__new__(
            mcls, name, bases, {**namespace, **fields}, **options
        )
        profiles = {
            profile.python_name: profile
            for base in reversed(bases)
            for profile in getattr(base, "_parameters_", ())
        }
        for attribute in {*profiles} & {*namespace}:
            text = default_text(namespace[attribute])
            profiles[attribute] = replace(profiles[attribute], default=text)
        profiles |= {name: each.named(name) for name, each in declared.items()}
        class_._parameters_ = tuple(profiles.values())
        return class_


class Configuration(Struct, metaclass=_ConfigurationMeta, gc=False):
    """Base class of the parameters of a component, declared by `parameter`.

    A subclass has the parameters of its base; one that it assigns a value starts with that.
    """

    _parameters_: ClassVar[tuple[ParameterProfile, ...]] = ()


def _field(default: Any) -> Any:
    if isinstance(default, bool | int | float | str | bytes | Enum):
        return default
    return field(default_factory=lambda: copy(default))


def derived_profile(
    base: ComponentProfile, own: Iterable[object], facts: Mapping[str, Any]
) -> ComponentProfile:
    """Return the profile of a class: that of its base, its own declarations, and further facts."""
    ports = {each.python_name: each for each in base.ports}
    parameters = base.configuration
    for each in own:
        if isinstance(each, PortDeclaration):
            ports[each.name] = each.profile()
        elif isinstance(each, _ConfigurationDeclaration):
            parameters = each.type._parameters_
    return replace(base, **facts, ports=tuple(ports.values()), configuration=parameters)
