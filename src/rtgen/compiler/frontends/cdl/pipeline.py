"""Pipeline of the CDL front end: from files to units of the model and diagnostics."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, in_order
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.frontends.cdl.c_headers.file import HeaderFile
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes import prelude as kernel
from rtgen.compiler.frontends.cdl.passes.analysis import Analysis
from rtgen.compiler.frontends.cdl.reader import Reader
from rtgen.compiler.frontends.cdl.rules import cells, celltypes, files
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.compiler.frontends.cdl.text.source import Source
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.library import Library, absolute_path
from rtgen.compiler.frontends.kit.main_files import open_main
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.kit import stages
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model import Model, SourceFile
from rtgen.compiler.model.tecs import TecsUnit
from rtgen.facts.encodings import Encoded

_FRAMES = 12 * MAX_NESTING
"""Recursion limit for the deepest permitted nesting."""

_ABSENCES = frozenset(
    rule.code
    for rule in (
        celltypes.NO_ENTRY,
        cells.UNDEFINED_CELL,
        cells.UNUSED_PROTOTYPE,
        cells.UNUSED_CELL,
        cells.NOT_JOINED,
        cells.ARRAY_HOLE,
        cells.NO_VALUE,
    )
)
"""Rules that report a missing statement."""


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path] = (),
    define: Mapping[str, str] | None = None,
    encoding: str = "auto",
    prelude: bool = True,
    observe: Callable[[Table, Sequence[Unit]], None] | None = None,
    memo: Memo | None = None,
) -> FrontendResult:
    """Read CDL files, each with its imports, into one unit of the model each.

    `root` is the project's folder, to which the keys of files are relative; `include` are the
    folders that are searched for imports; `define` gives macros of C headers; `encoding`, of
    `decoded_text.NAMES`, is that of files that do not tell theirs; with `prelude` the kernel's
    scalar types are known without an import. `observe` is called with the symbols and the files of
    each unit; units whose files have not changed are taken from `memo`. All errors of the input are
    in the diagnostics, sorted; nothing is raised for it. Declarations with an error are not in the
    model.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        run = _Run(paths, root, include, define or {}, encoding, prelude, observe, memo)
        return run.result()
    finally:
        sys.setrecursionlimit(limit)


def read_text(
    text: str, name: str = "text.cdl", *, prelude: bool = True
) -> tuple[TecsUnit, tuple[Diagnostic, ...]]:
    """Return the unit of a text that imports no files, and its diagnostics, sorted."""
    run = _Run((), Path(), (), {}, "auto", prelude)
    source = Source(name, name, Path(name), Encoded(text.encode()))
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        unit = run.read(source)
    finally:
        sys.setrecursionlimit(limit)
    return unit.model, tuple(in_order(unit.findings))


class _Read(msgspec.Struct, frozen=True, eq=False):
    """A main file with its imports, and everything that it depends on."""

    source: Source
    model: TecsUnit
    table: Table
    units: tuple[Unit, ...]
    sources: tuple[Source, ...]
    headers: tuple[HeaderFile, ...]
    findings: tuple[Diagnostic, ...]
    dependencies: tuple[Dependency, ...]


class _Run:
    def __init__(
        self,
        paths: Sequence[Path],
        root: Path,
        include: Sequence[Path],
        define: Mapping[str, str],
        encoding: str,
        with_prelude: bool,
        observe: Callable[[Table, Sequence[Unit]], None] | None = None,
        memo: Memo | None = None,
    ) -> None:
        def make(name: str, key: str, path: Path, data: bytes | None) -> Source:
            return Source(name, key, path, data, encoding)

        self._shown = {absolute_path(p): p.as_posix() for p in reversed(paths)}
        self._library = Library(make, root, include, self._shown)
        header = partial(HeaderFile, encoding=encoding)
        self._headers = Library(header, root, include)
        self._plugins = Library(header, root, include)
        self._paths = [Path(path) for path in dict.fromkeys(map(absolute_path, paths))]
        self._define = define
        self._with_prelude = with_prelude
        self._observe = observe
        self._memo = memo
        self._key = (
            *("CDL", str(Path.cwd()), str(root), *map(str, include)),
            *(
                tuple(define.items()),
                encoding,
                with_prelude,
                tuple(self._shown.items()),
            ),
        )
        self._findings = Findings(files.TOO_MANY)
        self._report = self._findings.report
        self._files: dict[str, SourceFile] = {}
        self._sources: dict[str, str] = {}
        self._dependencies: dict[Path, Dependency] = {}

    def result(self) -> FrontendResult:
        mains = [each for each in map(self._main, self._paths) if each is not None]
        self._check_stems([e.source if isinstance(e, _Read) else e for e in mains])
        read = [e if isinstance(e, _Read) else self._read_and_cache(e) for e in mains]
        for each in read:
            self._merge(each)
        for header in dict.fromkeys(h for each in read for h in each.headers):
            self._files[header.name] = SourceFile(
                name=header.name, key=header.key, sha256=header.sha256, main=False
            )
        for library in (self._library, self._headers, self._plugins):
            for dependency in library.dependencies:
                self._dependencies.setdefault(dependency.path, dependency)
        return FrontendResult(
            model=Model(
                tuple(self._files.values()), (), (), tuple(e.model for e in read)
            ),
            diagnostics=tuple(in_order(self._findings.diagnostics)),
            sources=self._sources,
            dependencies=tuple(self._dependencies.values()),
        )

    def _main(self, path: Path) -> Source | _Read | None:
        """Return a main file, or the result of an earlier run if that is still valid."""
        cached: _Read | None = None
        if self._memo is not None:
            cached = self._memo.find((*self._key, str(path)))
        return cached or self._open(path)

    def _read_and_cache(self, source: Source) -> _Read:
        read = self.read(source)
        if self._memo is not None:
            self._memo.keep((*self._key, absolute_path(source.path)), read)
        return read

    def _merge(self, read: _Read) -> None:
        for finding in read.findings:
            self._report(finding)
        if self._observe is not None:
            self._observe(read.table, read.units)
        self._sources |= {source.name: source.text for source in read.sources}
        self._sources |= {h.name: h.source for h in read.headers if h.problems}
        for unit in read.units:
            self._note(unit, main=unit.source is read.source)
        self._dependencies |= {each.path: each for each in read.dependencies}

    def _check_stems(self, sources: Sequence[Source]) -> None:
        """Report files of equal stem, which is the name of the folder of generated files."""
        by_stem: dict[str, Source] = {}
        for source in sources:
            stem = re.sub(r"\W", "_", source.path.stem).lower()
            first = by_stem.setdefault(stem, source)
            if first is not source:
                message = f"{first.name} has the same name but for its folder"
                span = source.span(0, 0)
                self._report(files.SAME_STEM.at(span, message, hint="rename one"))

    def _open(self, path: Path) -> Source | None:
        return open_main(
            self._library,
            path,
            self._shown[str(path)],
            self._report,
            missing=files.MISSING_FILE,
            unreadable=files.UNREADABLE,
            beside="*.cdl",
            apart=True,
        )

    def read(self, source: Source) -> _Read:
        """Read a main file with its imports, independently of other main files."""
        stages.file(source.name)
        findings = Findings()
        libraries = self._library, self._headers, self._plugins
        for library in libraries:
            library.trail.clear()
        names = frozenset(kernel.TYPES) if self._with_prelude else frozenset[str]()
        reader = Reader(
            self._library, self._headers, self._define, names, findings.report
        )
        with stages.stage("parse"):
            unit = reader.read(source)
        broken = any(each.skipped for each in reader.units)
        report = _without_absences(findings.report) if broken else findings.report
        table = Table(
            report, with_prelude=self._with_prelude, has_plugin=self._has_plugin
        )
        table.lacking = reader.incomplete
        with stages.stage("analyse"):
            Analysis(table).run(unit)
        _note_prelude(table, findings.report)
        reader.report_missing(failed=table.excused or findings.errors > 0)
        self._library.trail[absolute_path(source.path)] = None
        return _Read(
            source=source,
            model=TecsUnit(source.name, source.key, table.model()),
            table=table,
            units=tuple(reader.units),
            sources=(source, *self._library.found),
            headers=tuple(self._headers.found),
            findings=findings.diagnostics,
            dependencies=tuple(
                library.dependency(path)
                for library in libraries
                for path in library.trail
            ),
        )

    def _has_plugin(self, unit: Unit, file: str) -> bool:
        """Return whether a plug-in of tecsgen is in one of the searched folders."""
        folders = (Path(), *self._plugins.include, unit.source.path.parent)
        try:
            return any(self._plugins.open(each / file) is not None for each in folders)
        except OSError:
            return False

    def _note(self, unit: Unit, *, main: bool) -> None:
        source = unit.source
        file = self._files.get(source.name)
        imported = (inner.source.name for inner in unit.imports.values())
        self._files[source.name] = SourceFile(
            name=source.name,
            key=source.key,
            sha256=source.sha256,
            main=main or (file is not None and file.main),
            includes=tuple(
                dict.fromkeys((*(file.includes if file else ()), *imported))
            ),
        )


def _without_absences(
    report: Callable[[Diagnostic], None],
) -> Callable[[Diagnostic], None]:
    """Leave out what a statement that was skipped after a syntax error may contain."""

    def filtered(diagnostic: Diagnostic) -> None:
        if diagnostic.code not in _ABSENCES:
            report(diagnostic)

    return filtered


def _note_prelude(table: Table, report: Callable[[Diagnostic], None]) -> None:
    if table.prelude_used:
        names = list(table.prelude_used)
        message = f"known without an import: {', '.join(names)}"
        hint = "tecsgen needs an import or import_C that declares them"
        span = table.prelude_used[names[0]]
        report(files.PRELUDE.at(span, message, hint=hint))
