"""Renames that were interrupted, as findings of the command that completes them."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, ToolError
from rtgen.compiler.kit.own_files import RENAME_JOURNAL
from rtgen.compiler.project import shown
from rtgen.compiler.project_rules import INTERRUPTED
from rtgen.tools.renaming import journal


def completed(root: Path) -> list[Diagnostic]:
    """Complete the rename whose journal is in a folder; return what to say about it.

    Raises ToolError.
    """
    try:
        outcome = journal.complete(root)
    except (OSError, ValueError) as error:
        message = f"a rename was interrupted, and cannot be completed: {error}"
        hint = f"restore the files from version control, and remove {RENAME_JOURNAL}"
        raise ToolError(message, hint=hint) from error
    if outcome is None:
        return []
    message = f"the rename of {outcome.old} to {outcome.new} was interrupted; it is completed now"
    hint = "run rtgen generate"
    if outcome.left:
        files = ", ".join(shown(each) for each in outcome.left[:8])
        message += f", except in files that have changed since: {files}"
        hint = "rename in these by hand; rtgen check shows what is left"
    return [INTERRUPTED.at(None, message, hint=hint)]
