"""From the bytes of a CDL file to text: UTF-8, EUC-JP and Shift_JIS.

Only comments and strings may contain other characters than ASCII. In Shift_JIS the second byte of a
character can be a backslash or a brace, so the text is decoded before lexing.
"""

from __future__ import annotations

import codecs
import re

NAMES = ("auto", "euc", "sjis", "utf8", "none")
"""The supported encodings; `none` maps each byte to one character."""

_CODECS = {"euc": "euc_jp", "sjis": "cp932", "utf8": "utf-8", "none": "latin-1"}
_TITLES = {"euc": "EUC-JP", "sjis": "Shift_JIS", "utf8": "UTF-8"}
_FORMS = {
    "euc": re.compile(
        rb"(?:[\x00-\x7f]++|(?:[\xa1-\xfe]{2})++|\x8e[\xa1-\xdf]|\x8f[\xa1-\xfe]{2})*+"
    ),
    "sjis": re.compile(
        rb"(?:[\x00-\x7f\xa1-\xdf]++|[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc])*+"
    ),
}
_KANA = re.compile("[\u3040-\u30ff]")
_HALF_WIDTH = re.compile("[\uff61-\uff9f]")


def decode(data: bytes, encoding: str) -> tuple[str, str | None]:
    """Return the text of a file, and a doubt about its encoding or None."""
    if data.startswith(codecs.BOM_UTF8):
        encoding = "utf8"
    if encoding == "auto":
        encoding, doubt = _detected(data)
        return _text(data, encoding), doubt
    if not _fits(data, encoding):
        found, _ = _detected(data)
        return (
            _text(data, found),
            f"the file is not {_TITLES[encoding]}; read as {_TITLES.get(found, 'bytes')}",
        )
    return _text(data, encoding), None


def codec(data: bytes, encoding: str) -> str:
    """Return Python's name of the encoding that `decode` uses for a file."""
    if data.startswith(codecs.BOM_UTF8):
        encoding = "utf8"
    if encoding == "auto" or not _fits(data, encoding):
        encoding, _ = _detected(data)
    return _CODECS[encoding]


def _fits(data: bytes, encoding: str) -> bool:
    if encoding in _FORMS:
        return _FORMS[encoding].fullmatch(data) is not None
    try:
        data.decode(_CODECS[encoding])
    except UnicodeDecodeError:
        return False
    return True


def _text(data: bytes, encoding: str) -> str:
    return data.decode(_CODECS[encoding], errors="replace")


def _detected(data: bytes) -> tuple[str, str | None]:
    if data.isascii() or _fits(data, "utf8"):
        return "utf8", None
    possible = [encoding for encoding in ("euc", "sjis") if _fits(data, encoding)]
    if not possible:
        return "none", "the file is neither UTF-8 nor EUC-JP nor Shift_JIS"
    return max(possible, key=lambda encoding: _likely(_text(data, encoding))), None


def _likely(text: str) -> int:
    """Return a score for how likely a text is correctly decoded Japanese."""
    doubtful = len(_HALF_WIDTH.findall(text)) + 4 * text.count("\ufffd")
    return len(_KANA.findall(text)) - 2 * doubtful
