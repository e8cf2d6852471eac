"""Reads a translation unit of IDL, independently of other units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.idl.leading_units import LeadingUnits
from rtgen.compiler.frontends.idl.meaning import checks
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.resolver import Resolver
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.syntax.parser import parse
from rtgen.compiler.frontends.idl.syntax.tree import Item
from rtgen.compiler.frontends.idl.text.macros import Macro
from rtgen.compiler.frontends.idl.text.preprocessor import Preprocessor
from rtgen.compiler.frontends.idl.text.source import Library, Source
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Declaration, ScopedName

if TYPE_CHECKING:
    from rtgen.compiler.frontends.idl.names.neighbours import Neighbours


class Translation(msgspec.Struct, frozen=True, eq=False):
    """A translation unit with its diagnostics and dependencies.

    `findings` are in the order of reporting. `sources` are its files, `dependencies` those and the
    paths that were searched for; `printed` has the hashes of files that are on no disk, by name. It
    depends on nothing else, unless it is `guessed`: a hint refers to other files.
    """

    source: Source
    tables: Tables
    declarations: Mapping[ScopedName, Declaration]
    findings: tuple[Diagnostic, ...]
    sources: tuple[Source, ...]
    dependencies: tuple[Dependency, ...]
    printed: Mapping[str, str]
    guessed: bool


class Translator:
    """Reads translation units; files included by several units are read and parsed once."""

    def __init__(self, library: Library, *, ignore_case_clashes: bool) -> None:
        self._library = library
        self._ignore_case_clashes = ignore_case_clashes
        self._preprocessor = Preprocessor(library)
        self._trees: dict[Unit, tuple[Item, ...]] = {}
        self._leading = LeadingUnits()
        self._neighbours: Neighbours | None = None

    def translate(
        self, source: Source, macros: Mapping[str, Macro], *, virtual: bool
    ) -> Translation:
        """Read the unit of a main file; a `virtual` one is on no disk."""
        stages.file(source.name)
        with stages.stage("preprocess"):
            unit = self._preprocessor.translation_unit(source, macros)
        own = Findings()
        guesses: list[str] = []

        def declares(names: tuple[str, ...], used_in: Unit) -> str | None:
            guesses.extend(names)
            return self._declares(names, used_in)

        with stages.stage("parse and resolve"):
            tables = Resolver(
                self._items, own.report, declares, self._ignore_case_clashes
            ).run(unit)
        units = list(unit.all_included)
        types = Types(tables, own.report)
        declarations = self._leading.declarations(types, own.report)
        parts = [*(each.findings for each in units), own]
        if not any(each.errors for each in parts):
            checks.left_out(tables, types, declarations, own.report)
        printed = dict.fromkeys(name for each in units for name in each.printed)
        searched = dict.fromkeys(path for each in units for path in each.searched)
        if virtual:
            printed[source.name] = None
        else:
            searched[str(source.path)] = None
        return Translation(
            source=source,
            tables=tables,
            declarations=declarations,
            findings=tuple(finding for each in parts for finding in each.diagnostics),
            sources=tuple(
                dict.fromkeys(s for each in units for s in (each.source, *each.nested))
            ),
            dependencies=tuple(map(self._library.dependency, searched)),
            printed={name: self._hash(name) for name in printed},
            guessed=bool(guesses) or any(each.guessed for each in units),
        )

    def is_printed(self, printed: Mapping[str, str]) -> bool:
        """Return whether the files that are on no disk have these hashes."""
        return all(self._hash(name) == digest for name, digest in printed.items())

    def _hash(self, name: str) -> str:
        source = self._library.virtual(name)
        return "" if source is None else source.sha256

    def _declares(self, names: tuple[str, ...], unit: Unit) -> str | None:
        """Return the nearby file that declares unknown names."""
        if self._neighbours is None:
            from rtgen.compiler.frontends.idl.names.neighbours import Neighbours

            self._neighbours = Neighbours(self._library)
        return self._neighbours.declares(names, unit)

    def _items(self, unit: Unit) -> tuple[Item, ...]:
        if unit not in self._trees:
            self._trees[unit] = parse(unit, unit.findings.report)
        return self._trees[unit]
