"""Properties of a definition that an RtcProfile's attributes cannot express, as JSON.

A profile written by rtgen has them as properties `rtgen.definition` of the component, its data
ports, service ports and parameters, only if the attributes alone would be read differently. A fact
applies only while the attributes are those that rtgen writes for it, so edited attributes take
precedence.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from math import isfinite
from pathlib import PurePosixPath
from typing import Any, TypeAlias

from rtgen.compiler.model import (
    Annotation,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Documented,
    EnumeratorName,
    Model,
    NamedType,
    Port,
    PortKind,
    default_id,
)
from rtgen.compiler.typemap.components.annotations import (
    WrittenAnnotation,
    written_annotations,
)
from rtgen.compiler.typemap.components.needs import declarations_of
from rtgen.compiler.typemap.components.parameter_types import type_of
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.profiles import escapes as profile_escapes
from rtgen.facts.constraints import text_of

PROPERTY = "rtgen.definition"
"""The name of the property."""
ACTIVITY_PROPERTY = "activity_type"
"""The name of the property of a component with the text that OpenRTM registers."""
TRIGGERS_PROPERTY = "rtgen.triggers"
"""The name of the property of a component with the InPorts that execute it."""

Facts: TypeAlias = dict[str, Any]

_MAX_LENGTH = 1 << 20

WITH_USUAL = {
    "kind": "DataFlowComponent",
    "execution": "PeriodicExecutionContext",
    "version": "1.0.0",
    "category": "",
    "vendor": "",
}
"""Texts of a component that are stripped when read, with the placeholder of an empty one."""


_KINDS: dict[str, tuple[type, str]] = {
    **dict.fromkeys(
        (
            *("name", "port", "instance", "identifier", "type", "type_name"),
            *("constraint", "widget"),
            *("repository_id", "base", "description", "doc", *WITH_USUAL),
        ),
        (str, "text"),
    ),
    **dict.fromkeys(("supports", "files", "order", "annotations"), (list, "a list")),
}
"""JSON types of facts; those not listed are parameter values."""


# As text.


def text_from(facts: Facts) -> str:
    """Format facts as the value of the property."""
    return json.dumps(facts, ensure_ascii=False, separators=(", ", ": "))


def facts_from(text: str) -> Facts:
    """Parse the value of the property. Raises ValueError."""
    if len(text) > _MAX_LENGTH:
        raise ValueError(f"it is longer than {_MAX_LENGTH:,} characters")
    try:
        facts = json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    if not isinstance(facts, dict):
        raise ValueError("it is not an object of JSON")
    return facts


def checked(data: Any) -> tuple[Facts, list[str]]:
    """Return the facts of valid types, and messages about the others."""
    if not isinstance(data, dict):
        return {}, ["it is not an object of JSON"]
    wrong = {
        key: f"`{key}` is not {word}"
        for key, (kind, word) in _KINDS.items()
        if data.get(key) is not None and not isinstance(data[key], kind)
    }
    facts = {key: value for key, value in data.items() if key not in wrong}
    return facts, list(wrong.values())


def value_to_json(value: ConstantValue) -> Any:
    """Return a constant's value in JSON."""
    match value:
        case EnumeratorName(name):
            return {"enumerator": "::".join(name)}
        case Decimal():
            return {"fixed": format(value, "f")}
        case float() if not isfinite(value):
            return {"float": str(value)}
    return value


def value_from_json(value: Any) -> ConstantValue:
    """Convert the result of `value_to_json` back. Raises ValueError."""
    match value:
        case bool() | int() | float() | str():
            return value
        case {"enumerator": str(name)}:
            return EnumeratorName(tuple(name.split("::")))
        case {"float": str(name)}:
            return float(name)
        case {"fixed": str(digits)}:
            try:
                return Decimal(digits)
            except InvalidOperation:
                pass
    raise ValueError(f"{str(value)[:40]} is not a value")


def annotations_to_json(entries: Sequence[WrittenAnnotation]) -> list[Any]:
    """Convert annotations as written to JSON."""
    return [
        (
            {
                "name": entry.name,
                "arguments": [
                    [key, value_to_json(value)] for key, value in entry.arguments
                ],
            }
            if isinstance(entry, Annotation)
            else list(entry)
        )
        for entry in entries
    ]


def annotations_from_json(entries: list[Any]) -> list[WrittenAnnotation]:
    """Convert the result of `annotations_to_json` back. Raises ValueError."""
    return [_entry(entry) for entry in entries]


def _entry(entry: Any) -> WrittenAnnotation:
    match entry:
        case [_, *_] if all(isinstance(part, str) for part in entry):
            return tuple(entry)
        case {"name": str(name), "arguments": list(arguments)}:
            pairs = []
            for pair in arguments:
                match pair:
                    case [str(key), value]:
                        pairs.append((key, value_from_json(value)))
                    case _:
                        raise ValueError(f"{str(pair)[:40]} is not an argument")
            return Annotation(name, tuple(pairs))
    raise ValueError(f"{str(entry)[:40]} is not an annotation")


# What attributes do not express


def of_component(model: Model, component: Component) -> Facts:
    """Return the facts of a component, without its ports and parameters."""
    name = component.name
    facts: Facts = {}
    if len(name) > 1:
        facts["name"] = component.scoped
    if component.repository_id != default_id(name):
        facts["repository_id"] = component.repository_id
    if component.base is not None:
        facts["base"] = "::".join(component.base)
    if component.supports:
        facts["supports"] = ["::".join(each) for each in component.supports]
    if files := _further_files(model, component):
        facts["files"] = files
    order = [port.identifier for port in component.ports]
    if order != [port.identifier for port in in_profile_order(component.ports)]:
        facts["order"] = order
    for field, usual in WITH_USUAL.items():
        value = getattr(component, field)
        if read_text(value, usual) != value:
            facts[field] = value
    summary = profile_escapes.summary(component.description, component.doc)
    if profile_escapes.one_line(summary) != component.description:
        facts["description"] = component.description
    if read_doc(component.doc, summary) != component.doc:
        facts["doc"] = component.doc
    return facts | _of_annotations(component)


def _further_files(model: Model, component: Component) -> list[str]:
    """Return the base names of the IDL files that declare no port's type."""
    named = {file_of(model, port) for port in component.ports}
    needed = declarations_of(model, component)
    files = dict.fromkeys(PurePosixPath(each.file).name for each in needed)
    return [file for file in files if file not in named]


def file_of(model: Model, port: Port) -> str:
    """Return the base name of the file that declares a port's type; empty for a basic type."""
    if not isinstance(port.type, NamedType):
        return ""
    return PurePosixPath(model.find(port.type.name).file).name


def of_port(port: Port) -> Facts:
    """Return the facts of a data port, or of an interface of a service port."""
    facts: Facts = {}
    is_data = port.kind in (PortKind.INPORT, PortKind.OUTPORT)
    if not is_data and port.name != port.identifier:
        facts["name"] = port.name
    for field in ("name",) if is_data else ("port", "instance"):
        value = getattr(port, field)
        if value.strip() != value:
            facts[field] = value
    if port.type_name:
        facts |= {"type_name": port.type_name, "type": str(port.type)}
    return facts | _of_item(port)


def of_parameter(parameters: Parameters, parameter: ConfigurationParameter) -> Facts:
    """Return the facts of a parameter."""
    facts: Facts = {}
    word = parameters.profile_type(parameter.type)
    if type_of(word) != parameter.type:
        facts["type"] = str(parameter.type)
    default = parameter.default
    shown = parameters.default_text(parameter)
    if default is None or shown.strip() != shown or isinstance(default, Decimal):
        facts["default"] = None if default is None else value_to_json(default)
    if parameter.name.strip() != parameter.name:
        facts["name"] = parameter.name
    for key, bound in (("min", parameter.minimum), ("max", parameter.maximum)):
        if bound is not None:
            facts[key] = value_to_json(bound)
    tree = parameters.constraint(parameter)
    if parameter.constraint != ("" if tree is None else text_of(tree)):
        facts["constraint"] = parameter.constraint
    if parameter.widget == "text":
        facts["widget"] = "text"
    return facts | _of_item(parameter)


def _of_item(item: Port | ConfigurationParameter) -> Facts:
    facts: Facts = {}
    if profile_escapes.identifier(item.identifier) != item.identifier:
        facts["identifier"] = item.identifier
    if read_doc(item.doc) != item.doc:
        facts["doc"] = item.doc
    facts |= _of_annotations(item)
    return facts


def _of_annotations(item: Documented) -> Facts:
    entries = written_annotations(item)
    return {} if entries is None else {"annotations": annotations_to_json(entries)}


# How attributes are written and read.


def read_text(value: str, usual: str) -> str:
    """Return a component's text as it will be read back."""
    return value.strip() or usual


def read_doc(doc: str, otherwise: str = "") -> str:
    """Return a doc text as it will be read back; `otherwise` replaces an empty one."""
    return profile_escapes.lines(profile_escapes.written(doc) or otherwise)


def in_profile_order(ports: Sequence[Port]) -> list[Port]:
    """Return ports in the order of a profile: data ports, then interfaces by service port."""
    data = [p for p in ports if p.kind in (PortKind.INPORT, PortKind.OUTPORT)]
    return data + [port for group in by_service_port(ports).values() for port in group]


def by_service_port(ports: Sequence[Port]) -> dict[str, list[Port]]:
    """Return the interfaces by service port, in the order of their first ones."""
    grouped: dict[str, list[Port]] = {}
    for port in ports:
        if port.kind in (PortKind.PROVIDER, PortKind.CONSUMER):
            grouped.setdefault(port.port, []).append(port)
    return grouped
