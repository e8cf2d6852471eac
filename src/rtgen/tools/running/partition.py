"""Reduces a system to the components that one process runs (`--only`)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span
from rtgen.compiler.model import Connection, PortReference, System
from rtgen.compiler.systems import conditions
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.measures import Measure
from rtgen.compiler.systems.rules import ELSEWHERE
from rtgen.compiler.systems.timeline import (
    Action,
    Call,
    Connect,
    Disconnect,
    SetParameter,
    StateRequest,
    Step,
)

_OBSERVABLES = (conditions.POSE, conditions.GOAL)


def named(
    only: str | None, profile: System, outside: Collection[str] = ()
) -> frozenset[str]:
    """Return the instances of a comma-separated list, or all of them, except those `outside`."""
    if only is None:
        return frozenset(c.instance for c in profile.components) - {*outside}
    names = [name.strip() for name in only.split(",")]
    here = frozenset(conditions.require_instance(n, profile, None) for n in names)
    _raise_if_any(
        ELSEWHERE.at(None, f"--only: {name} is a foreign component of the system")
        for name in sorted(here & {*outside})
    )
    return here


def share(profile: System, here: Collection[str], *, data: bool = False) -> System:
    """Return the components of this process, and their connections."""
    connections = [c for c in profile.connections if _touches(c, here)]
    _raise_if_any(
        _between(c.name, c.source, c.target, c.span)
        for c in connections
        if not (c.service or data)
        and not (c.source.instance in here and c.target.instance in here)
    )
    others = {c.instance for c in profile.components} - {*here}
    elsewhere = {
        name
        for name, value in profile.properties
        if name in _OBSERVABLES and _without(others, value) != value
    }
    return replace(
        profile,
        components=tuple(c for c in profile.components if c.instance in here),
        connections=tuple(connections),
        properties=tuple(
            (name, text)
            for name, value in profile.properties
            if (text := _without(others, value) if name in _OBSERVABLES else value)
            # Only the process with pose and goal can evaluate the end.
            and not (elsewhere and name == conditions.TOLERANCE)
        ),
    )


def alone(profile: System, here: Collection[str]) -> System:
    """Return the components of this process, and the connections between them."""
    shared = share(profile, here, data=True)
    return replace(
        shared,
        connections=tuple(
            c
            for c in shared.connections
            if c.source.instance in here and c.target.instance in here
        ),
        activation=tuple(s for s in shared.activation if s.instance in here),
    )


def _without(others: Collection[str], observables: str) -> str:
    """Remove observables of other processes from a comma-separated list."""
    names = [name.strip() for name in observables.split(",")]
    return ", ".join(n for n in names if n.partition(".")[0] not in others)


def steps_here(
    steps: Sequence[Step],
    profile: System,
    here: Collection[str],
    *,
    data: bool = False,
) -> Sequence[Step]:
    """Return the steps of a timeline that concern this process.

    Raises InputError as `share` does.
    """
    service = {(c.source, c.target): c.service for c in profile.connections}
    names = {c.name for c in profile.connections if _touches(c, here)}
    result = []
    findings = []
    for step in steps:
        action = step.action
        if isinstance(action, Connect) and _touches(action, here):
            names.add(action.name)
            ends = action.source.instance in here, action.target.instance in here
            carried = data or service.get((action.source, action.target), True)
            if not all(ends) and not carried:
                findings.append(
                    _between(action.name, action.source, action.target, step.span)
                )
        if _concerns(action, names, here):
            result.append(step)
    _raise_if_any(findings)
    return result


def measures_here(
    measures: Sequence[Measure], here: Collection[str]
) -> Sequence[Measure]:
    """Return the measures that only concern components of this process."""
    return [
        measure
        for measure in measures
        if all(name.partition(".")[0] in here for name in measure.observables)
    ]


def condition_here(
    condition: Condition, here: Collection[str], *, asked: bool
) -> Condition:
    """Return the condition; None for another process's. Raises InputError if `asked` for."""
    instance = condition.instance
    if instance is None or instance in here:
        return condition
    if asked:
        raise InputError([_elsewhere(instance, "--until")])
    return Condition(condition.limit)


def require_here(settings: Sequence[SetParameter], here: Collection[str]) -> None:
    """Raise InputError for values of components of other processes."""
    _raise_if_any(
        _elsewhere(s.instance, "--set") for s in settings if s.instance not in here
    )


def _touches(link: Connection | Connect, here: Collection[str]) -> bool:
    return link.source.instance in here or link.target.instance in here


def _concerns(action: Action, names: Collection[str], here: Collection[str]) -> bool:
    match action:
        case Connect(name=name):
            return name in names
        case Disconnect(name, others):
            return not {name, *others}.isdisjoint(names)
        case StateRequest() | SetParameter() | Call():
            return action.instance in here


def _between(
    name: str, source: PortReference, target: PortReference, span: Span | None
) -> Diagnostic:
    return ELSEWHERE.at(
        span,
        f"{name}: data ports of two processes, {source} and {target}, cannot be connected",
        hint="name both instances in --only, or neither; or take --transport corba, dds or zenoh",
    )


def _elsewhere(instance: str, option: str) -> Diagnostic:
    return ELSEWHERE.at(
        None, f"{option}: {instance} is not among the components that --only names"
    )


def _raise_if_any(findings: Sequence[Diagnostic] | Iterator[Diagnostic]) -> None:
    diagnostics = [*findings]
    if diagnostics:
        raise InputError(diagnostics)
