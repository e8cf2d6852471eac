"""Applies the fixes of diagnostics to the files of a project."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Edit
from rtgen.formatting.files import LANGUAGES, content
from rtgen.lint.fixes import applied
from rtgen.project import Project
from rtgen.project.output import Change


def changed_files(project: Project, found: Sequence[Diagnostic]) -> list[Change]:
    """Return the given files changed by fixes; included files are not changed."""
    edits: defaultdict[str, list[Edit]] = defaultdict(list)
    for d in found:
        for edit in d.fix.edits if d.fix is not None else ():
            edits[edit.span.file].append(edit)
    changes = []
    for path in sorted(project.sources):
        name = path.as_posix()
        if name in edits:
            data = path.read_bytes()
            language = LANGUAGES.get(Path(name).suffix.lower())
            read = content(data, language, project.kcode)
            new = read.encoded(applied(read.text, edits[name]))
            if new != data:
                changes.append(Change(path, data, new))
    return changes
