"""Runs the compiler on a project with unsaved texts: diagnostics, model, index."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

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
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.kit import stages
from rtgen.compiler.linting import unknown_codes
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project, behaviours
from rtgen.facts.files import absolute_path, overlaid
from rtgen.tools.indexing import reading
from rtgen.tools.indexing.index import FileIndex, Index
from rtgen.tools.indexing.text import Text
from rtgen.tools.lsp.documents import Snapshot


class SupersededError(Exception):
    """Raised when a newer text makes the analysis pointless."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Result of analysing a project, with its `names`.

    `findings` are those of `rtgen lint`, `read_with` those of front ends and of systems, including
    suppressed ones; `emitting` are those of lowerings, back ends and behaviours, which `rtgen
    check` reports in addition. Until back ends have run, `complete` are the definitions for them.
    """

    project: Project
    findings: tuple[Diagnostic, ...]
    names: reading.Reading
    read_with: frozenset[Diagnostic] = frozenset()
    complete: FrontendResult | None = None
    emitting: tuple[Diagnostic, ...] = ()

    @property
    def model(self) -> Model:
        """The definitions and systems."""
        return self.names.result.model

    @property
    def texts(self) -> Mapping[str, Text]:
        """The inputs by displayed path."""
        return self.names.texts

    @property
    def index(self) -> Index:
        """The names with their places."""
        return self.names.index


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
        # The tables of the unit before have cycles.
        gc.collect(1)

    def note(self, _: str) -> None:
        pass

    def _go_on(self) -> None:
        if self.is_superseded():
            raise SupersededError


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
    with overlaid(snapshot.contents), stages.observed(_Stages(is_superseded)):
        names = reading.read(
            project,
            memo,
            texts=snapshot.texts,
            before=None if before is None else before.names,
        )
        findings = [*unknown_codes(project)]
        if not has_errors(findings):
            findings = linting.findings(
                project, names.result, beside=names.of_systems, whole=whole
            )
    return Analysis(
        project,
        tuple(in_order(findings)),
        names,
        frozenset((*names.result.diagnostics, *names.of_systems)),
        names.complete,
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
            diagnostics += behaviours.check(project, outcome)
    dependencies = analysis.read_with.union(analysis.findings)
    emitting = tuple(d for d in in_order(diagnostics) if d not in dependencies)
    return replace(analysis, complete=None, emitting=emitting)


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
