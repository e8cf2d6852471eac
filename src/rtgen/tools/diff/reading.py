"""Reads the two versions: files, folders with or without rtgen.toml, git revisions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec
from msgspec.structs import replace

from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Diagnostic, InputError, Related, Span, has_errors
from rtgen.compiler.kit import stages
from rtgen.compiler.project import (
    FILE_NAME,
    SYSTEMS_TARGET,
    Project,
    load,
    require_sources,
    shown,
    with_arguments,
)
from rtgen.compiler.project import file as project_file
from rtgen.compiler.systems import reading as systems
from rtgen.tools.diff.kinds.catalogue import NO_VERSION
from rtgen.tools.diff.revisions import (
    commit_of,
    extract,
    main_branch,
    top_level,
    unknown_revision,
)
from rtgen.tools.diff.versions import Version
from rtgen.tools.kit.exits import Refusal

Relabel = Callable[[Span], Span]


class Source(msgspec.Struct, frozen=True):
    """The source of a version: a path, or a path at a revision.

    `path` is None for the project of the working folder.
    """

    label: str
    path: Path | None = None
    commit: str | None = None
    repository: Path | None = None


def source_of(word: str, *, revision: bool = False) -> Source:
    """Return the source that an argument of the command line denotes.

    An existing path takes precedence over a revision, unless a revision is required. Raises
    InputError.
    """
    path = Path(word)
    if not revision and path.exists():
        return Source(word, path)
    repository = top_level(Path())
    if repository is None:
        raise unknown_revision(None, word)
    name, colon, inside = word.partition(":")
    commit = commit_of(repository, name if colon else word)
    if commit is None:
        raise unknown_revision(repository, word)
    if not colon:
        return Source(word, None, commit, repository)
    if inside.startswith("./"):
        inside = (Path.cwd().relative_to(repository) / inside).as_posix()
    return Source(name, Path(inside), commit, repository)


def default_source(against: tuple[str, Span] | None) -> Source:
    """Return OLD if none is named: the revision of `[diff] against`, else the main branch.

    Raises InputError, Refusal.
    """
    if against is not None:
        revision, span = against
        try:
            return source_of(revision, revision=True)
        except InputError as error:
            raise InputError(replace(d, span=span) for d in error.diagnostics) from None
    repository = top_level(Path())
    branch = None if repository is None else main_branch(repository)
    if branch is None:
        raise Refusal("name OLD, or --against REVISION: git has no main branch here")
    return source_of(branch, revision=True)


def at_revision(source: Source, path: Path) -> Source:
    """Return a path of the working tree at the revision of a source. Raises InputError."""
    assert source.repository is not None
    absolute = path.resolve()
    if not absolute.is_relative_to(source.repository):
        message = f"{path.as_posix()} is not in the repository of {source.label}"
        raise InputError([NO_VERSION.at(None, message)])
    return replace(source, path=absolute.relative_to(source.repository))


@contextmanager
def opened(source: Source) -> Iterator[Version]:
    """Read the version of a source. Raises InputError for definitions with errors."""
    if source.commit is None:
        yield _read(source, _project_of_path(source.path), lambda span: span)
        return
    assert source.repository is not None
    with TemporaryDirectory(prefix="rtgen-diff-") as name:
        folder = Path(name).resolve()
        with stages.stage(f"extract {source.label}"):
            extract(source.repository, source.commit, folder)
        relabel = _relabelling(folder, source.label)
        try:
            project = _project_at(source, folder)
            yield _read(source, project, relabel)
        except InputError as error:
            raise InputError(_relabelled(error.diagnostics, relabel)) from None


def _relabelling(folder: Path, label: str) -> Relabel:
    prefix = shown(folder) + "/"

    def relabel(span: Span) -> Span:
        if not span.file.startswith(prefix):
            return span
        return replace(span, file=f"{label}:{span.file.removeprefix(prefix)}")

    return relabel


def _relabelled(
    diagnostics: tuple[Diagnostic, ...], relabel: Relabel
) -> list[Diagnostic]:
    return [
        replace(
            d,
            span=None if d.span is None else relabel(d.span),
            related=tuple(Related(relabel(r.span), r.label) for r in d.related),
        )
        for d in diagnostics
    ]


def _project_of_path(path: Path | None) -> Project:
    """Return the project of the working folder, of a folder with rtgen.toml, or around a path."""
    if path is None:
        project = load()
        if project.file is None:
            return with_arguments(project, paths=["."], target=SYSTEMS_TARGET)
        return project
    if (path / FILE_NAME).is_file():
        return load(path.absolute())
    if path.name == FILE_NAME:
        return load(path.absolute().parent)
    return with_arguments(load(), paths=[path.as_posix()], target=SYSTEMS_TARGET)


def _project_at(source: Source, folder: Path) -> Project:
    """Return the project in a folder to which a revision was extracted."""
    here = load()
    root = here.root.resolve()
    inside = Path()
    if root.is_relative_to(source.repository or root):
        inside = root.relative_to(source.repository or root)
    if source.path is None:
        if (folder / inside / FILE_NAME).is_file():
            return load(folder / inside)
        if here.file is not None:
            message = f"{source.label} has no {(inside / FILE_NAME).as_posix()}"
            hint = f"name the definitions: {source.label}:FOLDER"
            raise InputError([NO_VERSION.at(None, message, hint=hint)])
        path = folder / inside
    else:
        path = folder / source.path
    if not path.exists():
        message = f"{source.label} has no {(source.path or inside).as_posix()}"
        raise InputError([NO_VERSION.at(None, message)])
    if (path / FILE_NAME).is_file():
        return load(path)
    if path.name == FILE_NAME:
        return load(path.parent)
    around = load(folder / inside)
    if around.file is None:
        around = replace(around, include=())
    return with_arguments(around, paths=[shown(path)], target=SYSTEMS_TARGET)


def _read(source: Source, project: Project, relabel: Relabel) -> Version:
    if not project.systems:
        require_sources(project)
    with stages.stage(f"version {source.label}"):
        result = compilation.read(project, lowered=True)
        if project.systems and not has_errors(result.diagnostics):
            result = systems.added(
                result,
                project.systems,
                root=project.root,
                output=project.output,
                encoding=project.encoding,
            )
    if has_errors(result.diagnostics):
        raise InputError(_relabelled(result.diagnostics, relabel))
    content: dict[str, Any] = {}
    places: dict[tuple[str, str], Span] = {}
    if project.file is not None and _is_project(source, project):
        settings = project_file.read(project.file, shown(project.file))
        content = settings.content
        places = {
            (section, key): relabel(settings.span(section, key))
            for section, table in content.items()
            if isinstance(table, dict)
            for key in table
        }
    return Version(
        model=result.model,
        sources={
            relabel(Span(name, 1, 1, 1, 1)).file: text
            for name, text in result.sources.items()
        },
        diagnostics=result.diagnostics,
        xcdr2=project.representation == "xcdr2",
        extensibility=project.extensibility,
        settings=content,
        places=places,
        relabel=relabel,
    )


def _is_project(source: Source, project: Project) -> bool:
    """Return whether the source is a project, as opposed to some of its definitions."""
    path = source.path
    if path is None or path.name == FILE_NAME:
        return True
    return path.absolute() == project.root or (
        source.commit is not None
        and project.root.parts[-len(path.parts) :] == path.parts
    )
