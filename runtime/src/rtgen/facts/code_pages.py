"""Tables of Shift_JIS, EUC-JP and Windows-1252.

Shift_JIS is Microsoft's code page 932, and EUC-JP has the same characters, so that a text is the
same in each encoding. Windows-1252 has a character for each octet: control characters where
Microsoft's table has none.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable
from typing import Final

_MAX_JOINED: Final = 256 * 1024
"""Maximum size of a text in Windows-1252 that is searched for characters of Shift_JIS."""
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
CHARACTERS: Final = {
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


def strict(data: bytes, encoding: str) -> str:
    """Return the text of octets. Raises UnicodeDecodeError."""
    if encoding == "none":
        return _of_windows(data)
    if encoding == "euc":
        return data.decode("euc_jp", _MICROSOFT).translate(_TO_MICROSOFT)
    text = data.decode("cp932")
    if (odd := _NOT_SJIS.search(text)) is not None:
        start = len(text[: odd.start()].encode("cp932"))
        raise UnicodeDecodeError("cp932", data, start, start + 1, "no character")
    return text


def read(data: bytes, encoding: str) -> str:
    """Return the text of octets, with characters of Windows-1252 for those that do not fit."""
    try:
        return strict(data, encoding)
    except UnicodeDecodeError:
        text = data.decode(_CODECS[encoding], _LENIENT + encoding)
        return text.translate(_TO_MICROSOFT if encoding == "euc" else _STRAY)


def _of_windows(data: bytes) -> str:
    """Return the text of octets in Windows-1252, without backslashes in characters of Shift_JIS."""
    if len(data) > _MAX_JOINED or not _IN_WINDOWS.search(data):
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
    return text.encode("cp932")


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
