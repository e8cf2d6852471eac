"""Encodings of text files: which characters the octets of a file are.

A byte-order mark decides, then the encoding that was asked for. Without both, a file is UTF-8 if it
can be, else Shift_JIS or EUC-JP, whichever gives more likely text, else Windows-1252. If no
encoding fits the whole file, its lines are read one by one.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from typing import Final, TypeAlias

NAMES: Final = ("auto", "euc", "sjis", "utf8", "none")
"""The encodings that can be asked for; `none` is Windows-1252, which has a character for each
octet.
"""

TITLES: Final = {
    "euc": "EUC-JP",
    "sjis": "Shift_JIS",
    "utf8": "UTF-8",
    "none": "Windows-1252",
    "utf-16-le": "UTF-16",
    "utf-16-be": "UTF-16",
}
"""The names of encodings in messages."""

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
_UNICODE: Final = {"utf8": "utf-8", "utf-16-le": "utf-16-le", "utf-16-be": "utf-16-be"}
"""Python's names of the encodings that need no tables of their own."""
_LONE_RETURN: Final = re.compile(r"\r(?!\n)")
_LINE_END: Final = re.compile(r"\r\n?")

Parts: TypeAlias = tuple[tuple[str, bytes], ...]
"""The octets of a file in order, each part with its encoding."""


class Encoded(bytes):
    """Octets whose encoding is known, such as an unsaved text; without a byte-order mark."""

    encoding: str

    def __new__(cls, data: bytes, encoding: str = "utf8") -> Encoded:
        """Mark octets with their encoding, a key of TITLES."""
        made = super().__new__(cls, data)
        made.encoding = encoding
        return made


class NotEncodableError(ValueError):
    """A text that cannot be written in the encoding of its file; the message says why."""


@dataclass(frozen=True)
class Decoded:
    """The characters of a file, without its byte-order mark, and with its line ends.

    `encoding` is a key of TITLES. `doubt` says why the text may be another one, and `line` where,
    from 1.
    """

    text: str
    encoding: str
    parts: Parts
    mark: bytes = b""
    doubt: str | None = None
    line: int = 1

    @property
    def title(self) -> str:
        """The name of the encoding in messages."""
        return TITLES[self.encoding]

    @property
    def normal(self) -> str:
        """The text with a line feed as its only line end."""
        return with_line_feeds(self.text)

    @property
    def lone_return(self) -> int | None:
        """The place in `normal` of the first carriage return without a line feed."""
        found = _LONE_RETURN.search(self.text) if "\r" in self.text else None
        if found is None:
            return None
        return found.start() - self.text.count("\r\n", 0, found.start())

    def encode(self, text: str) -> bytes:
        """Return another text, of characters of this one and of ASCII, as octets of the file.

        Each character keeps the octets that it has in the file. Raises NotEncodableError.
        """
        if text.isascii() and not self.encoding.startswith("utf-16"):
            return self.mark + text.encode()
        if self._is_reversible:
            try:
                return self.mark + encoded(text, self.encoding)
            except UnicodeEncodeError as error:
                character = text[error.start]
                raise NotEncodableError(
                    f"{character!r} is not in {self.title}"
                ) from None
        octets = self._octets
        try:
            return self.mark + b"".join(map(octets.__getitem__, text))
        except KeyError as error:
            message = f"{error.args[0]!r} has no octets in the file, or several"
            raise NotEncodableError(message) from None

    @cached_property
    def _is_reversible(self) -> bool:
        try:
            octets = encoded(self.text, self.encoding)
        except UnicodeEncodeError:
            return False
        return octets == b"".join(part for _, part in self.parts)

    @cached_property
    def _octets(self) -> dict[str, bytes]:
        """The octets of ASCII, and of each character that has the same ones everywhere."""
        from rtgen.facts.code_pages import CHARACTERS

        found = {chr(code): bytes((code,)) for code in range(128)}
        several = set()
        for encoding, part in self.parts:
            for match in CHARACTERS[encoding].finditer(part):
                octets = match[0]
                character = read(octets, encoding)
                if found.setdefault(character, octets) != octets:
                    several.add(character)
        return {c: octets for c, octets in found.items() if c not in several}


def digest(data: bytes) -> str:
    """Return the SHA-256 of a text file in hexadecimal, the same for each kind of line end."""
    from hashlib import sha256

    return sha256(data.replace(b"\r\n", b"\n")).hexdigest()


def with_line_feeds(text: str) -> str:
    """Return a text with a line feed as its only line end, also for a lone carriage return."""
    return _LINE_END.sub("\n", text) if "\r" in text else text


def decode(data: bytes, encoding: str = "auto", *, standard: bool = False) -> Decoded:
    """Return the characters of a file.

    `encoding`, one of NAMES, is the one that was asked for. `standard`: the format of the file
    demands UTF-8, so that another encoding is only used if the file is not.
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
    encoding_guess = import_module("rtgen.facts.encoding_guess")

    if encoding == "auto":
        guessed: Decoded = encoding_guess.guessed(data)
        return guessed
    asked: Decoded = encoding_guess.asked(data, encoding)
    return asked


def labelled(data: bytes, label: str) -> str:
    """Return the text of a file that declares its encoding, without a byte-order mark.

    `label` is the name of the encoding in the declaration, as of XML and Python. Raises LookupError
    for an unknown one, UnicodeDecodeError for octets that do not fit it.
    """
    known = encoding_of(label)
    text = strict(data, known) if known else data.decode(label)
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
        encoding_guess = import_module("rtgen.facts.encoding_guess")
        damaged: Decoded = encoding_guess.damaged(body)
        return replace(damaged, mark=mark)
    doubt = f"the file is not {TITLES[encoding]}, as its byte-order mark says"
    return replace(uniform(body, encoding), mark=mark, doubt=doubt)


def uniform(data: bytes, encoding: str) -> Decoded:
    """Return the characters of octets in an encoding, whether they fit it or not."""
    return Decoded(read(data, encoding), encoding, ((encoding, data),))


def fits(data: bytes, encoding: str) -> bool:
    """Return whether octets are characters of an encoding."""
    try:
        strict(data, encoding)
    except UnicodeDecodeError:
        return False
    return True


def strict(data: bytes, encoding: str) -> str:
    """Return the text of octets in an encoding. Raises UnicodeDecodeError."""
    if encoding in _UNICODE:
        return data.decode(_UNICODE[encoding])
    from rtgen.facts import code_pages

    return code_pages.strict(data, encoding)


def read(data: bytes, encoding: str) -> str:
    """Return the text of octets, with other characters for those that do not fit."""
    if encoding in _UNICODE:
        return data.decode(_UNICODE[encoding], "replace")
    from rtgen.facts import code_pages

    return code_pages.read(data, encoding)


def encoded(text: str, encoding: str) -> bytes:
    """Return the octets of a text. Raises UnicodeEncodeError."""
    if encoding in _UNICODE:
        return text.encode(_UNICODE[encoding])
    from rtgen.facts import code_pages

    return code_pages.encoded(text, encoding)
