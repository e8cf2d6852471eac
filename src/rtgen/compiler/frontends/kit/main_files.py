"""Opens the files given to a command; reports missing and unreadable ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, Rule, Span
from rtgen.compiler.frontends.kit.library import F, Library
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.facts import files
from rtgen.facts.looks import NAMES, look


def open_main(
    library: Library[F],
    path: Path,
    shown: str,
    report: Callable[[Diagnostic], None],
    *,
    missing: Rule,
    unreadable: Rule,
    beside: str,
    apart: bool = False,
) -> F | None:
    """Return the file of a path, displayed as `shown`; None, after a diagnostic, if unreadable.

    The hint for a missing file is a similar name in its folder that matches the glob pattern
    `beside`. `apart`: links to one file are files of their own.
    """
    span = Span(shown, 1, 1, 1, 1)
    try:
        source = library.open(path, apart=apart)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        report(unreadable.at(span, f"{shown} cannot be read: {reason}"))
        return None
    if source is None:
        there = files.exists(path)
        message = f"{shown} does not exist"
        if there:
            kind = "a folder" if path.is_dir() else "not a regular file"
            message = f"{shown} is {kind}"
        look(NAMES, path.parent)
        others = path.parent.glob(beside)
        near = nearest(path.name, (p.name for p in others if p.is_file()))
        hint = f"did you mean {near}?" if near and not there else None
        report(missing.at(span, message, hint=hint))
    return source
