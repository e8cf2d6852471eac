"""Doc comments: assigns comments to declarations, and removes the comment marks.

`/** */`, `/*! */`, `///` and `//!` belong to the declaration that follows, `//` too if it is
directly above. `///<`, `/**<`, and any comment that starts on the line where a declaration ends,
belong to that declaration; a comment in front of another declaration on that line belongs to it.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Sequence

import msgspec

_DOCUMENTING = ("/**", "/*!", "///", "//!")
_TRAILING = ("/**<", "/*!<", "///<", "//!<")
_AFTER = ("//", *_TRAILING)
"""Starts of comments that belong to the declaration before them on their line."""
_NEXT = re.compile(r"[ \t\r]*([^ \t\r]?)")
_OPENING = ("", "{", "(", ":", "[")
_CLOSING = ("", "\n", ";", ",", "}", ")", "]")
_KEY = re.compile(r"//[ \t]*@[Kk]ey[ \t]*(?://.*)?")
_OF_A_FILE = re.compile(r"[\\@]file\b")
_SUPPRESSION = re.compile(r"(?://+|/\*+)[ \t]*rtgen:[ \t]*ignore\[")
"""Comments for `rtgen lint`, which are not documentation."""
_MARK = re.compile(r"//[/!]?<? ?")
_STAR = re.compile(r"^[ \t]*\*(?!/) ?", re.MULTILINE)


class Comment(msgspec.Struct, frozen=True):
    """A comment with its marks, at [start, end) of a text."""

    start: int
    end: int
    text: str


class Docs:
    """Finds the doc comments of declarations in a text whose comments are blanked."""

    def __init__(self, text: str, comments: Sequence[Comment]) -> None:
        self._text = text
        self._comments = comments
        self._starts = [comment.start for comment in comments]
        self._cache: dict[tuple[int, int], str] = {}

    def of(self, start: int, end: int, *inner: int) -> str:
        """Return the doc comment of the declaration at [start, end), with or without `;`.

        `inner`: other places where it begins, such as that behind the labels of a union's case.
        """
        if not self._comments:
            return ""
        text = self._cache.get((start, end))
        if text is None:
            parts = (*map(self._above, (start, *inner)), self._after(end))
            text = self._cache[start, end] = "\n\n".join(filter(None, parts))
        return text

    def say_key(self, end: int) -> bool:
        """Return whether the comment after an entry is `//@key`, as in DDS before annotations."""
        index = bisect_left(self._starts, end)
        if index == len(self._comments):
            return False
        comment = self._comments[index]
        between = self._text[end : comment.start]
        return not between.strip(" \t;") and bool(_KEY.fullmatch(comment.text.rstrip()))

    def _above(self, start: int) -> str:
        index = bisect_left(self._starts, start) - 1
        comments: list[Comment] = []
        position = start
        while index >= 0:
            comment = self._comments[index]
            text = comment.text
            between = self._text[comment.end : position]
            if between.strip() or text.startswith(_TRAILING):
                break
            line = self._text.rfind("\n", 0, comment.start) + 1
            if self._text[line : comment.start].strip():
                if not (comments or _SUPPRESSION.match(text) or self._trails(comment)):
                    comments += [comment] if is_documentation(text) else []
                break
            if _SUPPRESSION.match(text):
                position = line
                index -= 1
                continue
            adjacent = between.count("\n") == 1
            if not is_documentation(text) and not (text.startswith("//") and adjacent):
                break
            if comments and (not adjacent or text[:2] != "//"):
                break
            comments.append(comment)
            if text.startswith("/*"):
                break
            position = line
            index -= 1
            if index >= 0 and self._comments[index].end < line - 1:
                gap = self._text[self._comments[index].end : line]
                if gap.count("\n") > 1:
                    break
        if not comments:
            return ""
        texts = [_stripped(comment.text) for comment in reversed(comments)]
        joined = _tidy("\n".join(texts))
        return "" if _OF_A_FILE.search(joined) else joined

    def _after(self, end: int) -> str:
        if self._text[end - 1 : end] == ";":
            end -= 1
            while self._text[end - 1].isspace():
                end -= 1
        index = bisect_left(self._starts, end)
        if index == len(self._comments):
            return ""
        comment = self._comments[index]
        between = self._text[end : comment.start]
        mark = max(between.rfind(";"), between.rfind(",")) + 1
        if between[:mark].strip(" \t\r\n;,") or between[mark:].strip(" \t\r"):
            return ""
        if not comment.text.startswith(_AFTER) and not self._trails(comment):
            return ""
        if _SUPPRESSION.match(comment.text):
            return ""
        return _tidy(_stripped(comment.text))

    def _trails(self, comment: Comment) -> bool:
        """Return whether a comment stands behind a declaration, and no other one behind it."""
        before = self._last(comment.start)
        behind = _NEXT.match(self._text, comment.end)
        assert behind is not None
        return before not in _OPENING and behind[1] in _CLOSING

    def _last(self, end: int) -> str:
        """Return the last character in front of a place on its line that is not blank."""
        while end > 0 and self._text[end - 1] in " \t\r":
            end -= 1
        return self._text[end - 1 : end].strip()


def is_trailing(text: str) -> bool:
    """Return whether a comment says that it documents the declaration before it."""
    return text.startswith(_TRAILING)


def is_documentation(text: str) -> bool:
    """Return whether a comment documents the declaration that follows it."""
    return text.startswith(_DOCUMENTING) and not (is_trailing(text) or text == "/**/")


def _stripped(text: str) -> str:
    if text.startswith("//"):
        return _MARK.sub("", text, count=1).rstrip()
    inner = text[2:].removesuffix("*/").lstrip("*!").removeprefix("<")
    return _STAR.sub("", inner)


def _tidy(text: str) -> str:
    """Remove common indentation, and blank lines at either end."""
    if "\n" not in text:
        return text.strip()
    lines = [line.rstrip() for line in text.split("\n")]
    lines[0] = lines[0].lstrip()
    indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line]
    cut = min(indents, default=0)
    return (
        "\n".join([lines[0], *(line[cut:] for line in lines[1:])]).strip("\n").strip()
    )
