"""Encodings of text files: which characters the octets of a file are.

A byte-order mark decides, then the encoding that was asked for. Without both, a file is UTF-8 if it
can be, else Shift_JIS or EUC-JP, whichever gives more likely text, else Windows-1252. If no
encoding fits the whole file, its lines are read one by one.
"""

from __future__ import annotations

import codecs
from dataclasses import replace
from typing import Final

from rtgen.facts.decoded_text import TITLES, Decoded, fits, strict, uniform

_LABELS: Final = {
    "euc": "euc-jp eucjp x-euc-jp eucjp-ms ujis cp51932",
    "sjis": (
        "shift-jis shiftjis sjis s-jis x-sjis ms-kanji csshiftjis windows-31j cswindows31j"
        " cp932 ms932 x-ms932 mskanji 932"
    ),
}
_MARKS: Final = (
    (codecs.BOM_UTF8, "utf8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
MARKS: Final = tuple(mark for mark, _ in _MARKS)
"""The byte-order marks."""


class Encoded(bytes):
    """Octets whose encoding is known, such as an unsaved text; without a byte-order mark."""

    encoding: str

    def __new__(cls, data: bytes, encoding: str = "utf8") -> Encoded:
        """Mark octets with their encoding, a key of `decoded_text.TITLES`."""
        encoded = super().__new__(cls, data)
        encoded.encoding = encoding
        return encoded


def digest(data: bytes) -> str:
    """Return the SHA-256 of a text file in hexadecimal, the same for each kind of line end."""
    from hashlib import sha256

    return sha256(data.replace(b"\r\n", b"\n")).hexdigest()


def decode(data: bytes, encoding: str = "auto", *, standard: bool = False) -> Decoded:
    """Return the characters of a file.

    `encoding`, one of `decoded_text.NAMES`, is the one asked for. `standard`: the format of the
    file demands UTF-8, so that another encoding is only used if the file is not.
    """
    if isinstance(data, Encoded):
        return uniform(data, data.encoding)
    for mark, of_mark in _MARKS:
        if data.startswith(mark):
            return _marked(data[len(mark) :], of_mark, mark)
    if data.isascii():
        return uniform(data, "utf8" if encoding == "auto" else encoding)
    if standard and fits(data, "utf8"):
        return uniform(data, "utf8")
    # The tables are imported only if they are needed.
    from rtgen.facts import encoding_guess

    if encoding == "auto":
        return encoding_guess.guessed(data)
    return encoding_guess.asked(data, encoding)


def labelled(data: bytes, label: str) -> str:
    """Return the text of a file that declares its encoding, without a byte-order mark.

    `label` is the name of the encoding in the declaration, as of XML and Python. Raises LookupError
    for an unknown one, UnicodeDecodeError for octets that do not fit it.
    """
    encoding = encoding_of(label)
    text = strict(data, encoding) if encoding else data.decode(label)
    return text.removeprefix("\ufeff")


def encoding_of(label: str) -> str | None:
    """Return the key of TITLES for a declared name; None for another encoding."""
    name = label.strip().lower().replace("_", "-")
    if name in ("utf-8", "utf8"):
        return "utf8"
    return next((k for k, labels in _LABELS.items() if name in labels.split()), None)


def _marked(body: bytes, encoding: str, mark: bytes) -> Decoded:
    """Read a file with a byte-order mark."""
    if fits(body, encoding):
        return replace(uniform(body, encoding), mark=mark)
    if encoding == "utf8":
        from rtgen.facts import encoding_guess

        return replace(encoding_guess.damaged(body), mark=mark)
    doubt = f"the file is not {TITLES[encoding]}, as its byte-order mark says"
    return replace(uniform(body, encoding), mark=mark, doubt=doubt)
