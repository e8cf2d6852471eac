"""What is known of a module's values without running it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from rtgen.frontends.openrtm_python.source import Source

GLOBAL_STUBS = ("_GlobalIDL", "_GlobalIDL__POA")
"""The packages in which omniidl's Python back end puts what stands in no IDL module."""

GENERATED = ("rtgen", "runtime", "openrtm")
"""What modules that rtgen makes import."""

GENERATED_VARIABLE = "_c_"
"""What the variables of parameters begin with in them."""

_NO_STUBS = ("OpenRTM_aist", "omniORB")

Value: TypeAlias = Any
"""A constant, list, tuple or dict of Python, or one of the classes below."""

CONSTANTS = (str, int, float, bytes, type(None))


@dataclass(frozen=True, slots=True)
class Unknown:
    """A value that only running the module tells; `choices` are what it may be, if known."""

    choices: tuple[Value, ...] = ()


UNKNOWN = Unknown()


@dataclass(eq=False, slots=True)
class Named:
    """What an import or a name stands for that has no definition here, by its dotted name.

    `imported`: an import says so; else it may come from any module that is imported by `*`.
    """

    path: tuple[str, ...]
    imported: bool = False


@dataclass(eq=False, slots=True)
class Made:
    """The outcome of a call of something that has no definition here, or of a class.

    `certain`: it is made in any case.
    """

    path: tuple[str, ...]
    imported: bool
    arguments: list[Value]
    keywords: dict[str, Value]
    node: ast.Call
    file: str
    certain: bool

    def argument(self, place: int, *names: str) -> Value:
        """An argument by its place, or by one of its names; UNKNOWN where it is not given."""
        if place < len(self.arguments):
            return self.arguments[place]
        return next((self.keywords[n] for n in names if n in self.keywords), UNKNOWN)

    def __str__(self) -> str:
        return self.path[-1] if self.path else ""


@dataclass(eq=False, slots=True)
class Module:
    """A module that was read: the names that it defines, and what it imports by `*`."""

    source: Source
    tree: ast.Module
    names: dict[str, Value] = field(default_factory=dict)
    open_modules: list[str] = field(default_factory=list)
    open_names: list[Module] = field(default_factory=list)

    def find(self, name: str) -> Value | None:
        """What a name stands for; None if the module says nothing of it."""
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
    """A function, or a method with the class that has it."""

    node: ast.FunctionDef
    module: Module
    owner: Class | None = None


@dataclass(eq=False, slots=True)
class Component:
    """The object that `self` is: its attributes, and its class with all that it derives from."""

    line: list[Class]
    attributes: dict[str, Value] = field(default_factory=dict)

    def method(self, name: str, behind: Class | None = None) -> Function | None:
        """The method of that name; of a class behind another in the line if that is given."""
        place = 0 if behind is None else self.line.index(behind) + 1
        for each in self.line[place:]:
            for node in each.node.body:
                if isinstance(node, ast.FunctionDef) and node.name == name:
                    return Function(node, each.module, each)
        return None


@dataclass(eq=False, slots=True)
class Frame:
    """Where a statement stands: its module, its function's variables, and `self`."""

    module: Module
    names: dict[str, Value] | None = None
    component: Component | None = None
    owner: Class | None = None

    def find(self, name: str) -> Value:
        """What a name stands for."""
        if self.names is not None and name in self.names:
            return self.names[name]
        found = self.module.find(name)
        return Named((name,)) if found is None else found

    def bind(self, name: str, value: Value) -> None:
        """Gives a name a value."""
        (self.module.names if self.names is None else self.names)[name] = value

    def inner(self) -> Frame:
        """The frame of an expression with variables of its own."""
        return Frame(self.module, dict(self.names or {}), self.component, self.owner)


@dataclass(frozen=True, slots=True)
class Bound:
    """An attribute of an object that is looked up to be called."""

    holder: Value
    name: str
    function: Function | None = None


@dataclass(frozen=True, slots=True)
class Super:
    """`super()` in a method of a class."""

    holder: Component
    owner: Class


def alternatives(value: Value) -> Iterator[Value]:
    """The value, or all that an unknown one may be."""
    if isinstance(value, Unknown):
        for choice in value.choices:
            yield from alternatives(choice)
    else:
        yield value


def merged(one: Value, other: Value) -> Value:
    """What is known where either of two values is there."""
    same = one is other or (
        isinstance(one, CONSTANTS) and type(one) is type(other) and one == other
    )
    if same:
        return one
    choices = (*alternatives(one), *alternatives(other))
    return Unknown(choices[:20])


def dotted(node: ast.expr | None) -> tuple[str, ...]:
    """`a.b.c` as its names; empty for everything else."""
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return ()
    return (node.id, *reversed(names))


def scoped(value: Named | Made | Class | Value, open_modules: list[str]) -> str | None:
    """The IDL name of a class of stubs, None for what is none."""
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
