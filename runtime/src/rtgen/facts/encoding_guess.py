"""Guesses the encoding of a file by the likelihood of its text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby
from typing import Final

from rtgen.facts.decoded_text import (
    TITLES,
    Decoded,
    fits,
    read,
    uniform,
    with_line_feeds,
)
from rtgen.facts.text_likelihood import cost_of_japanese, cost_of_latin, cost_of_utf8

_SAMPLE: Final = 256 * 1024
"""Number of octets by which a file is judged; a larger one is not read line by line."""
_PRIOR: Final = 10.0
"""How much likelier UTF-8 is than another encoding, in bits."""
_DAMAGE: Final = 30.0
"""Cost of a file that no encoding fits, in bits."""
_CLEAR: Final = 6.0
"""A reading is certain if the next one costs so many bits more."""
_NOT_ASCII: Final = re.compile(rb"[\x80-\xff]")
_THREE_OCTETS: Final = re.compile(rb"[\xe1-\xef][\x80-\xbf]{2}")
_LINES: Final = re.compile(rb"[^\n\r]*[\n\r]+|[^\n\r]+")


def asked(data: bytes, encoding: str) -> Decoded:
    """Read a file in the encoding that was asked for, if that fits."""
    guess = guessed(data)
    if not fits(data, encoding):
        doubt = f"the file is not {TITLES[encoding]}; read as {guess.title}"
        return replace(guess, doubt=doubt)
    read = uniform(data, encoding)
    if encoding == "none" or guess.encoding in ("none", encoding):
        return read
    sample = _sample(data)
    costs = [_cost(uniform(sample, each)) for each in (guess.encoding, encoding)]
    if costs[0] + 2 * _PRIOR > costs[1]:
        return read
    doubt = f"the file looks like {guess.title}; read as {read.title}, as asked for"
    return replace(read, doubt=doubt)


def guessed(data: bytes) -> Decoded:
    """Read a file in the encoding that gives the most likely text."""
    sample = _sample(data)
    if sample is data:
        return _likeliest(data)
    if fits(data, "utf8"):
        return uniform(data, "utf8")
    guess = _likeliest(sample)
    if fits(data, guess.encoding):
        return replace(uniform(data, guess.encoding), doubt=guess.doubt)
    doubt = f"some octets are not {guess.title}, as others are"
    return replace(uniform(data, guess.encoding), doubt=doubt)


def _sample(data: bytes) -> bytes:
    """Return some lines of a large file, from the first one that is not ASCII."""
    match = _NOT_ASCII.search(data)
    if len(data) <= _SAMPLE or match is None:
        return data
    start = data.rfind(b"\n", 0, match.start()) + 1
    start = max(start, match.start() - _SAMPLE // 2)
    end = data.rfind(b"\n", match.end(), start + _SAMPLE) + 1
    return data[start : end or start + _SAMPLE]


def _likeliest(data: bytes) -> Decoded:
    fitting = [each for each in ("utf8", "sjis", "euc") if fits(data, each)]
    if fitting == ["utf8"] or ("utf8" in fitting and _is_latin(data.decode())):
        return uniform(data, "utf8")
    readings = [uniform(data, encoding) for encoding in (*fitting, "none")]
    # Two octets of half-width kana are UTF-8 by chance: no reason to divide a file that fits.
    if "utf8" not in fitting and (not fitting or _has_clear_utf8(data)):
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


def _is_latin(text: str) -> bool:
    """Return whether a text has letters and signs of western Europe alone, such as a unit: few as
    they are, they are likelier than kanji that have the same octets.
    """
    return all(character < "\u0100" for character in text)


def _has_clear_utf8(data: bytes) -> bool:
    """Return whether a line is UTF-8 with a character of three octets."""
    lines = (line for line in _LINES.findall(data) if _THREE_OCTETS.search(line))
    return any(fits(line, "utf8") for line in lines)


def _cost(reading: Decoded) -> float:
    """Return the cost of a reading in bits; the least is the most likely."""
    cost = _DAMAGE if reading.doubt is not None else 0.0
    for encoding, part in reading.parts:
        text = read(part, encoding)
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
    others = b"".join(line for line in lines if not fits(line, "utf8"))
    readings = [uniform(others, each) for each in ("sjis", "euc", "none")]
    second = min(readings, key=_cost).encoding
    encodings = ["utf8" if fits(line, "utf8") else second for line in lines]
    parts = tuple(
        (encoding, b"".join(line for _, line in group))
        for encoding, group in groupby(
            zip(encodings, lines, strict=True), key=lambda each: each[0]
        )
    )
    text = "".join(read(octets, encoding) for encoding, octets in parts)
    numbered = [*zip(encodings, lines, strict=True)]
    if all(line.isascii() for encoding, line in numbered if encoding == "utf8"):
        doubt = f"some octets are not {TITLES[second]}, as others are"
        return Decoded(text, second, parts, doubt=doubt, line=_odd_line(numbered))
    doubt = f"this line is not UTF-8, as others are; read as {TITLES[second]}"
    return Decoded(text, "utf8", parts, doubt=doubt, line=_odd_line(numbered, second))


def damaged(data: bytes) -> Decoded:
    """Read a file that is not UTF-8 though it should be."""
    if len(data) <= _SAMPLE:
        return _mixed(data)
    return replace(uniform(data, "utf8"), doubt="some octets are not UTF-8")


def _odd_line(lines: Iterable[tuple[str, bytes]], odd: str | None = None) -> int:
    """Return the number of the first line in an encoding, or that does not fit its own."""
    number = 1
    for encoding, line in lines:
        if encoding == odd or not fits(line, encoding):
            return number
        number += with_line_feeds(line.decode("latin-1")).count("\n")
    return 1
