"""The section `[diff]` of rtgen.toml: the selected classes, and allowed breaks."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.project import file as project_file
from rtgen.compiler.project import load, shown
from rtgen.tools.diff.allowances import Allowance
from rtgen.tools.diff.changes import BREAKING, Break


@dataclass(frozen=True, slots=True)
class DiffSettings:
    """`use`, the revision of OLD with its place, and the allowances in the order of the file."""

    use: tuple[Break, ...] = BREAKING
    against: tuple[str, Span] | None = None
    allowances: tuple[Allowance, ...] = ()


def settings() -> DiffSettings:
    """Return the settings of the project of the working folder. Raises InputError."""
    project = load()
    if project.file is None:
        return DiffSettings()
    content = project_file.read(project.file, shown(project.file))
    section = content.content.get("diff", {})
    against = None
    if "against" in section:
        against = section["against"], content.span("diff", "against")
    return DiffSettings(
        tuple(Break(word) for word in section.get("use", BREAKING)),
        against,
        tuple(
            Allowance(span=content.table_span("diff", "allow", number), **entry)
            for number, entry in enumerate(section.get("allow", []))
        ),
    )
