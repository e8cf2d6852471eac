"""Finds the component in a module: its module spec and its class."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from rtgen.openrtm.python_modules.values import (
    Class,
    Frame,
    Module,
    Named,
    Unknown,
    Value,
    dotted,
)
from rtgen.openrtm.python_modules.walker import Walker

_BASES = ("DataFlowComponentBase", "FiniteStateMachineComponentBase")
_KEY = "implementation_id"
_PACKAGES = ("OpenRTM_aist", "omniORB", "RTC")


Item = tuple[ast.expr, Value]
"""An item of a list: its place and value."""


def module_spec(module: Module, walker: Walker) -> tuple[ast.expr, list[Item]] | None:
    """Return the first list of texts with an implementation id: its place and items."""
    for node in ast.walk(module.tree):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        items = list(_items(node.value, Frame(module), walker))
        if any(value == _KEY for _, value in items[::2] if isinstance(value, str)):
            return node.value, items
    return None


def _items(node: ast.expr, frame: Frame, walker: Walker) -> Iterator[Item]:
    """Yield the items of a list, including those appended to it."""
    parts = [node]
    while isinstance(parts[0], ast.BinOp) and isinstance(parts[0].op, ast.Add):
        parts[:1] = [parts[0].left, parts[0].right]
    for part in parts:
        if isinstance(part, ast.List | ast.Tuple):
            for item in part.elts:
                if isinstance(item, ast.Starred):
                    yield from _items(item.value, frame, walker)
                else:
                    yield item, walker.expressions.value(item, frame)
        elif isinstance(part, ast.Name):
            values = walker.expressions.value(part, frame)
            if isinstance(values, list | tuple):
                yield from ((part, value) for value in values)


def component_classes(module: Module, walker: Walker) -> list[Class]:
    """Return the class of the component, then its bases in the repository.

    It is the class that a factory is registered for, else the first one derived from OpenRTM's.
    """
    frame = Frame(module)
    classes = [
        Class(node, module)
        for node in ast.walk(module.tree)
        if isinstance(node, ast.ClassDef)
    ]
    own = {each.node.name: each for each in classes}
    lineages = [
        lineage for each in classes if (lineage := _line(each, own, walker, []))
    ]
    for call in ast.walk(module.tree):
        if not isinstance(call, ast.Call) or len(call.args) < 2:
            continue
        if dotted(call.func)[-1:] == ("registerFactory",):
            named = walker.expressions.value(call.args[1], frame)
            if isinstance(named, Class):
                chosen = [line for line in lineages if line[0].node is named.node]
                chosen = chosen or [_line(named, own, walker, [])]
                if chosen[0]:
                    return chosen[0]
    return lineages[0] if lineages else []


def _line(
    class_: Class, own: dict[str, Class], walker: Walker, above: list[ast.ClassDef]
) -> list[Class]:
    """Return the class and its bases, if one of them derives from OpenRTM's."""
    if class_.node in above or len(above) > 50:
        return []
    rest: list[Class] = []
    is_component = False
    for base in class_.node.bases:
        value = walker.expressions.value(base, Frame(class_.module))
        if isinstance(value, Named | Unknown) and dotted(base)[-1:] == dotted(base):
            value = own.get(dotted(base)[-1] if dotted(base) else "", value)
        if isinstance(value, Named) and value.path[-1] in _BASES:
            is_component = True
        elif isinstance(value, Class):
            line = _line(value, own, walker, [*above, class_.node])
            is_component = is_component or bool(line)
            rest += [
                each for each in line if all(each.node is not r.node for r in rest)
            ]
    return [class_, *rest] if is_component else []


def unknown_bases(
    module: Module, walker: Walker
) -> Iterator[tuple[ast.expr, tuple[str, ...], list[tuple[str, ...]]]]:
    """Yield the bases of the module's classes that are defined elsewhere.

    Each with its name, and the modules that may have it: several for a name of `import *`.
    """
    own = {n.name for n in ast.walk(module.tree) if isinstance(n, ast.ClassDef)}
    for node in ast.walk(module.tree):
        for base in node.bases if isinstance(node, ast.ClassDef) else ():
            value = walker.expressions.value(base, Frame(module))
            names = dotted(base)
            if isinstance(value, Named) and value.imported:
                if value.path[0] not in _PACKAGES:
                    yield base, value.path, [value.path[:-1]]
            elif len(names) == 1 and names[0] not in own:
                opened = [tuple(each.split(".")) for each in module.open_modules]
                others = [each for each in opened if each[0] not in _PACKAGES]
                if others:
                    yield base, names, others
