"""The stages of the IDL front end one by one, for texts without files."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.lowering.lower import Lowering
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.resolver import Resolver
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.syntax.parser import parse
from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.preprocessor import Preprocessor
from rtgen.compiler.frontends.idl.text.source import Library, Source
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import Declaration

Messages = list[str]


def source(text: str) -> Source:
    """Return the text as a file."""
    return Source("some.idl", "some.idl", Path("some.idl"), text.encode())


def preprocessed(text: str) -> tuple[Unit, Messages]:
    """Return the unit, and the messages of the preprocessor."""
    preprocessor = Preprocessor(Library(Path(), []))
    unit = preprocessor.translation_unit(source(text), predefined({}))
    return unit, [diagnostic.message for diagnostic in unit.findings.diagnostics]


def parsed(text: str) -> tuple[Unit, tuple[tree.Item, ...], Messages]:
    """Return the unit, its tree, and the syntax errors."""
    unit, messages = preprocessed(text)
    assert not messages
    found: list[Diagnostic] = []
    items = parse(unit, found.append)
    return unit, items, [diagnostic.message for diagnostic in found]


def resolved(text: str) -> tuple[Tables, Messages]:
    """Return the tables of a text without syntax errors, and the messages of name resolution."""
    unit, items, errors = parsed(text)
    assert not errors
    found: list[Diagnostic] = []
    resolver = Resolver(lambda _: items, found.append, lambda *_: None, False)
    tables = resolver.run(unit)
    return tables, [diagnostic.message for diagnostic in found]


def typed(text: str) -> tuple[Types, list[Diagnostic]]:
    """Return the types of a text with known names, and the list that receives findings."""
    tables, errors = resolved(text)
    assert not errors
    found: list[Diagnostic] = []
    return Types(tables, found.append), found


def entity(tables: Tables, name: str) -> Entity:
    """Return the declaration of a scoped name."""
    [found] = [e for e in tables.declared if e.scoped == name]
    return found


def lowered(text: str) -> tuple[dict[str, Declaration], Messages]:
    """Return the declarations of the model by name, unchecked, and the messages."""
    types, found = typed(text)
    lowering = Lowering(types, found.append)
    made = [lowering.declaration(e) for e in types.tables.declared]
    declarations = {d.scoped: d for d in made if d is not None}
    return declarations, [diagnostic.message for diagnostic in found]
