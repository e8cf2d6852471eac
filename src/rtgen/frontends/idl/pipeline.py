"""The IDL front end: reads files into a model and diagnostics."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen import stages
from rtgen.diagnostics import Diagnostic, Related, in_order
from rtgen.frontends import FrontendResult
from rtgen.frontends.idl.lowering.lower import Lowering
from rtgen.frontends.idl.meaning import checks
from rtgen.frontends.idl.meaning.checks import levels
from rtgen.frontends.idl.meaning.typetable import Types
from rtgen.frontends.idl.names import tables
from rtgen.frontends.idl.names.resolver import Resolver
from rtgen.frontends.idl.names.structural_equality import structurally_equal
from rtgen.frontends.idl.names.tables import Tables
from rtgen.frontends.idl.rules import lexical, names, syntax
from rtgen.frontends.idl.syntax.parser import parse
from rtgen.frontends.idl.syntax.tree import Item
from rtgen.frontends.idl.text import preprocessor
from rtgen.frontends.idl.text.macros import ExpansionError, Macro
from rtgen.frontends.idl.text.predefined import predefined
from rtgen.frontends.idl.text.preprocessor import Preprocessor
from rtgen.frontends.idl.text.source import Library, Source
from rtgen.frontends.idl.text.unit import Inclusion, Unit
from rtgen.frontends.kit.findings import Findings
from rtgen.frontends.kit.library import VirtualFile, absolute_path
from rtgen.frontends.kit.main_files import open_main
from rtgen.model import (
    Declaration,
    Interface,
    Model,
    ScopedName,
    SourceFile,
    Valuetype,
)

if TYPE_CHECKING:
    from rtgen.frontends.idl.names.neighbours import Neighbours


_FRAMES = 12 * max(tables.MAX_DEPTH, preprocessor.MAX_DEPTH)
"""Recursion limit sufficient for the deepest nesting allowed."""


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path] = (),
    define: Mapping[str, str] | None = None,
    ignore_case_clashes: bool = False,
    virtual: Mapping[str, VirtualFile | Path] | None = None,
    observe: Callable[[Tables], None] | None = None,
) -> FrontendResult:
    """Read definition files, each as a translation unit, into one model.

    `root` is the project's folder, which keys of files are relative to; `include` are the folders
    of `#include`, in order; `define` are macros. With `ignore_case_clashes`, names that only
    differ in case are different names. `virtual` are files by the names that include them if no
    such file exists; those that are `given` are read before `paths`. `observe` is called with the
    resolved names of each translation unit. All problems of the input
    are in the diagnostics, sorted; no exception is raised for them. Declarations with errors, and
    their dependents, are not in the model.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        run = _Run(paths, root, include, ignore_case_clashes, virtual or {}, observe)
        return run.result(define or {})
    finally:
        sys.setrecursionlimit(limit)


class _Run:
    def __init__(
        self,
        paths: Sequence[Path],
        root: Path,
        include: Sequence[Path],
        ignore_case_clashes: bool,
        virtual: Mapping[str, VirtualFile | Path],
        observe: Callable[[Tables], None] | None,
    ) -> None:
        shown = {absolute_path(path): path.as_posix() for path in reversed(paths)}
        self._library = Library(root, include, shown, virtual)
        self._given = [
            name
            for name, file in virtual.items()
            if isinstance(file, VirtualFile) and file.given
        ]
        self._paths = [Path(path) for path in dict.fromkeys(map(absolute_path, paths))]
        self._ignore_case_clashes = ignore_case_clashes
        self._observe = observe
        self._found = Findings(syntax.TOO_MANY_FINDINGS)
        self._preprocessor = Preprocessor(self._library, self._report)
        self._trees: dict[Unit, tuple[Item, ...]] = {}
        self._declarations: dict[ScopedName, Declaration] = {}
        self._undefined: dict[Diagnostic, ScopedName] = {}
        self._defined: set[ScopedName] = set()
        self._files: dict[str, SourceFile] = {}
        self._main: set[str] = set()
        self._shown = shown
        self._neighbours: Neighbours | None = None

    def _report(self, diagnostic: Diagnostic) -> None:
        if diagnostic.code == syntax.OTHER_LANGUAGE.code:
            self._found.forget(diagnostic.span.file if diagnostic.span else None)
        self._found.report(diagnostic)

    def result(self, define: Mapping[str, str]) -> FrontendResult:
        try:
            macros = predefined(define)
        except ExpansionError as error:
            self._report(lexical.BAD_MACRO_NAME.at(None, error.message))
            macros = predefined({})
        made = map(self._library.virtual, self._given)
        read = map(self._open, self._paths)
        sources = [source for source in (*made, *read) if source is not None]
        self._main = {source.name for source in sources}
        for source in sources:
            self._translate(source, macros)
        for finding, name in self._undefined.items():
            if name not in self._defined:
                self._report(finding)
        return FrontendResult(
            model=Model(
                tuple(self._files.values()), tuple(self._declarations.values())
            ),
            diagnostics=tuple(in_order(self._found.diagnostics)),
            sources={source.name: source.text for source in self._library.sources},
            dependencies=self._library.dependencies,
        )

    def _open(self, path: Path) -> Source | None:
        return open_main(
            self._library,
            path,
            self._shown[str(path)],
            self._report,
            missing=lexical.MISSING_FILE,
            unreadable=lexical.UNREADABLE,
            beside="*.idl",
        )

    def _declares(self, name: str, unit: Unit) -> str | None:
        """The file near a unit that declares an unknown name."""
        if self._neighbours is None:
            from rtgen.frontends.idl.names.neighbours import Neighbours

            self._neighbours = Neighbours(self._library)
        return self._neighbours.declares(name, unit)

    def _items(self, unit: Unit) -> tuple[Item, ...]:
        if unit not in self._trees:
            self._trees[unit] = parse(unit, self._report)
        return self._trees[unit]

    def _translate(self, source: Source, macros: Mapping[str, Macro]) -> None:
        stages.file(source.name)
        with stages.stage("preprocess"):
            unit = self._preprocessor.translation_unit(source, macros)
        with stages.stage("parse and resolve"):
            tables = Resolver(
                self._items, self._report, self._declares, self._ignore_case_clashes
            ).run(unit)
        if self._observe is not None:
            self._observe(tables)
        types = Types(tables, self._report)
        made: dict[ScopedName, Declaration] = {}
        with stages.stage("make the model"):
            lowering = Lowering(types, self._report)
            for entity in tables.declared:
                declaration = lowering.declaration(entity)
                if declaration is not None:
                    made[declaration.name] = declaration
        with stages.stage("check"):
            made = levels.checked(made, self._report)
            checks.run(tables, types, made, self._report)
            if not self._found.errors:
                checks.left_out(tables, types, made, self._report)
        self._undefined |= {found: name for name, found in tables.undefined.items()}
        self._defined.update(e.path for e in tables.declared if e.node is not None)
        self._note_files(tables)
        for name, declaration in made.items():
            self._add(name, declaration)

    def _add(self, name: ScopedName, declaration: Declaration) -> None:
        known = self._declarations.setdefault(name, declaration)
        if (
            known == declaration
            or _is_forward(declaration)
            or structurally_equal(known, declaration)
        ):
            return
        if _is_forward(known) and known.repository_id == declaration.repository_id:
            del self._declarations[name]
            self._declarations[name] = declaration
        else:
            self._report(
                names.TWO_DEFINITIONS.at(
                    declaration.span,
                    f"{declaration.scoped} is declared differently in another file",
                    related=[Related(known.span, "the other declaration")],
                    hint="rename one, or include one file from the other",
                )
            )

    def _note_files(self, tables: Tables) -> None:
        for unit in tables.units:
            source = unit.source
            included = [
                e.unit.source.name for e in unit.events if isinstance(e, Inclusion)
            ]
            self._note(source, (*included, *(s.name for s in unit.nested)), None)
            for nested in unit.nested:
                self._note(nested, (), source.name)

    def _note(self, source: Source, includes: Sequence[str], owner: str | None) -> None:
        known = self._files.get(source.name)
        names_ = tuple(dict.fromkeys((*(known.includes if known else ()), *includes)))
        self._files[source.name] = SourceFile(
            name=source.name,
            key=source.key,
            sha256=source.sha256,
            main=source.name in self._main,
            includes=names_,
            belongs_to=None if source.name in self._main else owner,
        )


def _is_forward(declaration: Declaration) -> bool:
    return isinstance(declaration, Interface | Valuetype) and declaration.forward
