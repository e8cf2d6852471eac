"""Pipeline of the IDL front end: reads files into a model and diagnostics."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import filterfalse
from pathlib import Path
from typing import Any, Protocol

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, in_order
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.frontends.idl.names.structural_equality import structurally_equal
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.rules import lexical, names, syntax
from rtgen.compiler.frontends.idl.text.macros import ExpansionError, Macro
from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.source import Interfaces, Library, Source
from rtgen.compiler.frontends.idl.text.unit import Repeated
from rtgen.compiler.frontends.idl.translation import Translator
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


class Observer(Protocol):
    """Takes what it needs of the resolved names, which a memo then stores without the rest."""

    def names(self, tables: Tables) -> Any:
        """Return the names of a translation unit, as values that `add` takes in later runs, too."""

    def add(self, names: Any) -> None:
        """Add the names of a translation unit of this run."""


class _Part(msgspec.Struct, frozen=True, eq=False):
    """What a translation unit adds to the model, without its trees and tables.

    `name` is the displayed path, `files` are its files with what they include and whether they were
    passed over, `texts` their texts by displayed path; `names` are those of the observer. The other
    fields are as in `Translation` and `Tables`.
    """

    name: str
    files: tuple[tuple[SourceFile, bool], ...]
    texts: Mapping[str, str]
    names: Any
    undefined: Mapping[ScopedName, Diagnostic]
    defined: frozenset[ScopedName]
    declarations: Mapping[ScopedName, Declaration]
    findings: tuple[Diagnostic, ...]
    dependencies: tuple[Dependency, ...]
    printed: Mapping[str, str]


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path] = (),
    define: Mapping[str, str] | None = None,
    ignore_case_clashes: bool = False,
    virtual: Mapping[str, VirtualFile | Path] | None = None,
    observer: Observer | None = None,
    memo: Memo | None = None,
    encoding: str = "auto",
    interfaces: Interfaces | None = None,
) -> FrontendResult:
    """Read definition files, each as a translation unit, into one model.

    `root` is the project's folder, to which keys of files are relative; `include` are the folders
    of `#include`, in order; `define` are macros. With `ignore_case_clashes`, names that only differ
    in case are different names. `virtual` are files that can be included by name if no such file
    exists; those that are `given` are read before `paths`. `observer` is given the resolved
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
            *(virtual or {}, observer, memo, encoding, interfaces),
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
        observer: Observer | None,
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
        self._observer = observer
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
        units = list({id(each): each for each in mains if each is not None}.values())
        self._main = {each.name for each in units}
        # Units of earlier runs come first: they have the names of files in common with others.
        for each in units:
            if isinstance(each, _Part):
                self._observe(each)
        for each in units:
            if isinstance(each, _Part):
                self._merge(each)
            else:
                part = self._translated(each, macros)
                self._observe(part)
                self._merge(part)
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

    def _of_name(self, name: str) -> Source | _Part | None:
        """Return a main file that is on no disk, or its unit if that is known."""
        return self._cached(name) or self._library.virtual(name)

    def _of_path(self, path: Path) -> Source | _Part | None:
        return self._cached(str(path)) or open_main(
            self._library,
            path,
            self._shown[str(path)],
            self._report,
            missing=lexical.MISSING_FILE,
            unreadable=lexical.UNREADABLE,
            beside="*.idl",
        )

    def _cached(self, name: str) -> _Part | None:
        """Return the unit of a main file from an earlier run, if it is still valid."""
        if self._memo is None:
            return None
        part: _Part | None = self._memo.find((*self._key, name))
        if part is None or not self._translator.is_printed(part.printed):
            return None
        return part

    def _translated(self, source: Source, macros: Mapping[str, Macro]) -> _Part:
        virtual = source.name in self._given
        translation = self._translator.translate(source, macros, virtual=virtual)
        tables = translation.tables
        part = _Part(
            name=source.name,
            files=tuple(_files(tables)),
            texts={each.name: each.text for each in translation.sources},
            names=None if self._observer is None else self._observer.names(tables),
            undefined=tables.undefined,
            defined=frozenset(e.path for e in tables.declared if e.node is not None),
            declarations=translation.declarations,
            findings=translation.findings,
            dependencies=translation.dependencies,
            printed=translation.printed,
        )
        if self._memo is not None and not translation.guessed:
            name = source.name if virtual else absolute_path(source.path)
            self._memo.keep((*self._key, name), part)
        return part

    def _observe(self, part: _Part) -> None:
        if self._observer is not None:
            self._observer.add(part.names)

    def _merge(self, part: _Part) -> None:
        for finding in part.findings:
            self._report(finding)
        self._undefined |= {finding: name for name, finding in part.undefined.items()}
        self._defined |= part.defined
        for file, is_passed_over in part.files:
            if not is_passed_over or file.name not in self._files:
                self._note(file)
        self._sources |= part.texts
        self._dependencies |= {each.path: each for each in part.dependencies}
        for name, declaration in part.declarations.items():
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

    def _note(self, file: SourceFile) -> None:
        """Note a file of a unit, with what it includes there besides what is known."""
        before = self._files.get(file.name)
        includes = (*before.includes, *file.includes) if before else file.includes
        is_main = file.name in self._main
        self._files[file.name] = msgspec.structs.replace(
            file,
            main=is_main,
            includes=tuple(dict.fromkeys(includes)),
            belongs_to=None if is_main else file.belongs_to,
        )


def _files(tables: Tables) -> Iterator[tuple[SourceFile, bool]]:
    """Yield the files of a translation unit, and whether their guards have left nothing."""
    seen: set[str] = set()
    for unit in tables.units:
        if isinstance(unit, Repeated):
            for name in filterfalse(seen.__contains__, unit.sources):
                yield _file(unit.sources[name], {}, None), True
            seen.update(unit.sources)
            continue
        yield _file(unit.source, unit.includes, None), False
        for nested in unit.nested:
            yield _file(nested, {}, unit.source.name), False
        seen |= {unit.source.name, *(nested.name for nested in unit.nested)}


def _file(
    source: Source, includes: Mapping[str, None], owner: str | None
) -> SourceFile:
    return SourceFile(
        name=source.name,
        key=source.key,
        sha256=source.sha256,
        main=False,
        includes=tuple(includes),
        belongs_to=owner,
    )


def _is_forward(declaration: Declaration) -> bool:
    return isinstance(declaration, Interface | Valuetype) and declaration.forward
