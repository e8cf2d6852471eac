"""The names that systems, timelines and `.conf` files use: of components, ports, parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    ExceptionDecl,
    Interface,
    Model,
    NamedType,
    Port,
    ScopedName,
    Struct,
)
from rtgen.tools.indexing.idl import key_of

_PART = re.compile(r"\.(\w+)")
_INDEX = re.compile(r"\[\d+\]")
_TYPE = re.compile(r"(?<![\w:/])(?:IDL:([\w/]+)(?=:[\d.])|(\w+(?:::\w+)+)(?![\w:/]))")

Place = tuple[int, int, str]
"""A name in a text, from one offset to another, with its key."""


def component_key(name: str) -> str:
    """Return the key of a component that a profile defines."""
    return f"component {name}"


@dataclass(frozen=True, slots=True)
class Names:
    """The keys of a component, and of its ports and parameters by the names of systems."""

    key: str
    ports: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, str] = field(default_factory=dict)
    types: dict[str, ScopedName] = field(default_factory=dict)

    @property
    def own(self) -> dict[str, str]:
        """The keys of ports and parameters."""
        return {**self.parameters, **self.ports}


class KnownComponents:
    """The components of a model, and of those of its packages, by the names of their types."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._profiles = {profile.name: profile for profile in model.profiles}
        self.types: dict[str, Names] = {}
        for each in (model, *(package.model for package in model.packages)):
            for declaration in each.declarations:
                if isinstance(declaration, Component):
                    name = declaration.name[-1]
                    if name not in self.types:
                        self.types[name] = self._names(declaration)
        for name in self._profiles:
            self.types.setdefault(name, Names(component_key(name)))

    def _names(self, component: Component) -> Names:
        name = component.name[-1]
        of_profile = name in self._profiles
        start = component_key(name) if of_profile else key_of(component.name)
        names = Names(start)

        def key(item: Port | ConfigurationParameter) -> str:
            if of_profile:
                return f"{start}.{item.name}"
            return key_of((*component.name, item.identifier))

        for parameter in component.configuration:
            names.parameters[parameter.name] = key(parameter)
        for port in component.ports:
            names.ports[port.name] = key(port)
            if isinstance(port.type, NamedType):
                names.types[port.name] = port.type.name
        for port in component.ports:
            if port.port and port.port not in names.ports:
                names.ports[port.port] = key(port)
                if isinstance(port.type, NamedType):
                    names.types[port.port] = port.type.name
        return names

    def paths(self, text: str, instances: Mapping[str, str]) -> Iterator[Place]:
        """Yield the names in each `INSTANCE.PORT.member` and `INSTANCE.PARAMETER` of a text.

        `instances` maps the names of instances to those of their types.
        """
        if not instances or "." not in text:
            return
        words = "|".join(map(re.escape, sorted(instances, key=len, reverse=True)))
        for match in re.finditer(rf"(?<![\w.])(?:{words})\.", text):
            names = self.types.get(instances[match[0][:-1]])
            if names is not None:
                yield from self._path(text, match.end(), names)

    def _path(self, text: str, start: int, names: Names) -> Iterator[Place]:
        name = word_at(text, start, names.own)
        if name is None:
            return
        place = start + len(name)
        yield start, place, names.own[name]
        scope = names.types.get(name)
        while scope is not None:
            if index := _INDEX.match(text, place):
                place = index.end()
            part = _PART.match(text, place)
            member = None if part is None else self.member(scope, part[1])
            if part is None or member is None:
                return
            yield part.start(1), part.end(), member[0]
            place, scope = part.end(), member[1]

    def member(
        self, scope: ScopedName, name: str
    ) -> tuple[str, ScopedName | None] | None:
        """Return the key of a member or an operation of a type, and the type of the member."""
        try:
            declaration = self._model.find(scope)
        except KeyError:
            return None
        match declaration:
            case Struct() | ExceptionDecl():
                for member in declaration.members:
                    if member.name == name:
                        type_ = self._model.unalias(member.type)
                        own = type_.name if isinstance(type_, NamedType) else None
                        return key_of((*scope, name)), own
                base = declaration.base if isinstance(declaration, Struct) else None
                return None if base is None else self.member(base, name)
            case Interface():
                names = {each.name for each in declaration.operations}
                if name in names.union(a.name for a in declaration.attributes):
                    return key_of((*scope, name)), None
                found = (self.member(base, name) for base in declaration.bases)
                return next((each for each in found if each is not None), None)
        return None

    def type_names(self, text: str) -> Iterator[Place]:
        """Yield the parts of each `IDL:A/B:1.0` and `A::B` in a text."""
        for match in _TYPE.finditer(text):
            group = 1 if match[1] is not None else 2
            place, scope = match.start(group), tuple[str, ...]()
            for part in re.split(r"(/|::)", match[group]):
                if part.strip("/:"):
                    scope = (*scope, part)
                    yield place, place + len(part), key_of(scope)
                place += len(part)


def word_at(text: str, start: int, words: Iterable[str]) -> str | None:
    """Return the longest of the words that a text has at a place, and which ends there."""
    for word in sorted(words, key=len, reverse=True):
        following = text[start + len(word) :][:1]
        inside = following.isalnum() or following == "_"
        if word and text.startswith(word, start) and not inside:
            return word
    return None
