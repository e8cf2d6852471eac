"""Errors of recordings."""

from __future__ import annotations

from rtgen.compiler.diagnostics import ToolError


class RecordingError(ToolError):
    """A recording cannot be written, read or replayed."""


class UnavailableError(RecordingError):
    """An error of the environment: a file that cannot be opened or written, a missing library."""


class SchemaError(RecordingError):
    """A schema that is not IDL, or not that of the expected type."""
