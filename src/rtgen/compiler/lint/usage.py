"""Lint checks of unused includes, typedefs and types."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context
from rtgen.compiler.model import (
    Bitmask,
    Bitset,
    Component,
    Enum,
    ExceptionDecl,
    Interface,
    SourceFile,
    Struct,
    Typedef,
    Union,
)

_INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*[\"<]([^\">\n]+)[\">]", re.MULTILINE)
_TYPES = (Struct, Union, Enum, Bitmask, Bitset, ExceptionDecl, Interface)
_DEFINE = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)


def includes(context: Context) -> Iterator[Diagnostic]:
    """Report included files of which the including file uses no name.

    A file without declarations of its own is a collection of others, and is not checked. A file
    included inside a scope is part of its includer.
    """
    declaring = {declaration.file for declaration in context.model.declarations}
    provided = _provided(context)
    for file in context.model.files:
        if not file.main or file.name not in declaring:
            continue
        parts = [i for i in file.includes if context.files[i].belongs_to is not None]
        words = {w for f in (file.name, *parts) for w in context.words.get(f, ())}
        for included in file.includes:
            if included not in parts and words.isdisjoint(provided.get(included, ())):
                span = _include_of(context, file, included)
                if span is not None:
                    yield rules.UNUSED_INCLUDE.at(
                        span,
                        f"nothing of {PurePosixPath(included).name} is used here",
                        hint="remove the #include",
                    )


def _provided(context: Context) -> Mapping[str, set[str]]:
    """Return the names and macros that each file provides, including those of its includes."""
    names = {
        file.name: {*_DEFINE.findall(context.sources.get(file.name, ""))}
        for file in context.model.files
    }
    for declaration in context.model.declarations:
        own = names.get(declaration.file)
        if own is None:  # no file of the project has it
            continue
        own.add(declaration.name[-1])
        if isinstance(declaration, Enum | Bitmask):
            own.update(member.name for member in declaration.members)
    # Files follow their includes: only those that include each other need further rounds.
    grows = True
    while grows:
        grows = False
        for file in context.model.files:
            provided = names[file.name]
            before = len(provided)
            provided.update(*filter(None, map(names.get, file.includes)))
            grows |= len(provided) > before
    return names


def _include_of(context: Context, file: SourceFile, included: str) -> Span | None:
    """Return the place of the `#include`."""
    text = context.sources.get(file.name, "")
    name = PurePosixPath(included).name
    for match in _INCLUDE.finditer(text):
        if PurePosixPath(match[1]).name == name:
            line = text.count("\n", 0, match.start()) + 1
            begin = text.rfind("\n", 0, match.start(1)) + 1
            column = match.start(1) - begin + 1
            return Span(file.name, line, column, line, column + len(match[1]))
    return None


def types(context: Context) -> Iterator[Diagnostic]:
    """Report types of files with components whose name is never used.

    Types in files without components are there for other files.
    """
    own = {d.file for d in context.declarations if isinstance(d, Component)}
    count = context.count
    for declaration in context.declarations:
        is_type = isinstance(declaration, _TYPES) and declaration.file in own
        if not is_type or count[declaration.name[-1]] != 1:
            continue
        members = declaration.members if isinstance(declaration, Enum) else ()
        if all(count[member.name] == 1 for member in members):
            yield rules.UNUSED_TYPE.at(
                declaration.span,
                f"{declaration.scoped} is used nowhere",
                hint="remove it, unless it is meant for others",
            )


def typedefs(context: Context) -> Iterator[Diagnostic]:
    """Report typedefs whose name is never used."""
    count = context.count
    for declaration in context.declarations:
        if isinstance(declaration, Typedef) and count[declaration.name[-1]] == 1:
            yield rules.UNUSED_TYPEDEF.at(
                declaration.span,
                f"{declaration.scoped} is used nowhere",
                hint="remove it, unless it is meant for others",
            )
