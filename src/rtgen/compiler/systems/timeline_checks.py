"""Checks of the timelines beside systems, without a run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
    Timeline,
    load,
)
from rtgen.facts.files import is_file

_SYSTEM = "system.xml"


def findings(
    systems: Iterable[Path],
    encoding: str = "auto",
    models: Sequence[Model] = (),
    calls: Callable[[str, str], bool] | None = None,
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of systems with the timelines that their runs carry out by default.

    That is the `timeline.toml` in the folder of a `system.xml`. A system with errors is left out.
    `calls` returns whether the behaviour of a component type uses a port; with it, consumers that
    nothing joins are reported.
    """
    components = known_components(models)
    for path in systems:
        file = path.parent / TIMELINE_FILE
        has_plan = path.name == _SYSTEM and is_file(file)
        if calls is None and not has_plan:
            continue
        system, _, _ = read_file(path, encoding)
        if system is None:
            continue
        [system] = as_defined([system], models)
        links: list[Connection] = []
        if has_plan:
            try:
                plan = load(file, system)
            except InputError as error:
                yield from error.diagnostics
                continue
            except ToolError as error:
                place = Span(file.as_posix(), 1, 1, 1, 1)
                yield TIMELINE.at(place, error.message, hint=error.hint)
                continue
            links = [*new_connections(plan.steps, system, components)]
            yield from _of_plan(plan, system, links, models, components)
        if calls is not None:
            yield from connections.unserved(system, links, components, calls)


def _of_plan(
    plan: Timeline,
    system: System,
    links: Sequence[Connection],
    models: Sequence[Model],
    components: Mapping[str, Known],
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of a timeline, which makes the connections `links`."""
    yield from plan.skipped
    yield from _in_vain(plan.steps, system)
    yield from timeline_calls.findings(plan.steps, system, components)
    yield from _values(plan.steps, system, components)
    [named] = as_defined([replace(system, connections=tuple(links))], models)
    # Connections of the same ports are made one after the other: `skipped` has those in vain.
    ends = definitions_of(named, components)
    for connection in named.connections:
        yield from connections.judged(connection, ends)


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
