"""The annotations that say in IDL what a component has beyond IDL."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Documented,
    NamedType,
    Port,
)

_PROFILE = (
    *("kind", "category", "vendor", "version", "description", "rate", "max_instances"),
    *("activity", "component_type", "execution", "created", "updated"),
)
"""The arguments of `@rtc`, in order: fields of a component."""


def annotations_of(item: Documented) -> tuple[Annotation, ...]:
    """The annotations of a component, port or parameter that was not read from IDL."""
    match item:
        case Component():
            return _of_component(item)
        case Port():
            return tuple(_one(*pair) for pair in _of_port(item))
        case ConfigurationParameter():
            return tuple(_one(*pair) for pair in _of_parameter(item))
    return ()


def _one(name: str, value: ConstantValue) -> Annotation:
    return Annotation(name, (("value", value),))


def _of_component(component: Component) -> tuple[Annotation, ...]:
    """`@rtc` with what is not the default."""
    defaults = Component.__dataclass_fields__
    told = [(name, getattr(component, name)) for name in _PROFILE]
    different = tuple(
        (name, value)
        for name, value in told
        if name == "kind" or value != defaults[name].default
    )
    return (Annotation("rtc", different),)


def _of_port(port: Port) -> Iterator[tuple[str, ConstantValue]]:
    if port.name != port.identifier:
        yield "name", port.name
    if port.port and port.port != port.name:
        yield "port", port.port
    usual = port.type.name[-1] if isinstance(port.type, NamedType) else ""
    if port.port and port.instance != usual:
        yield "instance", port.instance
    if port.unit:
        yield "unit", port.unit


def _of_parameter(
    parameter: ConfigurationParameter,
) -> Iterator[tuple[str, ConstantValue]]:
    if parameter.name != parameter.identifier:
        yield "name", parameter.name
    for name, text in (
        ("unit", parameter.unit),
        ("widget", parameter.widget),
        ("constraint", parameter.constraint),
    ):
        if text:
            yield name, text
    for word, value in (
        ("default", parameter.default),
        ("min", parameter.minimum),
        ("max", parameter.maximum),
    ):
        if value is not None:
            yield word, value
