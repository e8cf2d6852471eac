"""Texts that CDR cannot hold: with NUL, or with octets of file names that are not UTF-8."""

from __future__ import annotations

import re
from typing import Any, Final

import msgspec

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
