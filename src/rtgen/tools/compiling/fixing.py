"""Applies the fixes of diagnostics to the files of a project."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, Edit, ToolError
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.compiler.lint.fixes import applied
from rtgen.compiler.project import Project, shown
from rtgen.compiler.project.kinds import is_definition
from rtgen.compiler.project.output import Change
from rtgen.facts.decoded_text import NotEncodableError
from rtgen.facts.encodings import decode
from rtgen.facts.files import ChangedError, UnreadableError, absolute_path, read_file


def changed_files(
    project: Project, diagnostics: Sequence[Diagnostic], result: FrontendResult
) -> list[Change]:
    """Return the given files changed by fixes, and C headers of the project that they import.

    Other included files are not changed. `result` is the reading in which the diagnostics were
    found. Raises ToolError for a file that has been changed since.
    """
    edits: defaultdict[str, list[Edit]] = defaultdict(list)
    for d in diagnostics:
        for edit in d.fix.edits if d.fix is not None else ():
            edits[edit.span.file].append(edit)
    digests = {absolute_path(each.path): each.sha256 for each in result.dependencies}
    changes = []
    headers = [path for path in map(Path, edits) if _is_header(path, project)]
    for path in sorted({*project.sources, *headers}):
        name = path.as_posix()
        if name in edits:
            data = _content(path, digests.get(absolute_path(path)))
            new = _edited(path, data, edits[name], project.encoding)
            if new != data:
                changes.append(Change(path, data, new))
    return changes


def _is_header(path: Path, project: Project) -> bool:
    """Return whether a file is a C header of the project, which cannot be given itself."""
    place = Path(absolute_path(path))
    inside = place.is_relative_to(project.root)
    return inside and not (place.is_relative_to(project.output) or is_definition(path))


def _edited(path: Path, data: bytes, edits: Sequence[Edit], encoding: str) -> bytes:
    """Return the bytes of a file with edits of its text, in its encoding. Raises ToolError."""
    read = decode(data, encoding)
    try:
        return read.encode(applied(read.text, edits))
    except NotEncodableError as error:
        message = f"cannot fix {shown(path)}: {error}"
        raise ToolError(message, hint="convert the file to UTF-8 first") from None


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
