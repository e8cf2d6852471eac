"""Exit codes of commands, and the exceptions that end one."""

from __future__ import annotations

OK, NO, BAD_INPUT, FAILED = range(4)
"""Exit codes of commands: success, negative result, errors in the input, failed environment."""
INTERRUPTED = 130
"""Exit code after Ctrl-C and SIGTERM, as of a shell."""


class Refusal(Exception):  # noqa: N818 - the field's word for it is a noun
    """An argument that does not exist or has an invalid form."""


class ReportedError(Exception):
    """Ends a command whose failure has already been reported; `code` is the exit code."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(code)
