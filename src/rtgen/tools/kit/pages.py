"""The page of `rtgen explain CODE`, without the library of the command line.

That library takes longer to import than all that a page needs. These pages are not stored: whether
a stored one is still valid takes as long to find out.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.diagnostics.explain import rule_of, story
from rtgen.compiler.kit import plugins, translation
from rtgen.compiler.kit.project_file import interrupted_rename, language_of_project
from rtgen.tools.kit.console import write_out
from rtgen.tools.kit.exits import OK

_COMPLETION = "_RTGEN_COMPLETE"
"""The variable with which a shell asks for completions."""


def explained(arguments: Sequence[str]) -> int | None:
    """Print the page of a code, and return the exit code.

    None, and nothing is printed, for what only the command knows: options, unknown codes, pages on
    a terminal, plug-ins, a rename to complete, and what fails.
    """
    if not _is_plain(arguments):
        return None
    with translation.of_command(language_of_project):
        try:
            if plugins.announced(*plugins.Group):
                return None
            return _print(arguments[1])
        except (OSError, ToolError):
            return None


def _is_plain(arguments: Sequence[str]) -> bool:
    return (
        len(arguments) == 2
        and arguments[0] == "explain"
        and not arguments[1].startswith("-")
        and _COMPLETION not in os.environ
        and not sys.stdout.isatty()
    )


def _print(code: str) -> int | None:
    rule = rule_of(code) if interrupted_rename() is None else None
    if rule is None:
        return None
    write_out(story(rule))
    return OK
