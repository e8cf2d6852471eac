"""Pipeline of the IDL front end: reads files into a model and diagnostics."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, Related, in_order
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.frontends.idl.names.structural_equality import structurally_equal
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.rules import lexical, names, syntax
from rtgen.compiler.frontends.idl.text.macros import ExpansionError, Macro
from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.source import Interfaces, Library, Source
from rtgen.compiler.frontends.idl.text.unit import Repeated
from rtgen.compiler.frontends.idl.translation import Translation, Translator
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.library import VirtualFile, absolute_path
from rtgen.compiler.frontends.kit.main_files import open_main
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model import (
    Declaration,
    Interface,
    Model,
    ScopedName,
    SourceFile,
    Valuetype,
)

_FRAMES = 12 * MAX_NESTING
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
    memo: Memo | None = None,
    encoding: str = "auto",
    interfaces: Interfaces | None = None,
) -> FrontendResult:
    """Read definition files, each as a translation unit, into one model.

    `root` is the project's folder, to which keys of files are relative; `include` are the folders
    of `#include`, in order; `define` are macros. With `ignore_case_clashes`, names that only differ
    in case are different names. `virtual` are files that can be included by name if no such file
    exists; those that are `given` are read before `paths`. `observe` is called with the resolved
    names of each translation unit; units whose files have not changed are taken from `memo`.
    `encoding`, of `decoded_text.NAMES`, is that of files that do not tell theirs. `interfaces`
    returns the IDL of an included file that ROS 2 has generated. All errors in the input are among
    the diagnostics, sorted; no exception is raised for them. Declarations with errors, and their
    dependents, are not in the model.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        run = _Run(
            *(paths, root, include, define or {}, ignore_case_clashes),
            *(virtual or {}, observe, memo, encoding, interfaces),
        )
        return run.result()
    finally:
        sys.setrecursionlimit(limit)


class _Run:
    def __init__(
        self,
        paths: Sequence[Path],
        root: Path,
        include: Sequence[Path],
        define: Mapping[str, str],
        ignore_case_clashes: bool,
        virtual: Mapping[str, VirtualFile | Path],
        observe: Callable[[Tables], None] | None,
        memo: Memo | None,
        encoding: str,
        interfaces: Interfaces | None,
    ) -> None:
        names = {absolute_path(path): path.as_posix() for path in reversed(paths)}
        self._library = Library(root, include, names, virtual, encoding, interfaces)
        self._given = [
            name
            for name, file in virtual.items()
            if isinstance(file, VirtualFile) and file.given
        ]
        self._paths = [Path(path) for path in dict.fromkeys(map(absolute_path, paths))]
        self._define = define
        self._observe = observe
        self._memo = memo
        own = ((name, f) for name, f in virtual.items() if isinstance(f, Path))
        self._key = (
            *("IDL", str(Path.cwd()), str(root), *map(str, include)),
            *(tuple(define.items()), ignore_case_clashes, encoding),
            *(tuple(names.items()), tuple(own)),
        )
        self._findings = Findings(syntax.TOO_MANY_FINDINGS)
        self._translator = Translator(
            self._library, ignore_case_clashes=ignore_case_clashes
        )
        self._declarations: dict[ScopedName, Declaration] = {}
        self._undefined: dict[Diagnostic, ScopedName] = {}
        self._defined: set[ScopedName] = set()
        self._files: dict[str, SourceFile] = {}
        self._main: set[str] = set()
        self._shown = names
        self._sources: dict[str, str] = {}
        self._dependencies: dict[Path, Dependency] = {}

    def _report(self, diagnostic: Diagnostic) -> None:
        if diagnostic.code == syntax.OTHER_LANGUAGE.code:
            self._findings.forget(diagnostic.span.file if diagnostic.span else None)
        self._findings.report(diagnostic)

    def result(self) -> FrontendResult:
        try:
            macros = predefined(self._define)
        except ExpansionError as error:
            self._report(lexical.BAD_MACRO_NAME.at(None, error.message))
            macros = predefined({})
        mains = [*map(self._of_name, self._given), *map(self._of_path, self._paths)]
        # Two links to one file are one.
        translations = list(
            {id(each): each for each in mains if each is not None}.values()
        )
        self._main = {
            (each.source if isinstance(each, Translation) else each).name
            for each in translations
        }
        for each in translations:
            if isinstance(each, Translation):
                self._merge(each)
            else:
                self._merge(self._translated(each, macros))
        for finding, name in self._undefined.items():
            if name not in self._defined:
                self._report(finding)
        for dependency in self._library.dependencies:
            self._dependencies.setdefault(dependency.path, dependency)
        for source in self._library.sources:
            self._sources[source.name] = source.text
        return FrontendResult(
            model=Model(
                tuple(self._files.values()), tuple(self._declarations.values())
            ),
            diagnostics=tuple(in_order(self._findings.diagnostics)),
            sources=self._sources,
            dependencies=tuple(self._dependencies.values()),
        )

    def _of_name(self, name: str) -> Source | Translation | None:
        """Return a main file that is on no disk, or its unit if that is known."""
        return self._cached(name) or self._library.virtual(name)

    def _of_path(self, path: Path) -> Source | Translation | None:
        return self._cached(str(path)) or open_main(
            self._library,
            path,
            self._shown[str(path)],
            self._report,
            missing=lexical.MISSING_FILE,
            unreadable=lexical.UNREADABLE,
            beside="*.idl",
        )

    def _cached(self, name: str) -> Translation | None:
        """Return the unit of a main file from an earlier run, if it is still valid."""
        if self._memo is None:
            return None
        translation: Translation | None = self._memo.find((*self._key, name))
        if translation is None or not self._translator.is_printed(translation.printed):
            return None
        return translation

    def _translated(self, source: Source, macros: Mapping[str, Macro]) -> Translation:
        virtual = source.name in self._given
        translation = self._translator.translate(source, macros, virtual=virtual)
        if self._memo is not None and not translation.guessed:
            name = source.name if virtual else absolute_path(source.path)
            self._memo.keep((*self._key, name), translation)
        return translation

    def _merge(self, unit: Translation) -> None:
        for found in unit.findings:
            self._report(found)
        tables = unit.tables
        if self._observe is not None:
            self._observe(tables)
        self._undefined |= {found: name for name, found in tables.undefined.items()}
        self._defined.update(e.path for e in tables.declared if e.node is not None)
        self._note_files(tables)
        self._sources |= {source.name: source.text for source in unit.sources}
        self._dependencies |= {each.path: each for each in unit.dependencies}
        for name, declaration in unit.declarations.items():
            self._add(name, declaration)

    def _add(self, name: ScopedName, declaration: Declaration) -> None:
        first = self._declarations.setdefault(name, declaration)
        if (
            first is declaration
            or first == declaration
            or _is_forward(declaration)
            or structurally_equal(first, declaration)
        ):
            return
        if _is_forward(first) and first.repository_id == declaration.repository_id:
            del self._declarations[name]
            self._declarations[name] = declaration
        else:
            self._report(
                names.TWO_DEFINITIONS.at(
                    declaration.span,
                    f"{declaration.scoped} is declared differently in another file",
                    related=[Related(first.span, "the other declaration")],
                    hint="rename one, or include one file from the other",
                )
            )

    def _note_files(self, tables: Tables) -> None:
        for unit in tables.units:
            if isinstance(unit, Repeated):
                for name, source in unit.sources.items():
                    if name not in self._files:
                        self._note(source, {}, None)
                continue
            source = unit.source
            self._note(source, unit.includes, None)
            for nested in unit.nested:
                self._note(nested, {}, source.name)

    def _note(
        self, source: Source, includes: dict[str, None], owner: str | None
    ) -> None:
        file = self._files.get(source.name)
        names_ = tuple(dict.fromkeys(file.includes) | includes if file else includes)
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
