"""The pipeline of the CDL front end: from files to units of the model and diagnostics."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rtgen import stages
from rtgen.diagnostics import Diagnostic, in_order
from rtgen.frontends import FrontendResult
from rtgen.frontends.cdl.c_headers.file import HeaderFile
from rtgen.frontends.cdl.names.table import Table
from rtgen.frontends.cdl.passes import prelude as kernel
from rtgen.frontends.cdl.passes.analysis import Analysis
from rtgen.frontends.cdl.reader import Reader
from rtgen.frontends.cdl.rules import files
from rtgen.frontends.cdl.syntax import parser
from rtgen.frontends.cdl.syntax.unit import Unit
from rtgen.frontends.cdl.text.source import Source
from rtgen.frontends.kit.findings import Findings
from rtgen.frontends.kit.library import Library, absolute_path
from rtgen.frontends.kit.main_files import open_main
from rtgen.model import Model, SourceFile
from rtgen.model.tecs import TecsUnit

_FRAMES = 12 * parser.MAX_NESTING
"""The recursion limit for the deepest permitted nesting."""


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path] = (),
    define: Mapping[str, str] | None = None,
    kcode: str = "auto",
    prelude: bool = True,
    observe: Callable[[Table, Sequence[Unit]], None] | None = None,
) -> FrontendResult:
    """Read CDL files, each with its imports, into one unit of the model each.

    `root` is the project's folder, to which the keys of files are relative; `include` are the
    folders that are searched for imports; `define` gives macros of C headers; `kcode` is the
    encoding (`auto`, `euc`, `sjis`, `utf8`, `none`); with `prelude` the kernel's scalar types are
    known without an import. `observe` is called with the symbols and the files of each
    unit. All errors of the input are in the diagnostics, sorted;
    nothing is raised for it. Declarations with an error are not in the model.
    """
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        run = _Run(paths, root, include, define or {}, kcode, prelude, observe)
        return run.result()
    finally:
        sys.setrecursionlimit(limit)


def read_text(
    text: str, name: str = "text.cdl", *, prelude: bool = True
) -> tuple[TecsUnit, tuple[Diagnostic, ...]]:
    """The unit of a text without imports from files, and its findings, sorted."""
    run = _Run((), Path(), (), {}, "utf8", prelude)
    source = Source(name, name, Path(name), text.encode(), "utf8")
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        unit = run.unit(source)
    finally:
        sys.setrecursionlimit(limit)
    return unit, tuple(in_order(run.found.diagnostics))


class _Run:
    def __init__(
        self,
        paths: Sequence[Path],
        root: Path,
        include: Sequence[Path],
        define: Mapping[str, str],
        kcode: str,
        with_prelude: bool,
        observe: Callable[[Table, Sequence[Unit]], None] | None = None,
    ) -> None:
        def make(name: str, key: str, path: Path, data: bytes | None) -> Source:
            return Source(name, key, path, data, kcode)

        self._shown = {absolute_path(p): p.as_posix() for p in reversed(paths)}
        self._library = Library(make, root, include, self._shown)
        self._headers = Library(HeaderFile, root, include)
        self._paths = [Path(path) for path in dict.fromkeys(map(absolute_path, paths))]
        self._define = define
        self._with_prelude = with_prelude
        self._observe = observe
        self.found = Findings(files.TOO_MANY)
        self._report = self.found.report
        self._files: dict[str, SourceFile] = {}

    def result(self) -> FrontendResult:
        sources = [s for s in map(self._open, self._paths) if s is not None]
        self._check_stems(sources)
        units = [self.unit(source) for source in sources]
        for header in self._headers.sources:
            self._files[header.name] = SourceFile(
                name=header.name, key=header.key, sha256=header.sha256, main=False
            )
        return FrontendResult(
            model=Model(tuple(self._files.values()), (), (), tuple(units)),
            diagnostics=tuple(in_order(self.found.diagnostics)),
            sources={source.name: source.text for source in self._library.sources},
            dependencies=(*self._library.dependencies, *self._headers.dependencies),
        )

    def _check_stems(self, sources: Sequence[Source]) -> None:
        """Report files of equal stem, since the stem names the folder of generated files."""
        known: dict[str, Source] = {}
        for source in sources:
            stem = re.sub(r"\W", "_", source.path.stem).lower()
            first = known.setdefault(stem, source)
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
        )

    def unit(self, source: Source) -> TecsUnit:
        """The unit of a main file."""
        stages.file(source.name)
        before = self.found.errors
        names = frozenset(kernel.TYPES) if self._with_prelude else frozenset[str]()
        reader = Reader(self._library, self._headers, self._define, names, self._report)
        with stages.stage("parse"):
            unit = reader.read(source)
        table = Table(self._report, with_prelude=self._with_prelude)
        table.lacking = reader.incomplete
        with stages.stage("analyse"):
            Analysis(table).run(unit)
        if self._observe is not None:
            self._observe(table, reader.units)
        self._note_prelude(table)
        wrong = table.excused or self.found.errors > before
        reader.report_missing(failed=wrong)
        for read in reader.units:
            self._note(read, main=read is unit)
        return TecsUnit(source.name, source.key, table.model())

    def _note_prelude(self, table: Table) -> None:
        if table.prelude_used:
            names = list(table.prelude_used)
            message = f"known without an import: {', '.join(names)}"
            hint = "tecsgen needs an import or import_C that declares them"
            span = table.prelude_used[names[0]]
            self._report(files.PRELUDE.at(span, message, hint=hint))

    def _note(self, unit: Unit, *, main: bool) -> None:
        source = unit.source
        known = self._files.get(source.name)
        imported = (inner.source.name for inner in unit.imports.values())
        self._files[source.name] = SourceFile(
            name=source.name,
            key=source.key,
            sha256=source.sha256,
            main=main or (known is not None and known.main),
            includes=tuple(
                dict.fromkeys((*(known.includes if known else ()), *imported))
            ),
        )
