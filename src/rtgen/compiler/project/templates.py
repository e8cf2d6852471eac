"""The templates that a project lays over those of rtgen: `[templates] path`."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

from rtgen.compiler.backends.kit.rendering import template_names
from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.project import file as project_file
from rtgen.compiler.project.paths import normal, shown_path
from rtgen.compiler.project_rules import PATH_MISSING, PATH_OVERLAP, UNKNOWN_TEMPLATE
from rtgen.facts.files import is_folder, walk

_MAX_FILES = 1000
"""Maximum number of files that are looked at in the folder."""

_MAX_FINDINGS = 20


def template_folder(settings: project_file.Settings, root: Path) -> Path | None:
    """Return the folder of the project's templates, None if it has none."""
    path = settings.text("templates", "path", "")
    return normal(root / path) if path else None


def templates_of(
    settings: project_file.Settings, root: Path, output: Path
) -> tuple[dict[str, Path], list[Diagnostic]]:
    """Return the displayed paths of the project's templates by name, and diagnostics."""
    folder = template_folder(settings, root)
    if folder is None:
        return {}, []
    span = settings.span("templates", "path")
    if not is_folder(folder):
        path = settings.text("templates", "path", "")
        return {}, [PATH_MISSING.at(span, f"no folder {path!r}")]
    if folder == root or folder.is_relative_to(output):
        message = "the folder of templates must hold nothing else"
        return {}, [PATH_OVERLAP.at(span, message)]
    files = {
        path.relative_to(folder).as_posix(): shown_path(path)
        for path in islice(_files(folder), _MAX_FILES)
    }
    names = template_names()
    unknown = [name for name in files if name not in names]
    findings = [_unknown(files[name], name) for name in unknown[:_MAX_FINDINGS]]
    return files, findings


def no_template(name: str) -> tuple[str, str]:
    """Return message and hint for a name that no template has."""
    close = get_close_matches(name, template_names(), n=1)
    hint = f"did you mean {close[0]!r}?" if close else "rtgen new template lists them"
    return f"rtgen has no template {name!r}", hint


def _unknown(path: Path, name: str) -> Diagnostic:
    message, hint = no_template(name)
    return UNKNOWN_TEMPLATE.at(Span(path.as_posix(), 1, 1, 1, 2), message, hint=hint)


def _files(folder: Path) -> Iterator[Path]:
    """Yield the files below the folder, in order, without hidden ones."""
    for parent, folders, files in walk(folder):
        folders[:] = sorted(f for f in folders if not f.startswith("."))
        yield from (Path(parent, f) for f in sorted(files) if not f.startswith("."))
