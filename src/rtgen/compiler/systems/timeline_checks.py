"""Checks of the timelines beside systems, without a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span, ToolError
from rtgen.compiler.model import Connection, Model, System
from rtgen.compiler.model.system_links import Known, definitions_of, known_components
from rtgen.compiler.systems import connections, timeline_calls
from rtgen.compiler.systems.checks import parameter_problem
from rtgen.compiler.systems.reading import as_defined, read_file
from rtgen.compiler.systems.rules import PARAMETER, SKIPPED, TIMELINE, TIMELINE_FILE
from rtgen.compiler.systems.timeline import (
    Connect,
    Disconnect,
    SetParameter,
    Step,
    load,
)

_SYSTEM = "system.xml"


def findings(
    systems: Iterable[Path], encoding: str = "auto", models: Sequence[Model] = ()
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of the timelines that runs of systems carry out by default.

    That is the `timeline.toml` in the folder of a `system.xml`. A system with errors is left out.
    The ends of new connections are compared if `models` define their components.
    """
    components = known_components(models)
    for path in systems:
        file = path.parent / TIMELINE_FILE
        if path.name != _SYSTEM or not file.is_file():
            continue
        system, _, _ = read_file(path, encoding)
        if system is None:
            continue
        try:
            plan = load(file, system)
        except InputError as error:
            yield from error.diagnostics
        except ToolError as error:
            place = Span(file.as_posix(), 1, 1, 1, 1)
            yield TIMELINE.at(place, error.message, hint=error.hint)
        else:
            yield from plan.skipped
            yield from _in_vain(plan.steps, system)
            yield from timeline_calls.findings(plan.steps, system, components)
            yield from _values(plan.steps, system, components)
            links = new_connections(plan.steps, system, components)
            [named] = as_defined([replace(system, connections=tuple(links))], models)
            yield from connections.findings(named, components)


def new_connections(
    steps: Iterable[Step], system: System, components: Mapping[str, Known]
) -> Iterator[Connection]:
    """Yield the connections of a timeline that are not its system's, as the runtime makes them."""
    own = {(c.name, str(c.source), str(c.target)) for c in system.connections}
    ends = definitions_of(system, components)
    for step in steps:
        match step.action:
            case Connect(name, source, target, properties) if (
                name,
                str(source),
                str(target),
            ) not in own:
                yield connections.link(source, target, properties, ends, step.span)


def _values(
    steps: Iterable[Step], system: System, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each parameter that is not there or cannot have its value."""
    instances = {c.instance: c for c in system.components}
    for step in steps:
        match step.action:
            case SetParameter(instance, parameter, text):
                component = instances[instance]
                known = components.get(component.type)
                problem = known and parameter_problem(component, parameter, text, known)
                if problem:
                    message, hint = problem
                    yield PARAMETER.at(step.span, message, hint=hint)


def _in_vain(steps: Iterable[Step], system: System) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each event that its predecessors leave nothing to do."""
    present = {connection.name for connection in system.connections}
    for step in steps:
        match step.action:
            case Connect(name=name):
                if name in present:
                    yield _skipped(step, f"the connection {name!r} exists already")
                present.add(name)
            case Disconnect(name=name, others=others):
                cut = next((each for each in (name, *others) if each in present), None)
                if cut is None:
                    yield _skipped(step, f"no connection {name!r} at that time")
                else:
                    present.remove(cut)


def _skipped(step: Step, message: str) -> Diagnostic:
    return SKIPPED.at(step.span, f"{message}: the event is skipped")
