"""Distinguishes code from text: code is inserted into templates unchanged, text is quoted.

A `Code` is a piece of an output language, made by the functions of this package or explicitly by
a back end. Any other `str` is text: it may come from a definition, so it is quoted, or rejected
if no quoting fits all places.
"""

from __future__ import annotations


class Code(str):
    """Code of some output language."""

    __slots__ = ()


class HashComment(Code):
    """Complete lines that start with `#`, a comment in several languages."""

    __slots__ = ()


class UnquotableError(ValueError):
    """The output language cannot represent a text at this place.

    Back ends report a diagnostic before this can happen; else it becomes one (UNQUOTABLE). `text`
    is the whole text.
    """

    def __init__(self, text: str, language: str) -> None:
        self.text = str(text)
        super().__init__(f"{language} cannot hold {self.text[:80]!r} here")
