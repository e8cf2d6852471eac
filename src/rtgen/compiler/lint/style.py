"""Lint checks of style: names, comments, anonymous types, prefixes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context, fields
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Component,
    Const,
    Declaration,
    Enum,
    ExceptionDecl,
    Interface,
    MapType,
    SequenceType,
    Struct,
    Typedef,
    Union,
    Valuetype,
)
from rtgen.facts.ros import INTERFACE_SUFFIXES

_STYLES = {
    "CamelCase": re.compile(r"[A-Z][a-z0-9]*(?:[A-Z0-9][a-z0-9]*)*"),
    "camelCase": re.compile(r"[a-z][a-z0-9]*(?:[A-Z0-9][a-z0-9]*)+"),
    "lower_case": re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)*"),
    "UPPER_CASE": re.compile(r"[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)*"),
    "Mixed_Case": re.compile(r"[A-Z][a-zA-Z0-9]*(?:_[a-zA-Z0-9]+)+"),
}
_MIN_NAMES = 4
_MAJORITY = 0.75
_TYPES = (Struct, Union, Enum, Bitset, Bitmask, Interface, Valuetype, ExceptionDecl)
_DOCUMENTED = (*_TYPES, Component)

Named = list[tuple[str, Span]]


def anonymous_types(context: Context) -> Iterator[Diagnostic]:
    """Report sequences, arrays and maps without a typedef; ROS 2's interface files have none."""
    for declaration in context.declarations:
        if declaration.file.lower().endswith(INTERFACE_SUFFIXES):
            continue
        for field in fields(declaration):
            if isinstance(field.type, SequenceType | ArrayType | MapType):
                yield rules.ANONYMOUS_TYPE.at(
                    field.span,
                    f"the type of {field.name} has no name",
                    hint="give it one by a typedef, so that others can use it too",
                )


def naming(context: Context) -> Iterator[Diagnostic]:
    """Report names whose style differs from most names of their kind in the file."""
    for (_, kind), names in _kinds(context).items():
        clear = Counter(style for name, _ in names if (style := _style(name)))
        if not clear or sum(clear.values()) < _MIN_NAMES:
            continue
        style, number = clear.most_common(1)[0]
        if number < _MAJORITY * sum(clear.values()):
            continue
        for name, span in names:
            if _style(name) is not None and not _STYLES[style].fullmatch(name):
                yield rules.NAMING.at(
                    span,
                    f"{name} is not in {style}, as most {kind} are",
                    hint="names of one kind are easier to guess in one style",
                )


def _style(name: str) -> str | None:
    """Return the style of a name; None if a single word fits several."""
    if name.islower() and "_" not in name:
        return None
    fitting = [style for style, form in _STYLES.items() if form.fullmatch(name)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting == ["CamelCase", "UPPER_CASE"] and len(name) > 1:
        return "UPPER_CASE"
    return None


def _kinds(context: Context) -> dict[tuple[str, str], Named]:
    """Return the names of each file, by kind."""
    kinds: dict[tuple[str, str], Named] = {}
    for declaration in context.declarations:
        for kind, name, span in _named(declaration):
            kinds.setdefault((declaration.file, kind), []).append((name, span))
    return kinds


def _named(declaration: Declaration) -> Iterator[tuple[str, str, Span]]:
    """Yield kind, name and place of a declaration and of its members."""
    name, span = declaration.name[-1], declaration.span
    if isinstance(declaration, Const):
        yield "constants", name, span
    elif isinstance(declaration, (*_TYPES, Typedef)):
        yield "types", name, span
    for field in fields(declaration):
        yield "members", field.name, field.span
    if isinstance(declaration, Enum):
        for member in declaration.members:
            yield "enumerators", member.name, member.span
    if isinstance(declaration, Interface):
        for operation in declaration.operations:
            yield "operations", operation.name, operation.span
        for attribute in declaration.attributes:
            yield "attributes", attribute.name, attribute.span


def documentation(context: Context) -> Iterator[Diagnostic]:
    """Report types, interfaces, operations and components without a comment."""
    for declaration in context.declarations:
        if isinstance(declaration, _DOCUMENTED) and not declaration.doc:
            yield _undocumented(declaration.span, declaration.scoped)
        if isinstance(declaration, Interface):
            for operation in declaration.operations:
                if not operation.doc:
                    name = f"{declaration.scoped}::{operation.name}"
                    yield _undocumented(operation.span, name)


def _undocumented(span: Span, name: str) -> Diagnostic:
    return rules.UNDOCUMENTED.at(
        span, f"{name} has no comment", hint="write /** ... */ before it"
    )


def prefixes(context: Context) -> Iterator[Diagnostic]:
    """Report interfaces whose repository id has no prefix."""
    for declaration in context.declarations:
        if isinstance(declaration, Interface) and _plain_id(declaration):
            yield rules.NO_PREFIX.at(
                declaration.span,
                f"the repository id of {declaration.scoped} has no prefix",
                hint='write #pragma prefix "your.domain" at the head of the file',
            )


def _plain_id(declaration: Declaration) -> bool:
    path = "/".join(declaration.name)
    return declaration.repository_id.startswith(f"IDL:{path}:")
