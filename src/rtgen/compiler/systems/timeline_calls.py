"""Checks of the calls in timelines against the definitions of the components."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.model import (
    Interface,
    Member,
    Model,
    Operation,
    Port,
    PortKind,
    System,
)
from rtgen.compiler.model.system_links import Known, definitions_of
from rtgen.compiler.systems.rules import TIMELINE
from rtgen.compiler.systems.timeline import Call, Step

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
    interface = model.declared(port.type)
    if not isinstance(interface, Interface) or interface.forward:
        return None
    lines = (interface, *model.bases(interface))
    return [o for each in lines for o in each.operations]


def _of_operation(
    call: Call, operation: Operation, model: Model
) -> Iterator[tuple[str, str | None]]:
    # imported lazily: only timelines with calls need the runtime's types
    from rtgen.compiler.typemap.data_classes import NoTypeError, Types
    from rtgen.runtime.system.json_calls import CallError, request_of

    name = operation.name
    sent = [
        Member(name=p.name, type=p.type, span=p.span)
        for p in operation.parameters
        if p.direction in _SENT
    ]
    try:
        request = Types(model).request(name, sent)
        request_of(name, request, call.text.arguments)
    except CallError as error:
        message, mark, near = str(error).partition(": did you mean ")
        yield message, f"did you mean {near}" if mark else None
    except NoTypeError:
        yield f"{name} cannot be called with texts: objects are passed", None
    exceptions = [each[-1] for each in operation.raises]
    raised = call.raises.rpartition("::")[2]
    hint = guess(raised, exceptions)
    if raised and raised not in exceptions and hint is not None:
        yield f"{name} does not raise {call.raises}", hint
