"""Runs the compiler on a project with unsaved texts: diagnostics, model, index."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from rtgen.compiler import compilation, linting
from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    ToolError,
    has_errors,
    in_order,
)
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.syntax.unit import Unit as CdlUnit
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.kit import stages
from rtgen.compiler.linting import unknown_codes
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project, behaviours, shown
from rtgen.compiler.systems import reading
from rtgen.facts.encodings import decode
from rtgen.facts.files import absolute_path, overlaid, read_start
from rtgen.tools.lsp.documents import Snapshot
from rtgen.tools.lsp.indexing.cdl import CdlNames
from rtgen.tools.lsp.indexing.devices import BusNames, add_device
from rtgen.tools.lsp.indexing.idl import IdlNames
from rtgen.tools.lsp.indexing.index import Collector, FileIndex, Index
from rtgen.tools.lsp.indexing.profiles import ProfileNames
from rtgen.tools.lsp.indexing.project_file import add_project_file
from rtgen.tools.lsp.text import Text

_MAX_SETTINGS_BYTES = 1024 * 1024
_MAX_HEADER_BYTES = 1024 * 1024


class SupersededError(Exception):
    """Raised when a newer text makes the analysis pointless."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Result of analysing a project; `texts`, by displayed path, are its inputs.

    `findings` are those of `rtgen lint`, `reading` those of front ends and of systems, including
    suppressed ones; `emitting` are those of lowerings, back ends and behaviours, which `rtgen
    check` reports in addition. Until back ends have run, `complete` are the definitions for them.
    """

    project: Project
    model: Model
    findings: tuple[Diagnostic, ...]
    texts: Mapping[str, Text]
    index: Index
    reading: frozenset[Diagnostic] = frozenset()
    complete: FrontendResult | None = None
    emitting: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class _Stages:
    """Aborts a superseded analysis at its next stage or file."""

    is_superseded: Callable[[], bool]

    def begin(self, _: str) -> None:
        self._go_on()

    def end(self) -> None:
        pass

    def file(self, _: str) -> None:
        self._go_on()

    def note(self, _: str) -> None:
        pass

    def _go_on(self) -> None:
        if self.is_superseded():
            raise SupersededError


class _Names:
    """Collects the names that front ends resolve."""

    def __init__(self, collector: Collector) -> None:
        self._idl = IdlNames(collector)
        self._cdl = CdlNames(collector)

    def idl(self, tables: Tables) -> None:
        self._idl.add(tables)

    def cdl(self, table: Table, units: Sequence[CdlUnit]) -> None:
        self._cdl.add(table, units)


def analyse(
    project: Project,
    snapshot: Snapshot,
    memo: Memo,
    *,
    whole: bool = True,
    before: Analysis | None = None,
    is_superseded: Callable[[], bool] = lambda: False,
) -> Analysis:
    """Analyse a project with the documents of a snapshot in place of files on the disk.

    `memo` caches the results of earlier analyses. `whole`: the files are all of the project. Files
    that cannot be read keep their names from `before`. Raises SupersededError if `is_superseded`
    returns true.
    """
    collector = Collector()
    with overlaid(snapshot.contents), stages.observed(_Stages(is_superseded)):
        memo.begin()
        names = _Names(collector)
        result = compilation.read(project, observer=names, memo=memo)
        complete = None
        if not has_errors(result.diagnostics):
            complete = compilation.read(project, lowered=True, memo=memo)
        of_systems: list[Diagnostic] = []
        result = _with_systems(project, result, complete, of_systems, memo)
        findings = [*unknown_codes(project)]
        if not has_errors(findings):
            findings = linting.findings(project, result, beside=of_systems, whole=whole)
        texts = _texts(project, result, before, snapshot)
        _add_unread(collector, texts, project.encoding)
    _add_others(collector, project, result.model, texts)
    files = {file.path: file for file in collector.indexes(texts)}
    for path, index in (before.index.files if before is not None else {}).items():
        if path not in files and (path in snapshot.texts or Path(path).is_file()):
            files[path] = index
    return Analysis(
        project,
        result.model,
        tuple(in_order(findings)),
        texts,
        Index(files.values()),
        frozenset((*result.diagnostics, *of_systems)),
        complete,
    )


def emitted(
    analysis: Analysis,
    snapshot: Snapshot,
    *,
    is_superseded: Callable[[], bool] = lambda: False,
) -> Analysis:
    """Return the analysis with the diagnostics of the back ends.

    Raises SupersededError if `is_superseded` returns true.
    """
    project, complete = analysis.project, analysis.complete
    if complete is None:
        return analysis
    with overlaid(snapshot.contents), stages.observed(_Stages(is_superseded)):
        outcome = compilation.emitted(project, complete)
        diagnostics = list(outcome.diagnostics)
        if not outcome.failed:
            diagnostics += behaviours.check(project, outcome.artifacts)
    dependencies = analysis.reading.union(analysis.findings)
    emitting = tuple(d for d in in_order(diagnostics) if d not in dependencies)
    return replace(analysis, complete=None, emitting=emitting)


def _with_systems(
    project: Project,
    result: FrontendResult,
    complete: FrontendResult | None,
    findings: list[Diagnostic],
    memo: Memo,
) -> FrontendResult:
    """Return the result with the project's systems, whose diagnostics are added."""
    if not project.systems:
        return result
    read = [_system(project, path, memo) for path in project.systems]
    systems = [system for each in read for system in each.systems]
    _, more = reading.against(systems, complete or result)
    findings += [*(d for each in read for d in each.diagnostics), *more]
    sources = {name: text for each in read for name, text in each.sources.items()}
    return msgspec.structs.replace(
        result,
        model=msgspec.structs.replace(result.model, systems=tuple(systems)),
        sources={**result.sources, **sources},
    )


def _system(project: Project, path: Path, memo: Memo) -> reading.Systems:
    def make() -> reading.Systems:
        return reading.read(
            [path],
            root=project.root,
            output=project.output,
            encoding=project.encoding,
        )

    place = (str(Path.cwd()), project.root, project.output, path)
    key = ("system", *place, project.encoding)
    return memo.read(key, make, lambda read: read.dependencies[0].sha256 is not None)


def _texts(
    project: Project,
    result: FrontendResult,
    before: Analysis | None,
    snapshot: Snapshot,
) -> dict[str, Text]:
    """Return the texts that were read: of open documents, or of `before` if unchanged."""
    sources = dict(result.sources)
    if project.file is not None:
        data = read_start(project.file, _MAX_SETTINGS_BYTES)
        sources[shown(project.file)] = decode(data, standard=True).normal
    texts = {}
    for name, source in sources.items():
        text_of_file = snapshot.texts.get(absolute_path(name))
        if text_of_file is None and before is not None:
            text_of_file = before.texts.get(name)
        same = text_of_file is not None and text_of_file.normal == source
        texts[name] = (
            text_of_file if text_of_file is not None and same else Text(source)
        )
    return texts


def _add_unread(collector: Collector, texts: dict[str, Text], encoding: str) -> None:
    """Add the texts of C headers, which are not sources of diagnostics."""
    for file in collector.files:
        if file not in texts:
            try:
                data = read_start(Path(file), _MAX_HEADER_BYTES)
            except OSError:
                continue
            texts[file] = Text(decode(data, encoding).normal)


def _add_others(
    collector: Collector, project: Project, model: Model, texts: Mapping[str, Text]
) -> None:
    """Add the names of languages whose models have places."""
    for device in model.devices:
        add_device(collector, device)
    described = {absolute_path(device.file) for device in model.devices}
    for bus in model.buses:
        for kind in bus.kinds:
            path = absolute_path(kind.device.file)
            if path not in described and kind.described is None:
                described.add(path)
                add_device(collector, kind.device)
        if bus.file in texts:
            BusNames(collector, bus, texts[bus.file]).add()
    profiles = ProfileNames(collector, model, texts)
    for profile in model.profiles:
        profiles.add_component(profile)
    for system in model.systems:
        profiles.add_system(system)
    if project.file is not None:
        file = shown(project.file)
        add_project_file(collector, file, texts[file])


def problems_of(error: InputError | ToolError) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of a project that cannot be loaded."""
    if isinstance(error, InputError):
        return error.diagnostics
    return (Diagnostic("", Severity.ERROR, error.message, hint=error.hint),)


def files_of(analysis: Analysis) -> set[str]:
    """Return the absolute paths of the files in an analysis."""
    return {absolute_path(file) for file in analysis.texts} | set(analysis.index.files)


__all__ = [
    "Analysis",
    "FileIndex",
    "SupersededError",
    "analyse",
    "files_of",
    "problems_of",
]
