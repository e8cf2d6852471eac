"""Folding ranges: bodies, comments, runs of includes, sections and tables."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator

from lsprotocol.types import FoldingRange, FoldingRangeKind

from rtgen.tools.indexing.text import Text
from rtgen.tools.lsp.documents import Language
from rtgen.tools.lsp.workspace import View

_TOKENS = re.compile(
    r"//[^\n]*|/\*.*?(?:\*/|\Z)|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|[{}]",
    re.DOTALL,
)
_INCLUDE = re.compile(
    r"^[ \t]*(?:#[ \t]*include\b|import(?:_C)?[ \t]*\()", re.MULTILINE
)
_HEADER = re.compile(r"^[ \t]*\[", re.MULTILINE)
_TAG = re.compile(r"<!--.*?(?:-->|\Z)|<(/?)([\w:.-]+)[^<>]*?(/?)>", re.DOTALL)


def folding(view: View) -> list[FoldingRange]:
    """Return the folding ranges of the current text."""
    text = view.text
    match view.language:
        case Language.IDL | Language.CDL:
            ranges = [*_braces(text), *_runs(text, _INCLUDE, FoldingRangeKind.Imports)]
        case Language.PROFILE | Language.XDD:
            ranges = [*_tags(text)]
        case _:
            ranges = [*_sections(text)]
    return sorted(ranges, key=lambda f: (f.start_line, f.end_line))


def _line(text: Text, offset: int) -> int:
    return bisect_right(text.whole_lines, offset) - 1


def _braces(text: Text) -> Iterator[FoldingRange]:
    opened: list[int] = []
    run: list[int] = []
    for match in _TOKENS.finditer(text.source):
        token = match[0]
        first = _line(text, match.start())
        if token == "{":
            opened.append(first)
        elif token == "}":
            if opened and (start := opened.pop()) < first - 1:
                yield FoldingRange(start, first - 1)
        elif token.startswith("/*"):
            last = _line(text, match.end())
            if last > first:
                yield FoldingRange(first, last, kind=FoldingRangeKind.Comment)
        elif token.startswith("//"):
            if run and first != run[-1] + 1:
                yield from _comment(run)
                run = []
            run.append(first)
    yield from _comment(run)


def _comment(lines: list[int]) -> Iterator[FoldingRange]:
    if len(lines) > 1:
        yield FoldingRange(lines[0], lines[-1], kind=FoldingRangeKind.Comment)


def _runs(
    text: Text, pattern: re.Pattern[str], kind: FoldingRangeKind
) -> Iterator[FoldingRange]:
    lines = [_line(text, match.end()) for match in pattern.finditer(text.source)]
    start = 0
    for index in range(1, len(lines) + 1):
        if index == len(lines) or lines[index] != lines[index - 1] + 1:
            if lines[index - 1] > lines[start]:
                yield FoldingRange(lines[start], lines[index - 1], kind=kind)
            start = index


def _sections(text: Text) -> Iterator[FoldingRange]:
    """Yield the range from each header in brackets to the last nonempty line before the next."""
    lines = [_line(text, match.end()) for match in _HEADER.finditer(text.source)]
    starts = text.whole_lines
    if not lines:
        return
    for start, following in zip(lines, [*lines[1:], text.lines], strict=True):
        last = following - 1
        while last > start:
            end = starts[last + 1] if last + 1 < len(starts) else len(text.source)
            if text.source[starts[last] : end].strip():
                break
            last -= 1
        if last > start:
            yield FoldingRange(start, last)


def _tags(text: Text) -> Iterator[FoldingRange]:
    opened: list[tuple[str, int]] = []
    for match in _TAG.finditer(text.source):
        first = _line(text, match.start())
        last = _line(text, match.end())
        if match[2] is None:
            if last > first:
                yield FoldingRange(first, last, kind=FoldingRangeKind.Comment)
        elif match[1]:
            while opened:
                name, start = opened.pop()
                if name == match[2]:
                    if first - 1 > start:
                        yield FoldingRange(start, first - 1)
                    break
        elif not match[3]:
            opened.append((match[2], first))
