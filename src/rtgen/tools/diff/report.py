"""Reports changes as diagnostics, and as JSON."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Related, Severity, Span
from rtgen.tools.diff.allowances import Allowance
from rtgen.tools.diff.changes import Break, Change, User

FORMAT = "rtgen-diff/1"
_MAX_PER_KIND = 3


def is_asked(change: Change, use: Collection[Break]) -> bool:
    """Return whether the change is of a selected class."""
    return not set(use).isdisjoint(change.classes)


def finding(
    change: Change, use: Collection[Break], allowance: Allowance | None
) -> Diagnostic:
    """Return the diagnostic of a change: an error if selected and not allowed."""
    span = change.new or change.old
    related = []
    if change.new is not None and change.old is not None:
        related.append(Related(change.old, "before"))
    breaks = is_asked(change, use) and allowance is None
    made = change.kind.rule.at(
        span,
        f"{change.message} [{classes_text(change)}]",
        related=related,
        hint=_hint(change, allowance),
    )
    return made if breaks else replace(made, severity=Severity.NOTE)


def classes_text(change: Change) -> str:
    """Return the classes, with what breaks on the wire: `wire: CDR, PDO; source`."""
    parts = []
    for each in change.classes:
        if each is Break.WIRE:
            parts.append(f"{each}: {', '.join(change.wires)}")
        else:
            parts.append(str(each))
    return "; ".join(parts)


def _hint(change: Change, allowance: Allowance | None) -> str:
    text = change.kind.why
    if change.users:
        text += f"; breaks {', '.join(_users_texts(change.users))}"
    if allowance is not None:
        text += f"; allowed: {allowance.reason}"
    return text


def _users_texts(users: Sequence[User]) -> Iterator[str]:
    """Yield the users, a few of each kind, in the order of kinds."""
    for kind, group in groupby(users, key=lambda user: user.kind):
        listed = [*group]
        yield from (_user_text(user) for user in listed[:_MAX_PER_KIND])
        if (more := len(listed) - _MAX_PER_KIND) > 0:
            yield f"{more} more {kind}{'s' * (more > 1)}"


def _user_text(user: User) -> str:
    wires = f" ({', '.join(user.wires)})" if user.wires else ""
    return f"{user.kind} {user.name}{wires}"


def as_json(
    labels: tuple[str, str],
    changes: Sequence[Change],
    allowances: Mapping[Change, Allowance],
) -> dict[str, Any]:
    """Return the comparison as JSON, in the format rtgen-diff/1."""
    return {
        "format": FORMAT,
        "old": labels[0],
        "new": labels[1],
        "changes": [_change(c, allowances.get(c)) for c in changes],
        "summary": counts(changes, allowances),
    }


def counts(
    changes: Sequence[Change], allowances: Mapping[Change, Allowance]
) -> dict[str, int]:
    """Return the number of changes that are not allowed, by class, and of allowed ones."""
    found = {str(each): 0 for each in Break}
    for change in changes:
        if change not in allowances:
            for each in change.classes:
                found[each] += 1
    return {**found, "allowed": len(allowances)}


def _change(change: Change, allowance: Allowance | None) -> dict[str, Any]:
    return {
        "code": change.kind.code,
        "title": change.kind.title,
        "classes": [str(each) for each in change.classes],
        "wires": [str(each) for each in change.wires],
        "subject": change.subject,
        "message": change.message,
        "why": change.kind.why,
        "old": _place(change.old),
        "new": _place(change.new),
        "users": [
            {"kind": u.kind, "name": u.name, "wires": [str(w) for w in u.wires]}
            for u in change.users
        ],
        "allowed": None if allowance is None else allowance.reason,
    }


def _place(span: Span | None) -> dict[str, Any] | None:
    if span is None:
        return None
    return {
        "file": span.file,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }
