"""Texts for pages: of errors, and without what CDR cannot hold.

CDR cannot hold NUL, and octets of file names that are not UTF-8.
"""

from __future__ import annotations

import re
from typing import Any, Final

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.runtime.failures import described
from rtgen.ui.protocol import ui

_UNSENDABLE: Final = re.compile("[\0\ud800-\udfff]")


def sendable(value: Any) -> Any:
    """Return a copy of a message with U+FFFD for characters that CDR cannot hold."""
    match value:
        case str():
            return _UNSENDABLE.sub("\ufffd", value)
        case list():
            return [sendable(each) for each in value]
        case ui.Event():
            return ui.Event(value.discriminator, sendable(value.value))
        case msgspec.Struct():
            parts = {
                name: sendable(getattr(value, name)) for name in value.__struct_fields__
            }
            return type(value)(**parts)
        case _:
            return value


def placed(finding: Diagnostic) -> str:
    """Return the message of a diagnostic behind its place."""
    if finding.span is None or not finding.span.file:
        return finding.message
    return f"{finding.span.file}:{finding.span.line}: {finding.message}"


def explained(error: BaseException) -> str:
    """Return the reason of an error for people, each diagnostic once."""
    if isinstance(error, InputError):
        return "; ".join(dict.fromkeys(map(placed, error.diagnostics)))
    if isinstance(error, ToolError):
        return ": ".join(filter(None, (error.message, error.hint)))
    return described(error)
