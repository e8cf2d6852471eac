"""IDL annotations for properties of components that IDL itself does not have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from rtgen.compiler.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Documented,
    NamedType,
    Port,
)
from rtgen.compiler.model.rtc_profile import EVENT, EVENT_ARGUMENTS, EVENT_PORT
from rtgen.facts.comments import first_sentence

_PROFILE = (
    *("kind", "category", "vendor", "version", "description", "rate"),
    *("max_instances", "activity", "component_type", "activity_type", "triggers"),
    *("execution", "created", "updated"),
)
"""The arguments of `@rtc`, in order: fields of a component."""

_DEFAULTS = dict(
    zip(
        reversed(Component.__struct_fields__),
        reversed(Component.__struct_defaults__),
        strict=False,
    )
)
"""Defaults of a component's fields; fields without one come first."""

_FIELDS = {
    **{(word, "value"): word for word in ("name", "port", "instance", "unit")},
    **{(word, "value"): word for word in ("type_name", "widget", "constraint")},
    ("default", "value"): "default",
    ("min", "value"): "minimum",
    ("max", "value"): "maximum",
    ("range", "min"): "minimum",
    ("range", "max"): "maximum",
}
"""Arguments of annotations of ports and parameters, with the corresponding fields."""

WrittenAnnotation: TypeAlias = Annotation | tuple[str, ...]
"""An annotation as written; or name and arguments, if they correspond to fields."""


def annotations_of(item: Documented) -> tuple[Annotation, ...]:
    """Return the annotations of a component, port or parameter that was not read from IDL."""
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
    """Yield `@rtc` with the arguments that differ from the defaults."""
    arguments = tuple(_different(component))
    if not arguments:
        return ()
    kind = () if dict(arguments).get("kind") else (("kind", component.kind),)
    return (Annotation("rtc", (*kind, *arguments)),)


def _different(component: Component) -> Iterator[tuple[str, ConstantValue]]:
    for name in _PROFILE:
        value = getattr(component, name)
        usual = _DEFAULTS[name]
        if name == "description":
            usual = first_sentence(component.doc)
        if value != usual:
            yield name, value


def _of_port(port: Port) -> Iterator[tuple[str, ConstantValue]]:
    if port.name != port.identifier:
        yield "name", port.name
    if port.port and port.port != port.name:
        yield "port", port.port
    usual = port.type.name[-1] if isinstance(port.type, NamedType) else ""
    if port.port and port.instance != usual:
        yield "instance", port.instance
    if port.type_name:
        yield "type_name", port.type_name
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


# Annotations whose content is in fields


def written_annotations(item: Documented) -> tuple[WrittenAnnotation, ...] | None:
    """Return the annotations of an item as written; None if a profile implies them.

    A profile implies the result of `annotations_of`, and events.
    """
    events = tuple(a for a in item.annotations if a.name in (EVENT_PORT, EVENT))
    if item.annotations in ((), (*annotations_of(item), *map(_complete, events))):
        return None
    return tuple(_written(item, annotation) for annotation in item.annotations)


def _written(item: Documented, annotation: Annotation) -> WrittenAnnotation:
    short = (annotation.name, *(key for key, _ in annotation.arguments))
    return short if _of_fields(item, short) == annotation else annotation


def annotations_from(
    item: Documented, entries: Sequence[WrittenAnnotation]
) -> tuple[Annotation, ...]:
    """Return the annotations of an item as written, unless its fields contradict them."""
    annotations: list[Annotation] = []
    for entry in entries:
        written = entry if isinstance(entry, Annotation) else _of_fields(item, entry)
        if written is not None:
            annotations.append(written)
    said = {(a.name, key) for a in annotations for key, _ in a.arguments}
    fields = {_FIELDS[each] for each in said if each in _FIELDS}
    for annotation in annotations_of(item):
        if annotation.name == "rtc":
            annotations = _with_arguments(annotations, annotation, item)
        elif _FIELDS[annotation.name, "value"] not in fields:
            annotations.append(annotation)
    return tuple(annotations)


def same_event(one: Annotation, other: Annotation) -> bool:
    """Return whether two event annotations are equivalent; missing arguments count as empty."""
    return one.name == other.name and _complete(one) == _complete(other)


def _complete(event: Annotation) -> Annotation:
    """Return an event with all arguments, as in profiles."""
    if event.name != EVENT:
        return event
    return Annotation(
        EVENT, tuple((key, event.get(key) or "") for key in EVENT_ARGUMENTS)
    )


def _of_fields(item: Documented, short: Sequence[str]) -> Annotation | None:
    """Return the annotation with the fields' values; None if a field has none."""
    name, *keys = short
    arguments: list[tuple[str, ConstantValue]] = []
    for key in keys:
        if isinstance(item, Component):
            field = key if name == "rtc" and key in _PROFILE else ""
        else:
            field = _FIELDS.get((name, key), "")
        value = getattr(item, field, None) if field else None
        if value is None:
            return None
        arguments.append((key, value))
    return Annotation(name, tuple(arguments)) if arguments else None


def _with_arguments(
    annotations: list[Annotation], written: Annotation, item: Documented
) -> list[Annotation]:
    """Return the annotations with a complete `@rtc`."""
    assert isinstance(item, Component)
    for place, annotation in enumerate(annotations):
        if annotation.name == "rtc":
            arguments = dict(annotation.arguments)
            more = [pair for pair in _different(item) if pair[0] not in arguments]
            full = Annotation("rtc", (*annotation.arguments, *more))
            return [*annotations[:place], full, *annotations[place + 1 :]]
    return [*annotations, written]
