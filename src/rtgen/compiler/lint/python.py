"""Lint checks of names that are changed in Python, or shadow others there, and of file names."""

from __future__ import annotations

import builtins
import re
from collections.abc import Iterator
from keyword import iskeyword

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context
from rtgen.compiler.model import (
    Component,
    Enum,
    ExceptionDecl,
    Interface,
    ScopedName,
    Struct,
    Union,
)
from rtgen.compiler.typemap.python.idl_names import PythonNames, is_emitted
from rtgen.compiler.typemap.python.names import identifier, module_name

_BUILTINS = frozenset(dir(builtins))
_DEVICES = re.compile(r"aux|con|nul|prn|(?:com|lpt)[0-9]")
"""Devices of Windows, which has no files with these names, whatever their suffix."""


def names(context: Context) -> Iterator[Diagnostic]:
    """Report keywords, builtins, and names used by generated classes."""
    mapping = PythonNames(context.model, "robots")
    for declaration in context.declarations:
        if isinstance(declaration, Component) or not is_emitted(declaration):
            continue
        name = declaration.name[-1]
        yield from _renamed(declaration.span, name, mapping.attribute(declaration.name))
        if name in _BUILTINS:
            yield rules.PYTHON_NAME.at(
                declaration.span,
                f"{declaration.scoped} hides Python's {name} where it is imported",
                hint="another name keeps both usable",
            )
        entries: dict[str, str] = {}
        spans: dict[str, Span] = {}
        match declaration:
            case Struct(members=members) | ExceptionDecl(members=members):
                entries = mapping.members(declaration)
                spans = {m.name: m.span for m in members}
            case Union(cases=cases):
                entries = mapping.members(declaration)
                spans = {c.name: c.span for c in cases}
            case Enum(members=enumerators):
                entries = mapping.enumerators(declaration)
                spans = {m.name: m.span for m in enumerators}
            case Interface(operations=operations, attributes=attributes):
                entries = mapping.operations(declaration)
                spans = {o.name: o.span for o in operations}
                spans |= {a.name: a.span for a in attributes}
        for key, python in entries.items():
            yield from _renamed(spans[key], key, python)


def files(context: Context) -> Iterator[Diagnostic]:
    """Report modules and components whose Python files Windows cannot store, once for each name."""
    reported = set()
    passed: set[ScopedName] = {()}
    for declaration in context.declarations:
        scope, name = declaration.name[:-1], declaration.name[-1]
        outer = len(scope)
        while scope[:outer] not in passed:
            passed.add(scope[:outer])
            outer -= 1
        modules = {part: identifier(part.lower()) for part in scope[outer:]}
        if isinstance(declaration, Component):
            modules[name] = module_name(name)
        for idl, module in modules.items():
            if _DEVICES.fullmatch(module) and idl not in reported:
                reported.add(idl)
                yield rules.DEVICE_NAME.at(
                    declaration.span,
                    f"{idl} is {module} in the paths of generated files, which Windows reserves",
                    hint="choose a name that every file system can store",
                )


def _renamed(span: Span, name: str, python: str) -> Iterator[Diagnostic]:
    if name != python:
        why = "a keyword of Python" if iskeyword(name) else "taken in the Python class"
        yield rules.PYTHON_NAME.at(
            span,
            f"{name} is {why}: it is written {python} there",
            hint="another name is the same in every language",
        )
