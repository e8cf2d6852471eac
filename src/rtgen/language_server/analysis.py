"""Runs the compiler on a project whose files may have unsaved texts: findings, model, index."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from rtgen import compiler, linting
from rtgen.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    ToolError,
    has_errors,
    in_order,
)
from rtgen.files import absolute_path, overlaid, read_start
from rtgen.frontends import FrontendResult
from rtgen.frontends.cdl.names.table import Table
from rtgen.frontends.cdl.syntax.unit import Unit as CdlUnit
from rtgen.frontends.idl.names.tables import Tables
from rtgen.language_server.documents import Snapshot
from rtgen.language_server.indexing.cdl import CdlNames
from rtgen.language_server.indexing.devices import BusNames, add_device
from rtgen.language_server.indexing.idl import IdlNames
from rtgen.language_server.indexing.index import Collector, FileIndex, Index
from rtgen.language_server.indexing.profiles import ProfileNames
from rtgen.language_server.indexing.project_file import add_project_file
from rtgen.language_server.text import Text
from rtgen.linting import unknown_codes
from rtgen.model import Model
from rtgen.project import Project, shown
from rtgen.systems import reading

_MOST_OF_SETTINGS = 1024 * 1024
_MOST_OF_HEADER = 1024 * 1024


class SupersededError(Exception):
    """A newer text makes the analysis pointless."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """What is known of a project: `texts` by displayed path are those that it is known of."""

    project: Project
    model: Model
    findings: tuple[Diagnostic, ...]
    texts: Mapping[str, Text]
    index: Index


class _Names:
    """Collects the names that front ends resolve. Raises SupersededError between units."""

    def __init__(self, collector: Collector, is_superseded: Callable[[], bool]) -> None:
        self._idl = IdlNames(collector)
        self._cdl = CdlNames(collector)
        self._is_superseded = is_superseded

    def idl(self, tables: Tables) -> None:
        if self._is_superseded():
            raise SupersededError
        self._idl.add(tables)

    def cdl(self, table: Table, units: Sequence[CdlUnit]) -> None:
        if self._is_superseded():
            raise SupersededError
        self._cdl.add(table, units)


def analyse(
    project: Project,
    snapshot: Snapshot,
    *,
    whole: bool = True,
    before: Analysis | None = None,
    is_superseded: Callable[[], bool] = lambda: False,
) -> Analysis:
    """Analyse a project with the documents of a snapshot in place of files on the disk.

    `whole`: the files are all of the project. Files that cannot be read now keep their names of
    `before`. Raises SupersededError when `is_superseded`.
    """
    collector = Collector()
    names = _Names(collector, is_superseded)
    with overlaid(snapshot.contents):
        result = compiler.read(project, observer=names)
        findings = [*unknown_codes(project)]
        if not has_errors(findings):
            findings = linting.findings(project, result, whole=whole)
        result = _with_systems(project, result, findings)
        texts = _texts(project, result, before, snapshot)
        _add_unread(collector, texts)
    _add_others(collector, project, result.model, texts)
    files = {file.path: file for file in collector.indexes(texts)}
    for path, kept in (before.index.files if before is not None else {}).items():
        if path not in files and (path in snapshot.texts or Path(path).is_file()):
            files[path] = kept
    return Analysis(
        project,
        result.model,
        tuple(in_order(findings)),
        texts,
        Index(files.values()),
    )


def _with_systems(
    project: Project, result: FrontendResult, findings: list[Diagnostic]
) -> FrontendResult:
    """The result with the project's systems, whose findings are added."""
    if not project.systems:
        return result
    found = reading.read(project.systems, root=project.root, output=project.output)
    definitions = result
    if found.systems and not has_errors(result.diagnostics):
        definitions = compiler.read(project, lowered=True)
    _, more = reading.against(found.systems, definitions)
    findings += [*found.diagnostics, *more]
    return replace(
        result,
        model=replace(result.model, systems=tuple(found.systems)),
        sources={**result.sources, **found.sources},
    )


def _texts(
    project: Project,
    result: FrontendResult,
    before: Analysis | None,
    snapshot: Snapshot,
) -> dict[str, Text]:
    """The texts that were read: those of open documents, or of before if they are unchanged."""
    sources = dict(result.sources)
    if project.file is not None:
        data = read_start(project.file, _MOST_OF_SETTINGS)
        sources[shown(project.file)] = data.decode("utf-8", "replace")
    texts = {}
    for name, source in sources.items():
        known = snapshot.texts.get(absolute_path(name))
        if known is None and before is not None:
            known = before.texts.get(name)
        same = known is not None and known.source == source
        texts[name] = known if known is not None and same else Text(source)
    return texts


def _add_unread(collector: Collector, texts: dict[str, Text]) -> None:
    """Add the texts of C headers, which are no sources of findings."""
    for file in collector.files:
        if file not in texts:
            try:
                data = read_start(Path(file), _MOST_OF_HEADER)
            except (OSError, ValueError):
                continue
            texts[file] = Text(data.decode("utf-8", "replace"))


def _add_others(
    collector: Collector, project: Project, model: Model, texts: Mapping[str, Text]
) -> None:
    """Add the names of languages whose models have the places."""
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
    """The findings of a project that cannot be loaded."""
    if isinstance(error, InputError):
        return error.diagnostics
    return (Diagnostic("", Severity.ERROR, error.message, hint=error.hint),)


def files_of(analysis: Analysis) -> set[str]:
    """The absolute paths of the files that an analysis speaks of."""
    return {absolute_path(file) for file in analysis.texts} | set(analysis.index.files)


__all__ = [
    "Analysis",
    "FileIndex",
    "SupersededError",
    "analyse",
    "files_of",
    "problems_of",
]
