"""What happens to a system while it runs: `timeline.toml`, `--until`, `--set`, as values."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from rtgen.diagnostics import Diagnostic, InputError, Span
from rtgen.model import PortReference, System
from rtgen.system_rules import CONDITION, PARAMETER, TIMELINE, UNKNOWN_INSTANCE

SECOND = 1_000_000_000

_AT = re.compile(r"\s*\[\[\s*at\s*\]\]")
_ORDER = ("disconnect", "connect", "set", "deactivate", "activate")
_LINK_KEYS = frozenset({"from", "to", "name", "properties"})
_PLACE = re.compile(r"\(at line (\d+), column (\d+)\)")


@dataclass(frozen=True, slots=True)
class Disconnect:
    """Cut the connection of that name."""

    name: str


@dataclass(frozen=True, slots=True)
class Connect:
    """Join two ports."""

    name: str
    source: PortReference
    target: PortReference
    properties: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Give a parameter another value, in the active configuration set."""

    instance: str
    parameter: str
    text: str


@dataclass(frozen=True, slots=True)
class Activate:
    """Activate the component."""

    instance: str


@dataclass(frozen=True, slots=True)
class Deactivate:
    """Deactivate the component."""

    instance: str


Action: TypeAlias = Disconnect | Connect | SetParameter | Activate | Deactivate


@dataclass(frozen=True, slots=True)
class Step:
    """An action at a time in ns since the start."""

    time: int
    action: Action
    span: Span


@dataclass(frozen=True, slots=True)
class Condition:
    """When a run ends: at `limit` ns, or once `instance` is in `state` (`ERROR`, ...)."""

    limit: int | None = None
    instance: str | None = None
    state: str | None = None


def condition(text: str, system: System, span: Span | None) -> Condition:
    """The condition that the text means (see rule SYS0006); InputError if none."""
    found = Condition()
    for part in text.split(","):
        instance, equals, state = part.strip().partition("=")
        if equals and found.instance is None:
            state = state.strip().upper().removesuffix("_STATE")
            if state not in ("CREATED", "INACTIVE", "ACTIVE", "ERROR"):
                message = f"no state {state!r} in {text!r}"
                hint = "CREATED, INACTIVE, ACTIVE or ERROR"
                raise InputError([CONDITION.at(span, message, hint=hint)])
            found = Condition(
                found.limit, require_instance(instance.strip(), system, span), state
            )
        elif not equals and found.limit is None:
            found = Condition(
                _seconds(instance, text, span), found.instance, found.state
            )
        else:
            raise InputError(
                [CONDITION.at(span, f"{text!r} says the same kind of thing twice")]
            )
    return found


def _seconds(part: str, text: str, span: Span | None) -> int:
    try:
        seconds = float(part)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds < 1e9:
        hint = "SECONDS, INSTANCE=STATE, or both with a comma between"
        raise InputError([CONDITION.at(span, f"{text!r} is no condition", hint=hint)])
    return round(seconds * SECOND)


def assignment(text: str, system: System, span: Span | None = None) -> SetParameter:
    """`INSTANCE.PARAMETER=VALUE` as an action; InputError if it is none.

    Parameter names may hold dots and instance names may not.
    """
    name, equals, value = text.partition("=")
    instance, dot, parameter = name.strip().partition(".")
    if not (equals and dot and parameter):
        message = f"{text!r} is not INSTANCE.PARAMETER=VALUE"
        raise InputError([PARAMETER.at(span, message)])
    return SetParameter(
        require_instance(instance, system, span), parameter, value.strip()
    )


def require_instance(instance: str, system: System, span: Span | None) -> str:
    """The name, if the system has such a component; InputError otherwise."""
    known = [c.instance for c in system.components]
    if instance not in known:
        from difflib import get_close_matches

        close = get_close_matches(instance, known, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
        finding = UNKNOWN_INSTANCE.at(
            span, f"no component {instance!r} in the system", hint=hint
        )
        raise InputError([finding])
    return instance


def parse(text: str, name: str, system: System) -> tuple[Step, ...]:
    """The steps of a timeline.toml, shown as `name`, in order of time; InputError if wrong."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = _PLACE.search(str(error))
        line, column = (
            (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, 1)
        )
        span = Span(name, line, column, line, column + 1)
        raise InputError(
            [TIMELINE.at(span, _PLACE.sub("", str(error)).strip())]
        ) from None
    except RecursionError:
        raise InputError(
            [TIMELINE.at(Span(name, 1, 1, 1, 2), "nested too deeply")]
        ) from None
    reader = _Reader(text, name, system)
    steps = [*reader.steps(content)]
    if reader.findings:
        raise InputError(reader.findings)
    return tuple(sorted(steps, key=lambda s: s.time))


class _Reader:
    def __init__(self, text: str, name: str, system: System) -> None:
        self._name = name
        self._system = system
        self._connections = {c.name: c for c in system.connections}
        self._lines = [
            n for n, line in enumerate(text.split("\n"), 1) if _AT.match(line)
        ]
        self.findings: list[Diagnostic] = []

    def steps(self, content: dict[str, Any]) -> Iterator[Step]:
        entries = content.get("at", [])
        for key in content:
            if key != "at":
                self._refuse(
                    self._span(-1), f"unknown section {key!r}; only [[at]] is known"
                )
        if not isinstance(entries, list) or not all(
            isinstance(e, dict) for e in entries
        ):
            self._refuse(self._span(-1), "'at' must be a list of tables: [[at]]")
            return
        for number, entry in enumerate(entries):
            yield from self._entry(entry, self._span(number))

    def _entry(self, entry: dict[str, Any], span: Span) -> Iterator[Step]:
        time = entry.get("t")
        if (
            isinstance(time, bool)
            or not isinstance(time, int | float)
            or not 0 <= time < 1e9
        ):
            self._refuse(span, "an instant needs t, a time in seconds from 0")
            return
        for key in entry:
            if key != "t" and key not in _ORDER:
                self._refuse(
                    span, f"unknown key {key!r}; known: t, {', '.join(_ORDER)}"
                )
        for kind in _ORDER:
            values = entry.get(kind, [])
            for value in values if isinstance(values, list) else [values]:
                try:
                    action = self._action(kind, value, span)
                except InputError as error:
                    self.findings += error.diagnostics
                else:
                    yield Step(round(time * SECOND), action, span)

    def _action(self, kind: str, value: Any, span: Span) -> Action:
        if kind == "connect" and isinstance(value, dict):
            return self._link(value, span)
        if not isinstance(value, str):
            raise InputError(
                [TIMELINE.at(span, f"{kind!r} takes names, not {value!r}")]
            )
        match kind:
            case "set":
                return assignment(value, self._system, span)
            case "activate":
                return Activate(require_instance(value, self._system, span))
            case "deactivate":
                return Deactivate(require_instance(value, self._system, span))
            case "disconnect":
                return Disconnect(value)
        if value not in self._connections:
            known = ", ".join(self._connections)
            message = f"no connection {value!r} in the system"
            raise InputError([TIMELINE.at(span, message, hint=f"known: {known}")])
        known_one = self._connections[value]
        properties = dict(known_one.properties)
        return Connect(value, known_one.source, known_one.target, properties)

    def _link(self, value: dict[str, Any], span: Span) -> Connect:
        texts = {k: v for k, v in value.items() if k != "properties"}
        properties = value.get("properties", {})
        fine = isinstance(properties, dict) and set(value) <= _LINK_KEYS
        if not fine or not all(
            isinstance(v, str) for v in (*texts.values(), *properties.values())
        ):
            message = (
                "'connect' takes a name, or a table of from, to, name and properties"
            )
            raise InputError([TIMELINE.at(span, message)])
        ends = [self._end(texts.get(key, ""), span) for key in ("from", "to")]
        return Connect(
            texts.get("name", f"{ends[0]}-{ends[1]}"), ends[0], ends[1], properties
        )

    def _end(self, text: str, span: Span) -> PortReference:
        instance, dot, port = text.partition(".")
        if not (dot and port):
            raise InputError([TIMELINE.at(span, f"{text!r} is not INSTANCE.PORT")])
        return PortReference(
            instance=require_instance(instance, self._system, span), port=port
        )

    def _refuse(self, span: Span, message: str) -> None:
        self.findings.append(TIMELINE.at(span, message))

    def _span(self, number: int) -> Span:
        line = self._lines[number] if 0 <= number < len(self._lines) else 1
        return Span(self._name, line, 1, line, 7)
