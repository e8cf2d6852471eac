"""How likely a reading of octets is: its cost in bits, by the kinds and the order of characters.

Only differences between readings of the same octets have a meaning. The costs are round numbers for
the frequencies of characters in comments of Japanese and European sources (JIS X 0208, JIS X 0201).
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Final

_RUN: Final = re.compile(r"[A-Za-z]?[^\x00-\x7f]+[A-Za-z]?")
_WHOLE: Final = re.compile(r"[^\x00-\x7f]+")
_LETTER: Final = r"[À-ÖÙ-öù-ÿĀ-\u017f]"
_ADJACENT: Final = re.compile(
    rf"[^\x00-\x7f](?=[^\x00-\x7f])(?!(?<={_LETTER}){_LETTER}[A-Za-z])"
)
_START: Final = 4.0
"""Cost of the first of several characters that are not ASCII."""
_BAD: Final = 30.0
_ASCII_OCTET: Final = 4.5
"""Cost of a character of ASCII, which a second octet below 80h would be otherwise."""

_FREQUENT_SIGNS: Final = (
    "、。・ー「」（）：；，．！？\u3000～→←↑↓…％＋－＝／"  # noqa: RUF001
)
_FREQUENT_KANA: Final = "ｰﾞﾝｽﾄﾙｯﾟﾀｲﾗﾘｸｼﾌｱﾃｺ"
_USUAL_KANA: Final = "ｾﾚﾁｶﾊｴｷﾒｵﾑﾌﾏｻﾅﾛﾂｬﾃﾈｪﾆｬｨｳｭｼｮﾓ"
_MIXED: Final = re.compile(
    r"[\uff61-\uff9f](?=[^\x00-\x7f\uff61-\uff9f])"
    r"|(?<=[^\x00-\x7f\uff61-\uff9f])[\uff61-\uff9f]"
)
_ODD_KANA: Final = re.compile(
    "(?<![ｦ-ﾟ])[ｧ-ｯｰﾞﾟ]|(?<![ｳｶ-ﾄﾊ-ﾎ])ﾞ|(?<![ﾊ-ﾎ])ﾟ|(?<![ｷｼﾁﾆﾋﾐﾘﾃﾌﾞﾟ])[ｬｭｮ]"
    "|(?<![ﾌﾃｳｼﾁﾂﾄｸｲﾞﾟ])[ｧｨｩｪｫ]|(?<=[ﾝｯｰ])ｰ|(?<=ﾝ)[ﾝｯ]|ｯ(?![ｶ-ﾄﾊ-ﾎｰ])|ｦ"
)
"""Half-width kana where no Japanese word has them."""
_KANA: Final = re.compile(r"[\uff61-\uff9f]+")
_ONE_KANA: Final = re.compile(r"(?<![^\x00-\x7f])[\uff61-\uff9f](?![^\x00-\x7f])")
_IN_A_WORD: Final = re.compile(r"(?<=[A-Za-z])[^\x00-\x7f\uff61-\uff9f](?=[A-Za-z])")

_FREQUENT_LETTERS: Final = "äöüßÄÖÜéèêàâçñîôûóúíáåæøÅÆ"
_LATIN_SIGNS: Final = "°Øµ±²³·×÷§©®™€£«»–—‘’“”„…•½¼¾¹ºª¿¡¶\xa0"  # noqa: RUF001
_IN_WORDS: Final = re.compile(rf"(?<=[A-Za-z]){_LETTER}|{_LETTER}(?=[A-Za-z])")
_OUTSIDE: Final = re.compile(  # except words of one letter
    rf"(?<![A-Za-z\x80-\u024f])(?![àèéòóÀÈÉ]){_LETTER}(?![A-Za-z\x80-\u024f])"
)


class _Japanese(dict[str, float]):
    """The cost of a character in a text that is read as EUC-JP or Shift_JIS."""

    def __init__(self, codec: str) -> None:
        self._codec = codec

    def __missing__(self, character: str) -> float:
        cost = _japanese(character)
        if self._codec == "cp932":
            octets = character.encode("cp932", "ignore")
            if len(octets) == 2 and octets[1] < 0x80:
                cost -= _ASCII_OCTET
        self[character] = cost
        return cost


def _japanese(character: str) -> float:
    code = ord(character)
    if character < "\x80":
        return 0.0
    if character in _FREQUENT_SIGNS:
        return 8.0
    if 0x3041 <= code <= 0x3093:
        return 7.0
    if 0x30A1 <= code <= 0x30F6:
        return 8.0
    if 0xFF66 <= code <= 0xFF9F:
        if character in _FREQUENT_KANA:
            return 5.0
        return 7.0 if character in _USUAL_KANA else 8.5
    if 0xFF61 <= code <= 0xFF65:
        return 9.0
    if 0xFF01 <= code <= 0xFF5E:
        return 10.5
    if code < 0xA0 or 0xE000 <= code <= 0xF8FF or code == 0xFFFD:
        return _BAD
    return _of_a_table(character.encode("euc_jp", "ignore"))


def _of_a_table(octets: bytes) -> float:
    """Return the cost of another character by its place in JIS X 0208."""
    if len(octets) != 2:
        return 24.0
    row = octets[0] - 0xA0
    if row < 16:
        return 12.0 if row in (1, 2, 8) else 15.0
    return 12.5 if row < 48 else 20.0


_SJIS: Final = _Japanese("cp932")
_EUC: Final = _Japanese("euc_jp")


class _Latin(dict[str, float]):
    """The cost of a character in a European text."""

    def __missing__(self, character: str) -> float:
        code = ord(character)
        if code < 0x80:
            cost = 0.0
        elif character in _FREQUENT_LETTERS:
            cost = 8.0
        elif character in _LATIN_SIGNS:
            cost = 9.5
        elif code < 0xA0:
            cost = _BAD
        elif code < 0x100:
            cost = 11.0 if character.isalpha() else 13.0
        else:
            cost = 13.0
        self[character] = cost
        return cost


_LATIN: Final = _Latin()


class _Any(dict[str, float]):
    """The cost of a character in a text of any script, as UTF-8 can hold."""

    def __missing__(self, character: str) -> float:
        code = ord(character)
        if 0x3000 <= code < 0xA000 or 0xFF00 <= code < 0xFFF0:
            cost = _japanese(character)
        elif code < 0x100 or 0x2000 <= code < 0x2700:
            cost = _LATIN[character]
        else:
            cost = 8.0 if character.isalpha() else 20.0
        self[character] = cost
        return cost


_ANY: Final = _Any()


def _runs(text: str) -> str:
    """Return the runs that are not ASCII, one a line, with a letter before and after."""
    return "\n".join(_RUN.findall(text))


def _count(pattern: re.Pattern[str], text: str) -> int:
    return len(pattern.findall(text))


def cost_of_japanese(text: str, *, sjis: bool) -> float:
    """Return the cost of a text that was read as Shift_JIS, or else as EUC-JP."""
    runs = _runs(text)
    cost = _START * _count(_WHOLE, runs)
    cost += sum(map((_SJIS if sjis else _EUC).__getitem__, runs))
    cost += (2.0 if sjis else 4.0) * _count(_KANA, runs)
    cost += 5.0 * _count(_MIXED, runs) + 7.0 * _count(_ODD_KANA, runs)
    return cost + 8.0 * _count(_ONE_KANA, runs) + 3.0 * _count(_IN_A_WORD, runs)


def cost_of_latin(text: str) -> float:
    """Return the cost of a text that was read as Windows-1252."""
    runs = _runs(text)
    adjacent = _count(_ADJACENT, runs)
    cost = 3.0 * _count(_WHOLE, runs) + sum(map(_LATIN.__getitem__, runs))
    return cost + 6.0 * adjacent + _of_letters(runs)


def cost_of_utf8(text: str) -> float:
    """Return the cost of a text that was read as UTF-8."""
    runs = _runs(text)
    changes = sum(
        first >= "\x80" and second >= "\x80" and _script(first) != _script(second)
        for first, second in pairwise(runs)
    )
    cost = 3.0 * _count(_WHOLE, runs) + sum(map(_ANY.__getitem__, runs))
    return cost + 8.0 * changes + _of_letters(runs)


def _of_letters(runs: str) -> float:
    """Return the cost of the places of European letters: in words, or alone."""
    return 8.0 * _count(_OUTSIDE, runs) - 2.0 * _count(_IN_WORDS, runs)


def _script(character: str) -> int:
    code = ord(character)
    if 0x3000 <= code < 0xA000 or 0xFF00 <= code < 0xFFF0:
        return -1
    return -2 if code < 0x180 or 0x2000 <= code < 0x2700 else code >> 7
