"""Replaces files of the user, following links and keeping permissions."""

from __future__ import annotations

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project.output import Change
from rtgen.compiler.project.paths import shown
from rtgen.facts.files import replace_file


def rewrite(change: Change) -> None:
    """Replace the content of a file, or of a link's target. Raises ToolError.

    A file that is no longer as it was read, or cannot be written, is left as it is.
    """
    assert change.old is not None
    assert change.new is not None
    try:
        replace_file(change.path, change.new, change.old)
    except OSError as error:
        message = f"cannot write {shown(change.path)}: {error.strerror or error}"
        raise ToolError(message) from error
