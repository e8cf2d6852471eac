"""Checks of the calls in timelines against the definitions of the components."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.model import (
    Enum,
    Interface,
    Model,
    NamedType,
    Operation,
    Port,
    PortKind,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    System,
    Type,
)
from rtgen.compiler.model.system_links import Known, definitions_of
from rtgen.compiler.systems.call_texts import Value
from rtgen.compiler.systems.rules import TIMELINE
from rtgen.compiler.systems.timeline import Call, Step
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES

_SENT: Final = ("in", "inout")
"""Directions of the parameters that a call passes."""


def findings(
    steps: Iterable[Step], system: System, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each call that does not fit; one of unknown components is left out."""
    ends = definitions_of(system, components)
    for step in steps:
        if isinstance(step.action, Call) and step.action.instance in ends:
            known = ends[step.action.instance]
            for message, hint in _problems(step.action, known):
                yield TIMELINE.at(step.span, message, hint=hint)


def _problems(call: Call, known: Known) -> Iterator[tuple[str, str | None]]:
    text = call.text
    ports = [p for p in known.component.ports if p.kind is PortKind.PROVIDER]
    named = [p for p in ports if text.port in _names(p)]
    if not named:
        hint = guess(text.port, [p.port for p in ports])
        yield f"{text.instance} provides no {text.port!r}", hint
        return
    declared = [_declared(known.model, p) for p in named]
    if None in declared:
        return
    operations = {o.name: o for each in declared for o in each or ()}
    operation = operations.get(text.operation)
    if operation is not None:
        yield from _of_operation(call, operation, known.model)
    elif not text.operation.startswith(("_get_", "_set_")):
        hint = guess(text.operation, operations)
        message = f"{text.instance}.{text.port} has no operation {text.operation!r}"
        yield message, hint


def _names(port: Port) -> Sequence[str]:
    return port.port, f"{port.port}.{port.instance}", f"{port.port}:{port.instance}"


def _declared(model: Model, port: Port) -> Sequence[Operation] | None:
    """Return the operations of an interface and its bases; None if it is not defined."""
    type_ = model.unalias(port.type)
    interface = model.find(type_.name) if isinstance(type_, NamedType) else None
    if not isinstance(interface, Interface) or interface.forward:
        return None
    lines = (interface, *model.bases(interface))
    return [o for each in lines for o in each.operations]


def _of_operation(
    call: Call, operation: Operation, model: Model
) -> Iterator[tuple[str, str | None]]:
    name = operation.name
    sent = {p.name: p.type for p in operation.parameters if p.direction in _SENT}
    pairs: dict[str, Value] = {}
    for number, (parameter, value) in enumerate(call.text.arguments):
        if number >= len(sent):
            known = ", ".join(sent) or "none"
            yield f"{name}: {len(call.text.arguments)} arguments; parameters: {known}", None
            return
        key = parameter or [*sent][number]
        if key not in sent:
            yield f"{name}: no parameter {key!r}", guess(key, sent)
            return
        pairs[key] = value
    for parameter, type_ in sent.items():
        if parameter not in pairs:
            yield f"{name}: {parameter} is missing", None
        elif problem := _problem(model, type_, pairs[parameter]):
            yield f"{name}: {parameter}: {problem}", None
    exceptions = [each[-1] for each in operation.raises]
    raised = call.raises.rpartition("::")[2]
    hint = guess(raised, exceptions)
    if raised and raised not in exceptions and hint is not None:
        yield f"{name} does not raise {call.raises}", hint


def _problem(model: Model, type_: Type, value: Any) -> str | None:
    """Return why a value is none of a type; None if it may be one."""
    target = model.unalias(type_)
    declaration = model.find(target.name) if isinstance(target, NamedType) else None
    match target, declaration:
        case PrimitiveType(kind=kind), _ if kind in INTEGER_RANGES:
            low, high = INTEGER_RANGES[kind]
            if type(value) is not int:
                return f"{value!r} is not an integer"
            return (
                None
                if low <= value <= high
                else f"{value} is out of the range of {kind}"
            )
        case PrimitiveType(kind=kind), _ if kind in FLOAT_LIMITS:
            fine = type(value) in (int, float) or value in ("nan", "inf", "-inf")
            return None if fine else f"{value!r} is not a number"
        case PrimitiveType(kind="boolean"), _:
            return (
                None if isinstance(value, bool) else f"{value!r} is not true or false"
            )
        case StringType(), _:
            return None if isinstance(value, str) else f"{value!r} is not a text"
        case SequenceType(element=element), _:
            if not isinstance(value, list):
                return f"{value!r} is not a list"
            return next(
                filter(None, (_problem(model, element, v) for v in value)), None
            )
        case _, Enum(members=members):
            names = [each.name for each in members]
            return (
                None
                if value in names
                else f"{value!r} is not one of {', '.join(names)}"
            )
        case _, Struct() if not isinstance(value, dict):
            return f"{value!r} is not an object"
    return None
