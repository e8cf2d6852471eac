"""The characters of a file, with the encoding in which they stand in it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
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

_UNICODE: Final = {"utf8": "utf-8", "utf-16-le": "utf-16-le", "utf-16-be": "utf-16-be"}
"""Python's names of the encodings that need no tables of their own."""
_LONE_RETURN: Final = re.compile(r"\r(?!\n)")
_LINE_END: Final = re.compile(r"\r\n?")

Parts: TypeAlias = tuple[tuple[str, bytes], ...]
"""The octets of a file in order, each part with its encoding."""


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
        match = _LONE_RETURN.search(self.text) if "\r" in self.text else None
        if match is None:
            return None
        return match.start() - self.text.count("\r\n", 0, match.start())

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

        octets_of = {chr(code): bytes((code,)) for code in range(128)}
        several = set()
        for encoding, part in self.parts:
            for match in CHARACTERS[encoding].finditer(part):
                octets = match[0]
                character = read(octets, encoding)
                if octets_of.setdefault(character, octets) != octets:
                    several.add(character)
        return {c: octets for c, octets in octets_of.items() if c not in several}


def with_line_feeds(text: str) -> str:
    """Return a text with a line feed as its only line end, also for a lone carriage return."""
    return _LINE_END.sub("\n", text) if "\r" in text else text


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
