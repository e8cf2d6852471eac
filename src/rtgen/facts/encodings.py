"""Encodings of text files: which characters the octets of a file are.

A byte-order mark decides, then the encoding that was asked for. Without both, a file is UTF-8 if it
can be, else Shift_JIS or EUC-JP, whichever gives more likely text, else Windows-1252. Shift_JIS is
Microsoft's code page 932, and EUC-JP has the same characters, so that a text is the same in each
encoding. If no encoding fits the whole file, its lines are read one by one.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from itertools import groupby
from typing import Final, TypeAlias

from rtgen.facts.text_likelihood import cost_of_japanese, cost_of_latin, cost_of_utf8

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
_SAMPLE: Final = 256 * 1024
"""Number of octets by which a file is judged; a larger one is not read line by line."""
_PRIOR: Final = 10.0
"""How much likelier UTF-8 is than another encoding, in bits."""
_DAMAGE: Final = 30.0
"""Cost of a file that no encoding fits, in bits."""
_CLEAR: Final = 6.0
"""A reading is certain if the next one costs so many bits more."""

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
MARKS: Final = tuple(mark for mark, _ in _MARKS)
"""The byte-order marks."""
_NOT_ASCII: Final = re.compile(rb"[\x80-\xff]")
_LINES: Final = re.compile(rb"[^\n\r]*[\n\r]+|[^\n\r]+")
_WINDOWS: Final = "".join(
    bytes((octet,)).decode("cp1252", "ignore") or chr(octet) for octet in range(256)
)
_TO_WINDOWS: Final = codecs.charmap_build(_WINDOWS)
_IN_WINDOWS: Final = re.compile(rb"([\x81-\x9f\xe0-\xfc]\\)(?=[ \t]*(?:[\r\n]|\Z))")
"""A character of Shift_JIS whose second octet is a backslash, at the end of a line."""
_NOT_SJIS: Final = re.compile("[\x80\xa0\uf8f0-\uf8f3]")
"""Characters of cp932 for octets that Shift_JIS does not have."""
_PAIRS: Final = {
    "euc": re.compile(rb"[\xa1-\xfe]{2}"),
    "sjis": re.compile(rb"[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc]"),
}
_CODECS: Final = {"euc": "euc_jp", "sjis": "cp932"}
_CHARACTERS: Final = {
    "euc": re.compile(rb"\x8f[\xa1-\xfe]{2}|\x8e[\xa1-\xdf]|[\xa1-\xfe]{2}|[^\n]|\n"),
    "sjis": re.compile(rb"[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc]|[^\n]|\n"),
    "utf8": re.compile(rb"[\xc2-\xf4][\x80-\xbf]{1,3}|[^\n]|\n"),
    "none": re.compile(rb"%b|[^\n]|\n" % _IN_WINDOWS.pattern),
}
"""The octets of one character."""
_TO_MICROSOFT: Final = {
    0x301C: 0xFF5E,
    0x2016: 0x2225,
    0x2212: 0xFF0D,
    0x00A2: 0xFFE0,
    0x00A3: 0xFFE1,
    0x00AC: 0xFFE2,
}
"""The characters of JIS X 0208 that cp932 and Python's EUC-JP map differently."""
_FROM_MICROSOFT: Final = {new: old for old, new in _TO_MICROSOFT.items()}
_STRAY: Final = {0x80: "€", **dict(zip(range(0xF8F0, 0xF8F4), "\xa0ýþÿ", strict=True))}
"""Characters of Windows-1252 for those of `_NOT_SJIS`."""
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
        found = {chr(code): bytes((code,)) for code in range(128)}
        several = set()
        for encoding, part in self.parts:
            for match in _CHARACTERS[encoding].finditer(part):
                octets = match[0]
                character = _read(octets, encoding)
                if found.setdefault(character, octets) != octets:
                    several.add(character)
        return {c: octets for c, octets in found.items() if c not in several}


def digest(data: bytes) -> str:
    """Return the SHA-256 of a text file in hexadecimal, the same for each kind of line end."""
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
        return _uniform(data, data.encoding)
    for mark, of_mark in _MARKS:
        if data.startswith(mark):
            return _marked(data[len(mark) :], of_mark, mark)
    if data.isascii():
        return _uniform(data, "utf8" if encoding == "auto" else encoding)
    if standard and _fits(data, "utf8"):
        return _uniform(data, "utf8")
    if encoding == "auto":
        return _guessed(data)
    return _asked(data, encoding)


def labelled(data: bytes, label: str) -> str:
    """Return the text of a file that declares its encoding, without a byte-order mark.

    `label` is the name of the encoding in the declaration, as of XML and Python. Raises LookupError
    for an unknown one, UnicodeDecodeError for octets that do not fit it.
    """
    known = encoding_of(label)
    text = _strict(data, known) if known else data.decode(label)
    return text.removeprefix("\ufeff")


def encoding_of(label: str) -> str | None:
    """Return the key of TITLES for a declared name; None for another encoding."""
    name = label.strip().lower().replace("_", "-")
    if name in ("utf-8", "utf8"):
        return "utf8"
    return next((k for k, labels in _LABELS.items() if name in labels.split()), None)


def _marked(body: bytes, encoding: str, mark: bytes) -> Decoded:
    """Read a file with a byte-order mark."""
    if _fits(body, encoding):
        return replace(_uniform(body, encoding), mark=mark)
    if encoding == "utf8" and len(body) <= _SAMPLE:
        return replace(_mixed(body), mark=mark)
    doubt = f"the file is not {TITLES[encoding]}, as its byte-order mark says"
    return replace(_uniform(body, encoding), mark=mark, doubt=doubt)


def _asked(data: bytes, encoding: str) -> Decoded:
    """Read a file in the encoding that was asked for, if that fits."""
    guess = _guessed(data)
    if not _fits(data, encoding):
        doubt = f"the file is not {TITLES[encoding]}; read as {guess.title}"
        return replace(guess, doubt=doubt)
    read = _uniform(data, encoding)
    if encoding == "none" or guess.encoding in ("none", encoding):
        return read
    sample = _sample(data)
    costs = [_cost(_uniform(sample, each)) for each in (guess.encoding, encoding)]
    if costs[0] + 2 * _PRIOR > costs[1]:
        return read
    doubt = f"the file looks like {guess.title}; read as {read.title}, as asked for"
    return replace(read, doubt=doubt)


def _guessed(data: bytes) -> Decoded:
    """Read a file in the encoding that gives the most likely text."""
    sample = _sample(data)
    if sample is data:
        return _likeliest(data)
    if _fits(data, "utf8"):
        return _uniform(data, "utf8")
    guess = _likeliest(sample)
    if _fits(data, guess.encoding):
        return replace(_uniform(data, guess.encoding), doubt=guess.doubt)
    doubt = f"some octets are not {guess.title}, as others are"
    return replace(_uniform(data, guess.encoding), doubt=doubt)


def _sample(data: bytes) -> bytes:
    """Return some lines of a large file, from the first one that is not ASCII."""
    found = _NOT_ASCII.search(data)
    if len(data) <= _SAMPLE or found is None:
        return data
    start = data.rfind(b"\n", 0, found.start()) + 1
    start = max(start, found.start() - _SAMPLE // 2)
    end = data.rfind(b"\n", found.end(), start + _SAMPLE) + 1
    return data[start : end or start + _SAMPLE]


def _likeliest(data: bytes) -> Decoded:
    fitting = [each for each in ("utf8", "sjis", "euc") if _fits(data, each)]
    if fitting == ["utf8"]:
        return _uniform(data, "utf8")
    readings = [_uniform(data, encoding) for encoding in (*fitting, "none")]
    if "utf8" not in fitting:
        readings.append(_mixed(data))
    ranked = sorted((_cost(each), number) for number, each in enumerate(readings))
    best = readings[ranked[0][1]]
    if best.doubt is not None:
        return best
    if best.encoding == "none":
        doubt = (
            "the file is neither UTF-8 nor EUC-JP nor Shift_JIS; read as Windows-1252"
        )
        return replace(best, doubt=doubt)
    others = [
        readings[number]
        for cost, number in ranked[1:]
        if cost < ranked[0][0] + _CLEAR and readings[number].encoding != "none"
    ]
    if not others or others[0].doubt is not None:
        return best
    doubt = f"the file may be {best.title} or {others[0].title}; read as {best.title}"
    return replace(best, doubt=doubt)


def _cost(reading: Decoded) -> float:
    """Return the cost of a reading in bits; the least is the most likely."""
    cost = _DAMAGE if reading.doubt is not None else 0.0
    for encoding, part in reading.parts:
        text = _read(part, encoding)
        if encoding == "utf8":
            cost += cost_of_utf8(text)
        elif encoding == "none":
            cost += cost_of_latin(text)
        else:
            cost += cost_of_japanese(text, sjis=encoding == "sjis")
    is_utf8 = reading.encoding == "utf8" and reading.doubt is None
    return cost - (_PRIOR if is_utf8 else 0.0)


def _mixed(data: bytes) -> Decoded:
    """Read line by line: as UTF-8, else in the encoding that is best for the other lines."""
    lines = [*_LINES.findall(data)]
    others = b"".join(line for line in lines if not _fits(line, "utf8"))
    readings = [_uniform(others, each) for each in ("sjis", "euc", "none")]
    second = min(readings, key=_cost).encoding
    encodings = ["utf8" if _fits(line, "utf8") else second for line in lines]
    parts = tuple(
        (encoding, b"".join(line for _, line in group))
        for encoding, group in groupby(
            zip(encodings, lines, strict=True), key=lambda each: each[0]
        )
    )
    text = "".join(_read(octets, encoding) for encoding, octets in parts)
    numbered = [*zip(encodings, lines, strict=True)]
    if all(line.isascii() for encoding, line in numbered if encoding == "utf8"):
        doubt = f"some octets are not {TITLES[second]}, as others are"
        return Decoded(text, second, parts, doubt=doubt, line=_odd_line(numbered))
    doubt = f"this line is not UTF-8, as others are; read as {TITLES[second]}"
    return Decoded(text, "utf8", parts, doubt=doubt, line=_odd_line(numbered, second))


def _odd_line(lines: Iterable[tuple[str, bytes]], odd: str | None = None) -> int:
    """Return the number of the first line in an encoding, or that does not fit its own."""
    number = 1
    for encoding, line in lines:
        if encoding == odd or not _fits(line, encoding):
            return number
        number += with_line_feeds(line.decode("latin-1")).count("\n")
    return 1


def _uniform(data: bytes, encoding: str) -> Decoded:
    return Decoded(_read(data, encoding), encoding, ((encoding, data),))


def _fits(data: bytes, encoding: str) -> bool:
    try:
        _strict(data, encoding)
    except UnicodeDecodeError:
        return False
    return True


def _strict(data: bytes, encoding: str) -> str:
    """Return the text of octets. Raises UnicodeDecodeError."""
    if encoding == "none":
        return _of_windows(data)
    if encoding == "euc":
        return data.decode("euc_jp", _MICROSOFT).translate(_TO_MICROSOFT)
    if encoding != "sjis":
        return data.decode("utf-8" if encoding == "utf8" else encoding)
    text = data.decode("cp932")
    if (odd := _NOT_SJIS.search(text)) is not None:
        start = len(text[: odd.start()].encode("cp932"))
        raise UnicodeDecodeError("cp932", data, start, start + 1, "no character")
    return text


def _read(data: bytes, encoding: str) -> str:
    """Return the text of octets, with characters of Windows-1252 for those that do not fit."""
    try:
        return _strict(data, encoding)
    except UnicodeDecodeError:
        if encoding in _CODECS:
            text = data.decode(_CODECS[encoding], _LENIENT + encoding)
            return text.translate(_TO_MICROSOFT if encoding == "euc" else _STRAY)
        return data.decode("utf-8" if encoding == "utf8" else encoding, "replace")


def _of_windows(data: bytes) -> str:
    """Return the text of octets in Windows-1252, without backslashes in characters of Shift_JIS."""
    if len(data) > _SAMPLE or not _IN_WINDOWS.search(data):
        return codecs.charmap_decode(data, "strict", _WINDOWS)[0]
    parts = _IN_WINDOWS.split(data)
    parts_read = [codecs.charmap_decode(part, "strict", _WINDOWS)[0] for part in parts]
    parts_read[1::2] = [pair.decode("cp932", "replace") for pair in parts[1::2]]
    return "".join(parts_read)


def encoded(text: str, encoding: str) -> bytes:
    """Return the octets of a text. Raises UnicodeEncodeError."""
    if encoding == "none":
        return codecs.charmap_encode(text, "strict", _TO_WINDOWS)[0]
    if encoding == "euc":
        return text.translate(_FROM_MICROSOFT).encode("euc_jp")
    return text.encode({"sjis": "cp932", "utf8": "utf-8"}.get(encoding, encoding))


def _pair_of_microsoft(error: UnicodeError) -> tuple[str, int]:
    """Decode two octets of EUC-JP that only Microsoft's table has (NEC's row 13, IBM's rows)."""
    assert isinstance(error, UnicodeDecodeError)
    data, start = error.object, error.start
    if not _PAIRS["euc"].match(data, start):
        raise error
    row, cell = data[start] - 0xA1, data[start + 1] - 0xA1
    lead = (row >> 1) + (0x81 if row < 62 else 0xC1)
    trail = cell + (0x9F if row & 1 else 0x40 if cell < 63 else 0x41)
    try:
        return bytes((lead, trail)).decode("cp932"), start + 2
    except UnicodeDecodeError:
        raise error from None


def _lenient(encoding: str) -> Callable[[UnicodeError], tuple[str, int]]:
    """Return an error handler: a pair that has no character, or an octet of Windows-1252."""

    def handler(error: UnicodeError) -> tuple[str, int]:
        assert isinstance(error, UnicodeDecodeError)
        data, start = error.object, error.start
        if not _PAIRS[encoding].match(data, start):
            return _WINDOWS[data[start]], start + 1
        try:
            return (
                _pair_of_microsoft(error) if encoding == "euc" else _no_character(start)
            )
        except UnicodeDecodeError:
            return _no_character(start)

    return handler


def _no_character(start: int) -> tuple[str, int]:
    return "\ufffd", start + 2


_MICROSOFT: Final = "rtgen-microsoft"
_LENIENT: Final = "rtgen-lenient-"
codecs.register_error(_MICROSOFT, _pair_of_microsoft)
for _encoding in _PAIRS:
    codecs.register_error(_LENIENT + _encoding, _lenient(_encoding))
