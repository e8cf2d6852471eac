"""Applies the fixes of diagnostics to the files of a project."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Edit, ToolError
from rtgen.files import ChangedError, UnreadableError, absolute_path, read_file
from rtgen.formatting.files import LANGUAGES, content
from rtgen.frontends import FrontendResult
from rtgen.frontends.kit.library import MAX_BYTES
from rtgen.lint.fixes import applied
from rtgen.project import Project, shown
from rtgen.project.output import Change


def changed_files(
    project: Project, found: Sequence[Diagnostic], result: FrontendResult
) -> list[Change]:
    """Return the given files changed by fixes; included files are not changed.

    `result` is the reading in which the diagnostics were found. Raises ToolError for a file that
    has been changed since.
    """
    edits: defaultdict[str, list[Edit]] = defaultdict(list)
    for d in found:
        for edit in d.fix.edits if d.fix is not None else ():
            edits[edit.span.file].append(edit)
    digests = {absolute_path(each.path): each.sha256 for each in result.dependencies}
    changes = []
    for path in sorted(project.sources):
        name = path.as_posix()
        if name in edits:
            data = _content(path, digests.get(absolute_path(path)))
            language = LANGUAGES.get(Path(name).suffix.lower())
            read = content(data, language, project.kcode)
            new = read.encoded(applied(read.text, edits[name]))
            if new != data:
                changes.append(Change(path, data, new))
    return changes


def _content(path: Path, digest: str | None) -> bytes:
    """Return the bytes of a file with that SHA-256. Raises ToolError."""
    try:
        data = read_file(path, MAX_BYTES)
        if sha256(data).hexdigest() != digest:
            raise ChangedError
    except (UnreadableError, ChangedError) as error:
        message = f"cannot fix {shown(path)}: {error.strerror}"
        raise ToolError(message) from error
    return data
