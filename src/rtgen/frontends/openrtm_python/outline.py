"""Where in a module the component stands: its module spec, its class, and what is done there."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field

from rtgen.frontends.openrtm_python.values import (
    argument,
    called,
    dotted,
    text,
    variable,
)

_BASES = ("DataFlowComponentBase", "FiniteStateMachineComponentBase")
_KEY = "implementation_id"


def module_spec(tree: ast.Module) -> tuple[ast.expr, list[ast.expr]] | None:
    """The first list of texts with an implementation id: itself, and its items."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        items = list(_items(node.value))
        if any(text(item) == _KEY for item in items[::2]):
            return node.value, items
    return None


def _items(node: ast.expr) -> Iterator[ast.expr]:
    """The items of a list that is written out, of lists that are added to it, too."""
    match node:
        case ast.List(elts=items) | ast.Tuple(elts=items):
            for item in items:
                if isinstance(item, ast.Starred):
                    yield from _items(item.value)
                else:
                    yield item
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            if not isinstance(left, ast.Constant):
                yield from _items(left)
                yield from _items(right)


def component_classes(tree: ast.Module) -> list[ast.ClassDef]:
    """The class of the component, then those of the module that it derives from.

    It is the one that a factory is registered for, else the first that derives from OpenRTM's.
    """
    classes = {n.name: n for n in ast.walk(tree) if isinstance(n, ast.ClassDef)}
    known = [found for c in classes.values() if (found := _line(c, classes))]
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and called(call)[-1:] == ("registerFactory",):
            name = dotted(argument(call, 1, "new_func"))
            chosen = [line for line in known if (line[0].name,) == name]
            if chosen:
                return chosen[0]
    return known[0] if known else []


def _line(
    made: ast.ClassDef, classes: dict[str, ast.ClassDef], depth: int = 0
) -> list[ast.ClassDef]:
    """The class and those it derives from, if one of them derives from OpenRTM's."""
    for base in made.bases:
        name = dotted(base)[-1:]
        if name and name[0] in _BASES:
            return [made]
        above = classes.get(name[0]) if name else None
        if above is not None and depth < 20:
            rest = _line(above, classes, depth + 1)
            if rest:
                return [made, *rest]
    return []


@dataclass
class Body:
    """What classes do: the first value of each variable, annotations, and calls in order.

    Variables are `self.x`, and `x` for a local one, which is unknown where it is set twice.
    """

    values: dict[str, ast.expr] = field(default_factory=dict)
    types: dict[str, ast.expr] = field(default_factory=dict)
    calls: list[ast.Call] = field(default_factory=list)

    def take(self, made: ast.ClassDef) -> None:
        """Adds a class."""
        calls = []
        for node in ast.walk(made):
            match node:
                case ast.Assign(targets=targets, value=value):
                    for target in targets:
                        self._set(target, value)
                case ast.AnnAssign(target, annotation, ast.expr() as value):
                    self._set(target, value)
                    if (name := variable(target)) is not None:
                        self.types.setdefault(name, annotation)
                case ast.Call():
                    calls.append(node)
        calls.sort(key=lambda call: (call.lineno, call.col_offset))
        self.calls += calls

    def _set(self, target: ast.expr, value: ast.expr) -> None:
        match target, value:
            case (ast.Tuple(elts=names), ast.Tuple(elts=items)) if len(names) == len(
                items
            ):
                for each, item in zip(names, items, strict=True):
                    self._set(each, item)
                return
        name = variable(target)
        if name is None:
            return
        if name in self.values and not name.startswith("self."):
            self.values[name] = ast.Constant(None)
        self.values.setdefault(name, value)
