"""Breaks that rtgen.toml allows: `[[diff.allow]]` with code, name or path, and a reason."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.tools.diff.changes import Change
from rtgen.tools.diff.kinds.catalogue import KINDS, UNUSED_ALLOWANCE


@dataclass(frozen=True, slots=True)
class Allowance:
    """An allowed break: a code or class, patterns of subject and file, and the reason."""

    code: str
    reason: str
    span: Span
    name: str = "*"
    path: str = "*"

    def covers(self, change: Change) -> bool:
        """Return whether the change is allowed."""
        files = [
            p.file.partition(":")[2] or p.file for p in (change.old, change.new) if p
        ]
        return (
            change.kind.code == self.code.upper()
            and fnmatchcase(change.subject, self.name)
            and any(fnmatchcase(file, self.path) for file in files)
        )


def allowed(
    changes: Iterable[Change], allowances: Sequence[Allowance]
) -> tuple[dict[Change, Allowance], list[Diagnostic]]:
    """Return the allowed changes with their allowances, and diagnostics about unused allowances."""
    found: dict[Change, Allowance] = {}
    used = set()
    for change in changes:
        for each in allowances:
            if each.covers(change):
                found.setdefault(change, each)
                used.add(each)
    known = {kind.code for kind in KINDS}
    unused = []
    for each in allowances:
        if each not in used:
            what = (
                "allows nothing"
                if each.code.upper() in known
                else "is not a code of a change"
            )
            text = f"{each.code} {what}; its reason was: {each.reason}"
            unused.append(
                UNUSED_ALLOWANCE.at(
                    each.span, text, hint="delete the entry, or correct it"
                )
            )
    return found, unused
