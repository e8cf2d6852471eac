"""Events during a run as values: `timeline.toml`, `--until`, `--set`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeAlias

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span, ToolError
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.kit import toml_text
from rtgen.compiler.kit.xml_text import NOT_IN_XML
from rtgen.compiler.model import PortReference, System
from rtgen.compiler.systems import measures
from rtgen.compiler.systems.call_texts import CallText, CallTextError
from rtgen.compiler.systems.call_texts import parse as parse_call
from rtgen.compiler.systems.conditions import SECOND, require_instance
from rtgen.compiler.systems.measures import Measure
from rtgen.compiler.systems.rules import (
    PARAMETER,
    SKIPPED,
    TIMELINE,
    TIMELINE_FILE,
    UNKNOWN_INSTANCE,
)
from rtgen.facts.connector_properties import embedded_properties
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file

_ENTRY = re.compile(r"\s*\[\[\s*(\w+)\s*\]\]")
_SUB = re.compile(r"\s*(?:\[\s*at\s*\.\s*)?[\"']?(\w+)[\"']?\s*[\]=.]")
_REQUESTS: Final = ("deactivate", "reset", "activate")
_ORDER = ("disconnect", "connect", "set", *_REQUESTS, "call")
"""Order of events at the same time."""
_SECTIONS = ("at", "measure", "follows")
_LINK_KEYS = frozenset({"from", "to", "name", "properties"})
_ENDS = frozenset({"from", "to"})
_MAX_BYTES = 1024 * 1024
_MAX_FOLLOWED = 8


@dataclass(frozen=True, slots=True)
class Disconnect:
    """Remove the connection of that name, or of the first of `others` that exists instead."""

    name: str
    others: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Connect:
    """Connect two ports."""

    name: str
    source: PortReference
    target: PortReference
    properties: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Set a parameter in the active configuration set."""

    instance: str
    parameter: str
    text: str


@dataclass(frozen=True, slots=True)
class StateRequest:
    """Request a transition of the component: `activate`, `deactivate` or `reset`."""

    request: str
    instance: str


@dataclass(frozen=True, slots=True)
class Call:
    """Call an operation; `raises` is the exception that it is to raise, empty for none."""

    text: CallText
    raises: str = ""

    @property
    def instance(self) -> str:
        """The instance that provides the operation."""
        return self.text.instance


Action: TypeAlias = Disconnect | Connect | SetParameter | StateRequest | Call

_KINDS = {
    Disconnect: "disconnect",
    Connect: "connect",
    SetParameter: "set",
    Call: "call",
}


@dataclass(frozen=True, slots=True)
class Step:
    """An action at a time in ns since the start."""

    time: int
    action: Action
    span: Span


@dataclass(frozen=True, slots=True)
class Timeline:
    """The events in order of time, the measures, and warnings about events that are skipped."""

    steps: Sequence[Step] = ()
    measures: Sequence[Measure] = ()
    skipped: Sequence[Diagnostic] = ()


def assignment(text: str, system: System, span: Span | None = None) -> SetParameter:
    """Parse `INSTANCE.PARAMETER=VALUE`. Raises InputError.

    Parameter names may contain dots, instance names may not.
    """
    name, equals, value = text.partition("=")
    instance, dot, parameter = name.strip().partition(".")
    if not (equals and dot and parameter):
        message = f"{text!r} is not INSTANCE.PARAMETER=VALUE"
        raise InputError([PARAMETER.at(span, message)])
    return SetParameter(
        require_instance(instance, system, span), parameter, value.strip()
    )


def parse(text: str, name: str, system: System) -> tuple[Step, ...]:
    """Parse the text of a timeline.toml, shown as `name`. Raises InputError.

    Events that name a component or a connection that the system lacks are not among the steps.
    """
    return _ordered(_read(text, name, system).found)


def load(file: Path, system: System) -> Timeline:
    """Read a timeline, preceded by those that it follows. Raises InputError."""
    readers = [*_chain(file, system, _MAX_FOLLOWED)]
    return Timeline(
        _ordered([step for reader in readers for step in reader.found]),
        [measure for reader in readers for measure in reader.measures],
        [finding for reader in readers for finding in reader.skipped],
    )


def of_system(path: Path, named: str | None, system: System) -> Timeline:
    """Return the timeline of that name, else the `timeline.toml` in the system's folder."""
    if named is not None:
        return load(Path(named), system)
    if path.is_dir() and (path / TIMELINE_FILE).is_file():
        return load(path / TIMELINE_FILE, system)
    return Timeline()


def followed(file: Path) -> list[Path]:
    """Return a timeline and those it follows, as far as they can be read."""
    files = [file]
    while len(files) <= _MAX_FOLLOWED:
        last = files[-1]
        try:
            text = decode(read_file(last, _MAX_BYTES), standard=True).normal
            name = _content(text, last.as_posix()).get("follows")
        except (UnreadableError, InputError):
            break
        if not isinstance(name, str):
            break
        files.append(last.parent / name)
    return files


def _ordered(steps: Sequence[Step]) -> tuple[Step, ...]:
    return tuple(sorted(steps, key=lambda step: (step.time, _place(step.action))))


def _chain(file: Path, system: System, most: int) -> Iterator[_Reader]:
    """Yield the readers of a timeline and of those it follows, the first one first."""
    name = file.as_posix()
    try:
        text = decode(read_file(file, _MAX_BYTES), standard=True).normal
    except UnreadableError as error:
        raise ToolError(f"cannot read {name}: {error}") from error
    before: list[_Reader] = []
    content = _content(text, name)
    if isinstance(followed := content.get("follows"), str):
        if most == 0:
            message = f"more than {_MAX_FOLLOWED} timelines follow each other"
            raise InputError([TIMELINE.at(Span(name, 1, 1, 1, 2), message)])
        before = [*_chain(file.parent / followed, system, most - 1)]
    yield from before
    yield _read(text, name, system, before[-1].links if before else ())


def _read(text: str, name: str, system: System, links: Sequence[_Link] = ()) -> _Reader:
    reader = _Reader(text, name, system, links)
    reader.read(_content(text, name))
    if reader.findings:
        raise InputError(reader.findings)
    return reader


def _content(text: str, name: str) -> dict[str, Any]:
    try:
        return toml_text.parse(text, name)
    except toml_text.TomlError as error:
        raise InputError(
            [TIMELINE.at(error.span, str(error), hint=error.hint)]
        ) from None


def _place(action: Action) -> int:
    """Return the position in the order of events at the same time."""
    if isinstance(action, StateRequest):
        return _ORDER.index(action.request)
    return _ORDER.index(_KINDS[type(action)])


class _Reader:
    """Parses the content of a timeline, with the place of each key."""

    def __init__(
        self, text: str, name: str, system: System, links: Sequence[_Link] = ()
    ) -> None:
        self._name = name
        self._system = system
        self._text = text.split("\n")
        self._entries = [
            (n, match[1])
            for n, line in enumerate(self._text, 1)
            if (match := _ENTRY.match(line))
        ]
        self._own = [
            _Link(c.name, c.id, c.source, c.target) for c in system.connections
        ]
        self.links = [*(links or self._own)]
        """The connections that can exist: those of the system and of the timelines so far."""
        self.found: list[Step] = []
        self.measures: list[Measure] = []
        self.skipped: list[Diagnostic] = []
        self.findings: list[Diagnostic] = []

    def read(self, content: dict[str, Any]) -> None:
        """Fill `found`, `measures`, `skipped` and `findings`."""
        for key in content:
            if key not in _SECTIONS:
                choices = "[[at]], [[measure]] and follows"
                self._refuse(
                    self._span("", -1), f"unknown section {key!r}; known: {choices}"
                )
        if not isinstance(content.get("follows", ""), str):
            self._refuse(self._span("", -1), "'follows' must name a file")
        self.found = [*self._steps(self._tables(content, "at"))]
        for number, entry in enumerate(self._tables(content, "measure")):
            try:
                self.measures.append(
                    measures.parse(entry, partial(self._span, "measure", number))
                )
            except InputError as error:
                self.findings += error.diagnostics

    def _tables(self, content: dict[str, Any], section: str) -> list[dict[str, Any]]:
        entries = content.get(section, [])
        if isinstance(entries, list) and all(isinstance(e, dict) for e in entries):
            return entries
        message = f"{section!r} must be a list of tables: [[{section}]]"
        self._refuse(self._span("", -1), message)
        return []

    def _steps(self, entries: list[dict[str, Any]]) -> Iterator[Step]:
        # A connection to cut can be one that the timeline makes, so `connect` entries are read
        # first.
        for kinds in (("connect",), tuple(k for k in _ORDER if k != "connect")):
            for number, entry in enumerate(entries):
                yield from self._entry(entry, number, kinds)

    def _entry(
        self, entry: dict[str, Any], number: int, kinds: tuple[str, ...]
    ) -> Iterator[Step]:
        time: Any = entry.get("t")
        fine = isinstance(time, int | float) and not isinstance(time, bool)
        if not fine or not 0 <= time < 1e9:
            if kinds[0] == "connect":
                place = self._span("at", number, "t")
                self._refuse(place, "an instant needs t, a time in seconds from 0")
            return
        for key in entry:
            if kinds[0] == "connect" and key != "t" and key not in _ORDER:
                choices = ", ".join(_ORDER)
                place = self._span("at", number, key)
                message = f"unknown key {key!r}; known: t, {choices}"
                hint = guess(key, ("t", *_ORDER))
                self.findings.append(TIMELINE.at(place, message, hint=hint))
        for kind in kinds:
            span = self._span("at", number, kind)
            values = entry.get(kind, [])
            for value in values if isinstance(values, list) else [values]:
                try:
                    for action in self._actions(kind, value, span):
                        yield Step(round(time * SECOND), action, span)
                except InputError as error:
                    for finding in error.diagnostics:
                        self._report(finding)

    def _report(self, finding: Diagnostic) -> None:
        """Enter a finding; an event without its component or connection is skipped."""
        if finding.code in (UNKNOWN_INSTANCE.code, SKIPPED.code):
            message = f"{finding.message}: the event is skipped"
            self.skipped.append(SKIPPED.at(finding.span, message, hint=finding.hint))
        else:
            self.findings.append(finding)

    def _actions(self, kind: str, value: Any, span: Span) -> Iterator[Action]:
        match kind, value:
            case "connect", dict():
                yield self._new_connection(value, span)
            case "disconnect", dict():
                yield self._between(value, span)
            case "set", dict():
                yield from self._settings(value, span)
            case "call", {"to": str(text), **others} if {*others} <= {"raises"}:
                yield self._call(text, others.get("raises", ""), span)
            case _, str():
                yield self._named(kind, value, span)
            case _:
                forms = "names" if kind in _REQUESTS else _FORMS[kind]
                message = f"{kind!r} takes {forms}, not {value!r}"
                raise InputError([TIMELINE.at(span, message)])

    def _named(self, kind: str, value: str, span: Span) -> Action:
        match kind:
            case "set":
                return assignment(value, self._system, span)
            case "disconnect":
                return Disconnect(self._link(value, span, self.links).name)
            case "call":
                return self._call(value, "", span)
        if kind in _REQUESTS:
            return StateRequest(kind, require_instance(value, self._system, span))
        links = self._own
        name = self._link(value, span, links).name
        connection = next(c for c in self._system.connections if c.name == name)
        return Connect(
            name,
            connection.source,
            connection.target,
            embedded_properties(connection.properties),
        )

    def _call(self, text: str, raises: object, span: Span) -> Call:
        try:
            call = parse_call(text)
        except CallTextError as error:
            raise InputError([TIMELINE.at(span, str(error))]) from None
        if not isinstance(raises, str):
            message = f"'raises' names an exception, not {raises!r}"
            raise InputError([TIMELINE.at(span, message)])
        require_instance(call.instance, self._system, span)
        return Call(call, raises)

    def _link(self, text: str, span: Span, links: list[_Link]) -> _Link:
        """Find a connection by name, or else by connector id."""
        for matches in (
            [link for link in links if link.name == text],
            [link for link in links if link.id and link.id == text],
        ):
            if matches:
                return matches[0]
        choices = ", ".join(dict.fromkeys(link.name for link in links)) or "none"
        message = f"no connection {text!r} in the system"
        raise InputError([SKIPPED.at(span, message, hint=f"known: {choices}")])

    def _between(self, value: dict[str, Any], span: Span) -> Disconnect:
        """Return the cut of the connection of two ports, in either direction.

        It can be one of the system, or one that the timeline makes while that is cut.
        """
        if set(value) != _ENDS:
            message = "'disconnect' requires a name, or a table of from and to"
            raise InputError([TIMELINE.at(span, message)])
        ends = {self._end(value[key], span) for key in ("from", "to")}
        joined = [k for k in self.links if {k.source, k.target} == ends]
        names = [*dict.fromkeys(each.name for each in joined)]
        own = {each.name for each in joined if each in self._own}
        what = f"{value['from']} and {value['to']}"
        if not names:
            raise InputError([SKIPPED.at(span, f"no connection joins {what}")])
        if len(own) > 1 or len(names) - len(own) > 1:
            message = f"several connections join {what}"
            hint = f"name one of them: {', '.join(names)}"
            raise InputError([TIMELINE.at(span, message, hint=hint)])
        return Disconnect(names[0], tuple(names[1:]))

    def _new_connection(self, value: dict[str, Any], span: Span) -> Connect:
        texts = {k: v for k, v in value.items() if k != "properties"}
        properties = value.get("properties", {})
        fine = isinstance(properties, dict) and _ENDS <= set(value) <= _LINK_KEYS
        if not fine or not all(
            isinstance(v, str) for v in (*texts.values(), *properties.values())
        ):
            message = (
                "'connect' requires a name, or a table of from, to, name and properties"
            )
            raise InputError([TIMELINE.at(span, message)])
        ends = [self._end(texts[key], span) for key in ("from", "to")]
        name = texts.get("name", f"{texts['from']}-{texts['to']}")
        self.links.append(_Link(name, "", ends[0], ends[1]))
        return Connect(name, ends[0], ends[1], properties)

    def _settings(self, value: dict[str, Any], span: Span) -> Iterator[SetParameter]:
        """Parse `{ "A0.gain" = 2 }` or `{ A0.gain = 2 }`, which TOML reads as nested tables."""
        for name, content in value.items():
            pairs = {"": content}
            if isinstance(content, dict):
                pairs = {f".{key}": item for key, item in content.items()}
            for rest, item in pairs.items():
                text = _parameter_text(item)
                if text is None:
                    message = f"{name}{rest}: a parameter cannot be {item!r}"
                    raise InputError([PARAMETER.at(span, message)])
                yield assignment(f"{name}{rest}={text}", self._system, span)

    def _end(self, text: object, span: Span) -> PortReference:
        instance, dot, port = str(text).partition(".")
        is_name = isinstance(text, str) and dot and port and not NOT_IN_XML.search(port)
        if not is_name:
            raise InputError([TIMELINE.at(span, f"{text!r} is not INSTANCE.PORT")])
        return PortReference(
            instance=require_instance(instance, self._system, span), port=port
        )

    def _refuse(self, span: Span, message: str) -> None:
        self.findings.append(TIMELINE.at(span, message))

    def _span(self, section: str, number: int, key: str = "") -> Span:
        """Return the place of a key of an entry, defaulting to the entry."""
        places = [n for n, (_, name) in enumerate(self._entries) if name == section]
        if not 0 <= number < len(places):
            return Span(self._name, 1, 1, 1, 7)
        place = places[number]
        line = self._entries[place][0]
        following = self._entries[place + 1 : place + 2]
        end = following[0][0] - 1 if following else None
        for n, text in enumerate(self._text[line:end], line + 1):
            match = _SUB.match(text)
            if key and match and match[1] == key:
                column = match.start(1) + 1
                return Span(self._name, n, column, n, column + len(key))
        return Span(self._name, line, 1, line, 5 + len(section))


@dataclass(frozen=True, slots=True)
class _Link:
    """A connection, of the system or of the timeline."""

    name: str
    id: str
    source: PortReference
    target: PortReference


_FORMS = {
    "connect": "names, or a table of from, to, name and properties",
    "disconnect": "names, or a table of from and to",
    "set": "INSTANCE.PARAMETER=VALUE, or a table",
    "call": "INSTANCE.PORT.OPERATION(arguments), or a table of to and raises",
}


def _parameter_text(value: object) -> str | None:
    """Convert a TOML value to the text of a parameter; None if it is not a parameter value."""
    match value:
        case str():
            return value
        case bool():
            return str(int(value))
        case int() | float():
            return repr(value)
        case list():
            items = [_parameter_text(item) for item in value]
            return None if None in items else ",".join(map(str, items))
    return None
