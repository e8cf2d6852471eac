"""Errors of recordings."""

from __future__ import annotations


class RecordingError(Exception):
    """A recording cannot be written, read or replayed; `hint` suggests a solution, if known."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.hint = hint


class UnavailableError(RecordingError):
    """An error of the environment: a file that cannot be opened or written, a missing library."""


class SchemaError(RecordingError):
    """A schema that is not IDL, or not that of the expected type."""
