"""Expressions of a module as far as they are known without running it."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field

GLOBAL_STUBS = ("_GlobalIDL", "_GlobalIDL__POA")
"""The packages in which omniidl's Python back end puts what stands in no IDL module."""


def text(node: ast.expr | None) -> str | None:
    """A text that is written out; texts may be joined by `+`, numbers turned into texts."""
    match node:
        case ast.Constant(value=str(value)):
            return value
        case ast.Call(
            func=ast.Name(id="str"),
            args=[ast.Constant(value=int() | float() as number)],
            keywords=[],
        ):
            return str(number)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            one, two = text(left), text(right)
            return None if one is None or two is None else one + two
    return None


def dotted(node: ast.expr | None) -> tuple[str, ...]:
    """`a.b.c` as its names; empty for everything else."""
    match node:
        case ast.Name(id=name):
            return (name,)
        case ast.Attribute(value=value, attr=name):
            before = dotted(value)
            return (*before, name) if before else ()
    return ()


def variable(node: ast.expr | None) -> str | None:
    """A member of `self`, as `self.x`, or a local variable."""
    names = dotted(node)
    if len(names) == 2 and names[0] == "self":
        return f"self.{names[1]}"
    return names[0] if len(names) == 1 else None


def argument(call: ast.Call, place: int, *names: str) -> ast.expr | None:
    """An argument of a call by its place, or by one of its names."""
    if place < len(call.args):
        return call.args[place]
    return next((k.value for k in call.keywords if k.arg in names), None)


def called(node: ast.expr | None) -> tuple[str, ...]:
    """The names of what a call calls; empty for everything else."""
    return dotted(node.func) if isinstance(node, ast.Call) else ()


_NO_STUBS = ("OpenRTM_aist", "omniORB")

GENERATED = ("rtgen", "runtime", "openrtm")
"""What modules that rtgen makes import."""

GENERATED_VARIABLE = "_c_"
"""What the variables of parameters begin with in them."""


@dataclass
class Imports:
    """What the names of imports stand for, as scoped names of IDL."""

    modules: dict[str, tuple[str, ...]] = field(default_factory=dict)
    open_modules: list[str] = field(default_factory=list)

    def note(self, node: ast.stmt) -> None:
        """Takes an import statement."""
        match node:
            case ast.Import(names=names):
                for alias in names:
                    path = tuple(alias.name.split("."))
                    self.modules[alias.asname or path[0]] = (
                        path if alias.asname else path[:1]
                    )
            case ast.ImportFrom(module=str(module), names=names):
                for alias in names:
                    if alias.name == "*":
                        self.open_modules.append(module)
                    else:
                        path = (*module.split("."), alias.name)
                        self.modules[alias.asname or alias.name] = path

    @property
    def generated(self) -> bool:
        """Whether it is a module that rtgen makes."""
        return any(path[:3] == GENERATED for path in self.modules.values())

    def scoped(self, names: tuple[str, ...]) -> str | None:
        """The IDL name of a class of stubs, None for what is none."""
        if not names:
            return None
        path = (*self.modules.get(names[0], names[:1]), *names[1:])
        if len(names) == 1 and names[0] not in self.modules:
            stubs = [m for m in self.open_modules if m.split(".")[0] not in _NO_STUBS]
            if not stubs:
                return None
            path = (*(stubs if len(stubs) == 1 else ()), *path)
        if path[0] in GLOBAL_STUBS:
            path = path[1:]
        path = tuple(part.removesuffix("__POA") for part in path)
        return "::".join(path) if path and path[0] != "OpenRTM_aist" else None
