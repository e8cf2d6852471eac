"""Texts for pages: of errors, in the language of a page, and without what CDR cannot hold.

CDR cannot hold NUL, and octets of file names that are not UTF-8.
"""

from __future__ import annotations

import re
from functools import lru_cache
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


_TEXTS: Final[dict[type, tuple[str, ...]]] = {
    ui.BoardCall: ("error",),
    ui.ClockState: ("reason",),
    ui.Component: ("reason", "silent"),
    ui.EditState: ("undo", "redo"),
    ui.Fit: ("refused",),
    ui.NamingService: ("silent",),
    ui.Notice: ("text",),
    ui.Operation: ("refused",),
    ui.Result: ("message", "hint", "text"),
    ui.StateChange: ("reason",),
    ui.Statistics: ("awaited", "impaired"),
}
"""The members of messages that are texts of rtgen; all others are names and values."""
_WITHOUT: Final = (
    ui.EventKind.EVENT_SAMPLES,
    ui.EventKind.EVENT_FRAMES,
    ui.EventKind.EVENT_TYPES,
)
"""Kinds of events without such texts, which are frequent or large."""


def in_language(event: ui.Event, language: str) -> ui.Event:
    """Return an event with the texts of rtgen in a language, and all else as it is."""
    if event.discriminator in _WITHOUT:
        return event
    if event.discriminator is ui.EventKind.EVENT_END:
        return ui.Event(event.discriminator, _translated(str(event.value), language))
    return ui.Event(event.discriminator, _in_language(event.value, language))


def _in_language(value: Any, language: str) -> Any:
    match value:
        case list():
            return [_in_language(each, language) for each in value]
        case ui.Result() if value.done and value.reply:
            return value  # its text is a value
        case ui.Flow():
            parts = (_translated(each, language) for each in value.details.split(", "))
            return msgspec.structs.replace(value, details="、".join(parts))
        case msgspec.Struct():
            texts = _TEXTS.get(type(value), ())
            changed = {}
            for name in value.__struct_fields__:
                part = getattr(value, name)
                if name in texts:
                    changed[name] = _translated(part, language)
                elif isinstance(part, list | msgspec.Struct):
                    changed[name] = _in_language(part, language)
            return msgspec.structs.replace(value, **changed) if changed else value
        case _:
            return value


@lru_cache(maxsize=2048)
def _translated(text: str, language: str) -> str:
    """Return a text in a language, each line and each of several reasons if it is not one text."""
    if not text:
        return text
    from rtgen.compiler.kit.translation.catalogue import SERVER, catalogue

    texts = catalogue(language, SERVER)
    found = texts.translated(text)
    for separator in ("\n", "; ", ": "):
        if found == text and separator in text:
            found = separator.join(map(texts.translated, text.split(separator)))
    return found


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
