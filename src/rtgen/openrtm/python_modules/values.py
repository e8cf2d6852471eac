"""Abstract values: what is known of a module without running it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from rtgen.openrtm.python_modules.source import Source

GLOBAL_STUBS = ("_GlobalIDL", "_GlobalIDL__POA")
"""The packages in which omniidl's Python back end puts declarations outside of modules."""

GENERATED = ("rtgen", "runtime", "openrtm")
"""Modules imported by modules that rtgen generates."""

GENERATED_VARIABLE = "_c_"
"""Prefix of the variables of parameters in generated modules."""

_NO_STUBS = ("OpenRTM_aist", "omniORB")

Value: TypeAlias = Any
"""A constant, list, tuple or dict of Python, or one of the classes below."""

CONSTANTS = (str, int, float, bytes, type(None))


@dataclass(frozen=True, slots=True)
class Unknown:
    """A value unknown without running the module; `choices` are the candidates, if known."""

    choices: tuple[Value, ...] = ()


UNKNOWN = Unknown()


@dataclass(eq=False, slots=True)
class Named:
    """An import or name without a definition here, by its dotted name.

    `imported`: imported explicitly; else it may come from any module that is imported by `*`.
    """

    path: tuple[str, ...]
    imported: bool = False


@dataclass(eq=False, slots=True)
class Made:
    """The result of calling something without a definition here, or a class.

    `certain`: the call is unconditional.
    """

    path: tuple[str, ...]
    imported: bool
    arguments: list[Value]
    keywords: dict[str, Value]
    node: ast.Call
    file: str
    certain: bool

    def argument(self, place: int, *names: str) -> Value:
        """Return an argument by position, or by one of its names; UNKNOWN if it is not given."""
        if place < len(self.arguments):
            return self.arguments[place]
        return next((self.keywords[n] for n in names if n in self.keywords), UNKNOWN)

    def __str__(self) -> str:
        return self.path[-1] if self.path else ""


@dataclass(eq=False, slots=True)
class Module:
    """A module that was read: its names, and its imports by `*`."""

    source: Source
    tree: ast.Module
    names: dict[str, Value] = field(default_factory=dict)
    open_modules: list[str] = field(default_factory=list)
    open_names: list[Module] = field(default_factory=list)

    def find(self, name: str) -> Value | None:
        """Return the value of a name; None if the module does not define it."""
        if name in self.names:
            return self.names[name]
        for other in self.open_names:
            if name in other.names:
                return other.names[name]
        return None


@dataclass(eq=False, slots=True)
class Class:
    """A class statement."""

    node: ast.ClassDef
    module: Module


@dataclass(eq=False, slots=True)
class Function:
    """A function, or a method with its class."""

    node: ast.FunctionDef
    module: Module
    owner: Class | None = None


@dataclass(eq=False, slots=True)
class Component:
    """The object `self`: its attributes, and its class with all bases."""

    line: list[Class]
    attributes: dict[str, Value] = field(default_factory=dict)

    def method(self, name: str, after: Class | None = None) -> Function | None:
        """Return the method of that name; with `after`, the next one in the resolution order."""
        place = 0 if after is None else self.line.index(after) + 1
        for each in self.line[place:]:
            for node in each.node.body:
                if isinstance(node, ast.FunctionDef) and node.name == name:
                    return Function(node, each.module, each)
        return None


@dataclass(eq=False, slots=True)
class Frame:
    """The environment of a statement: module, variables of the function, and `self`."""

    module: Module
    names: dict[str, Value] | None = None
    component: Component | None = None
    owner: Class | None = None

    def find(self, name: str) -> Value:
        """Return the value of a name."""
        if self.names is not None and name in self.names:
            return self.names[name]
        value = self.module.find(name)
        return Named((name,)) if value is None else value

    def bind(self, name: str, value: Value) -> None:
        """Assign a value to a name."""
        (self.module.names if self.names is None else self.names)[name] = value

    def inner(self) -> Frame:
        """Return the frame of an expression with variables of its own."""
        return Frame(self.module, dict(self.names or {}), self.component, self.owner)


@dataclass(frozen=True, slots=True)
class Bound:
    """A method that was looked up to be called."""

    holder: Value
    name: str
    function: Function | None = None


@dataclass(frozen=True, slots=True)
class Super:
    """`super()` in a method of a class."""

    holder: Component
    owner: Class


def alternatives(value: Value) -> Iterator[Value]:
    """Yield the value, or all candidates of an unknown one."""
    if isinstance(value, Unknown):
        for choice in value.choices:
            yield from alternatives(choice)
    else:
        yield value


def merged(one: Value, other: Value) -> Value:
    """Return what is known of a value that is one of two."""
    same = one is other or (
        isinstance(one, CONSTANTS) and type(one) is type(other) and one == other
    )
    if same:
        return one
    choices = (*alternatives(one), *alternatives(other))
    return Unknown(choices[:20])


def dotted(node: ast.expr | None) -> tuple[str, ...]:
    """Return the names in `a.b.c`; empty for any other expression."""
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return ()
    return (node.id, *reversed(names))


def scoped(value: Named | Made | Class | Value, open_modules: list[str]) -> str | None:
    """Return the IDL name of a class of stubs; None for other classes."""
    if not isinstance(value, Named | Made) or not value.path:
        return None
    path = value.path
    if not value.imported and len(path) == 1:
        stubs = [m for m in open_modules if m.split(".")[0] not in _NO_STUBS]
        if not stubs:
            return None
        path = (*(stubs if len(stubs) == 1 else ()), *path)
    if path[0] in GLOBAL_STUBS:
        path = path[1:]
    path = tuple(part.removesuffix("__POA") for part in path)
    return "::".join(path) if path and path[0] != "OpenRTM_aist" else None
