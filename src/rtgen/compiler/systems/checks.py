"""Validates a system against the definitions of its components (codes RTC058x)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Rule, Severity
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.model import ConfigurationParameter, System, SystemComponent
from rtgen.compiler.model.system_links import Known
from rtgen.compiler.systems import conditions, connections
from rtgen.compiler.typemap.components.parameters import Parameters, ValueMismatchError
from rtgen.facts import parameter_texts

UNKNOWN_COMPONENT = Rule(
    "RTC0580", "system with a component that is not defined", Severity.ERROR
)
SYSTEM_PARAMETER = Rule(
    "RTC0586",
    "configuration that the component's definition does not have",
    Severity.ERROR,
)
OTHER_DEFINITION = Rule("RTC0592", "id is not that of the definition", Severity.WARNING)

RULES = (UNKNOWN_COMPONENT, SYSTEM_PARAMETER, OTHER_DEFINITION, *connections.RULES)

_ASCENDING = (Severity.NOTE, Severity.WARNING, Severity.ERROR)


def check(system: System, components: Mapping[str, Known]) -> list[Diagnostic]:
    """Return all diagnostics about a system; `components` maps type names to definitions."""
    diagnostics = [
        *conditions.check_properties(system),
        *connections.findings(system, components),
    ]
    for c in system.components:
        diagnostics += _component(c, components)
    return diagnostics


def as_warnings(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics as warnings, for commands that only read and write a system."""
    return [
        replace(f, severity=min(f.severity, Severity.WARNING, key=_ASCENDING.index))
        for f in findings
    ]


def check_properties(system: System) -> Iterator[Diagnostic]:
    """Yield diagnostics about properties, which require no definitions."""
    yield from conditions.check_properties(system)
    yield from connections.findings(system, {})


def _component(
    c: SystemComponent, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    definition = components.get(c.type)
    if definition is None:
        hint = guess(c.type, components) or "give its definition as a source"
        message = f"the component {c.type!r} of {c.instance} is not defined"
        yield UNKNOWN_COMPONENT.at(c.span, message, hint=hint)
        return
    id_ = definition.component.profile_id
    if c.id not in (id_, _dotted(id_)):
        message = f"the id of {c.instance} is {c.id!r}, its definition's {id_!r}"
        yield OTHER_DEFINITION.at(c.span, message)
    parameters = {p.name: p for p in definition.component.configuration}
    reader = Parameters(definition.model)
    for set_id, values in c.parameter_sets:
        for name, text in values:
            span = c.places.get((set_id, name), c.span)
            parameter = parameters.get(name)
            if parameter is None:
                message = f"{c.type} has no parameter {name!r}"
                near = guess(name, parameters)
                yield SYSTEM_PARAMETER.at(span, message, hint=near)
            elif problem := _value_problem(reader, parameter, text):
                message = f"{c.instance}.{name} cannot be {text[:80]!r}: {problem}"
                yield SYSTEM_PARAMETER.at(span, message)


def _dotted(id_: str) -> str:
    """Return the older form of a component's id, `RTC:vendor.category.type:version`."""
    head, *parts, version = id_.split(":")
    return f"{head}:{'.'.join(parts)}:{version}"


def _value_problem(
    reader: Parameters, parameter: ConfigurationParameter, text: str
) -> str | None:
    """Return the error in the text of one or several numbers; None if it is valid."""
    if not reader.is_number(parameter.type):
        return None
    item = reader.item_type(parameter.type)
    try:
        for part in (
            parameter_texts.items(text)
            if reader.is_sequence(parameter.type)
            else [text]
        ):
            reader.check_value(item, reader.parse_item(item, part))
    except ValueMismatchError as error:
        return str(error)
    return None
