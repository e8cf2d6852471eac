"""Exceptions that end a run with diagnostics, or with an error of the environment."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtgen.compiler.diagnostics.findings import Diagnostic


class InputError(Exception):
    """Input that cannot be processed further, with its diagnostics (at least one error)."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(f"{d.code}: {d.message}" for d in self.diagnostics))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Diagnostic, ...]]]:
        return (InputError, (self.diagnostics,))


class ToolError(Exception):
    """An error of the environment (disk, port, missing extra), not of the input: exit code 3."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.message = message
        self.hint = hint
        super().__init__(message)

    def __reduce__(self) -> tuple[type[ToolError], tuple[str, str | None]]:
        return (ToolError, (self.message, self.hint))
