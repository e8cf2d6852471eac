"""How severe a diagnostic is."""

from __future__ import annotations

from enum import StrEnum


class Severity(StrEnum):
    """Severity of a diagnostic; only an error makes a command exit with 2."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"
