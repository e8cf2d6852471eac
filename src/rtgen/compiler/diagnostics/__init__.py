"""Diagnostics about a user's input, made from rules; `report` prints them."""

from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics.errors import InputError, ToolError
from rtgen.compiler.diagnostics.rules import MAX_TEXT_LENGTH, Rule, rules_of
from rtgen.compiler.diagnostics.severities import Severity
from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.diagnostics.findings import (
        Diagnostic,
        Edit,
        Fix,
        Related,
        Span,
        has_errors,
        in_order,
    )

__all__ = [
    "MAX_TEXT_LENGTH",
    "Diagnostic",
    "Edit",
    "Fix",
    "InputError",
    "Related",
    "Rule",
    "Severity",
    "Span",
    "ToolError",
    "has_errors",
    "in_order",
    "rules_of",
]

# Rules and their pages are read without findings.
__getattr__ = deferred("rtgen.compiler.diagnostics.findings", __all__)
