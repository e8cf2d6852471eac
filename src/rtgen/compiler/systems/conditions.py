"""What a system says about its runs: their end, and the components whose ERROR is their end."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model import System
from rtgen.compiler.systems.rules import CONDITION, SYSTEM_PROPERTY, UNKNOWN_INSTANCE
from rtgen.facts.openrtm_ports import FOREIGN

SECOND = 1_000_000_000

UNTIL = "rtgen.run.until"
FINISHES = "rtgen.run.finishes"
POSE = "rtgen.run.pose"
GOAL = "rtgen.run.goal"
TOLERANCE = "rtgen.run.tolerance"
PER_CYCLE = "rtgen.openrtm.per_cycle"
PROPERTIES = (UNTIL, FINISHES, POSE, GOAL, TOLERANCE, FOREIGN, PER_CYCLE)
"""The properties of a system that rtgen reads."""
_OWN = "rtgen."


@dataclass(frozen=True, slots=True)
class Condition:
    """The end of a run: at `limit` ns, or once `instance` is in `state` (`ERROR`, ...)."""

    limit: int | None = None
    instance: str | None = None
    state: str | None = None


def condition(text: str, system: System | None, span: Span | None) -> Condition:
    """Parse a condition (see rule SYS0006); None: of any system. Raises InputError."""
    result = Condition()
    for part in text.split(","):
        instance, equals, state = part.strip().partition("=")
        if equals and result.instance is None:
            state = state.strip().upper().removesuffix("_STATE")
            if state not in ("CREATED", "INACTIVE", "ACTIVE", "ERROR"):
                message = f"no state {state!r} in {text!r}"
                hint = "CREATED, INACTIVE, ACTIVE or ERROR"
                raise InputError([CONDITION.at(span, message, hint=hint)])
            instance = instance.strip()
            if system is not None:
                require_instance(instance, system, span)
            result = Condition(result.limit, instance, state)
        elif not equals and result.limit is None:
            result = Condition(
                _seconds(instance, text, span), result.instance, result.state
            )
        else:
            raise InputError(
                [CONDITION.at(span, f"{text!r} has two conditions of the same kind")]
            )
    return result


def _seconds(part: str, text: str, span: Span | None) -> int:
    try:
        seconds = float(part)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds < 1e9:
        hint = "SECONDS, INSTANCE=STATE, or both with a comma between"
        raise InputError(
            [CONDITION.at(span, f"{text!r} is not a condition", hint=hint)]
        )
    return round(seconds * SECOND)


def of_run(until: str | None, system: System, place: Span | None = None) -> Condition:
    """Return the condition `until`, which may have a place, else that of the system.

    Raises InputError.
    """
    text = dict(system.properties).get(UNTIL) if until is None else until
    if text is None:
        return Condition()
    if until is None:
        place = system.places.get(UNTIL)
    return condition(text, system, place)


def finishing(system: System) -> frozenset[str]:
    """Return the instances whose ERROR is the end of their work. Raises InputError.

    `rtgen.run.finishes` names them, and `rtgen.run.until`, if it waits for the ERROR of one.
    """
    names, span = listed(system, FINISHES), system.places.get(FINISHES)
    awaited = of_run(None, system)
    if awaited.instance is not None and awaited.state == "ERROR":
        names.append(awaited.instance)
    return frozenset(require_instance(name, system, span) for name in names)


def check_properties(system: System) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each of rtgen's properties that is not known, or cannot be read."""
    for name, _ in system.properties:
        if name.startswith(_OWN) and name not in PROPERTIES:
            near = nearest(name, PROPERTIES)
            hint = (
                f"did you mean {near}?" if near else f"known: {', '.join(PROPERTIES)}"
            )
            message = f"{name[:80]!r} is not a property of a system"
            yield SYSTEM_PROPERTY.at(system.places.get(name), message, hint=hint)
    try:
        finishing(system)
        for key in (POSE, GOAL):
            for name in listed(system, key):
                span = system.places.get(key)
                require_instance(name.partition(".")[0], system, span)
    except InputError as error:
        yield from error.diagnostics


def listed(system: System, key: str) -> list[str]:
    """Return the names of a property that is a list."""
    text = dict(system.properties).get(key, "")
    return [name for part in text.split(",") if (name := part.strip())]


def require_instance(instance: str, system: System, span: Span | None) -> str:
    """Return the name of a component of the system. Raises InputError for an unknown one."""
    instances = [c.instance for c in system.components]
    if instance not in instances:
        from difflib import get_close_matches

        close = get_close_matches(instance, instances, n=1)
        hint = (
            f"did you mean {close[0]!r}?" if close else f"known: {', '.join(instances)}"
        )
        finding = UNKNOWN_INSTANCE.at(
            span, f"no component {instance!r} in the system", hint=hint
        )
        raise InputError([finding])
    return instance
