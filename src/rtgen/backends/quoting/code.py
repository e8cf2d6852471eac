"""Code and text: what a template may insert as it is, and what it has to quote.

A `Code` is a piece of an output language, made by the functions of this package or by a back end
that says so. Any other `str` is text: it may come from a definition, so it is quoted, or refused
where no quoting fits every place.
"""

from __future__ import annotations


class Code(str):
    """Code of some output language."""

    __slots__ = ()


class HashComment(Code):
    """Whole lines that begin with `#`, which several languages take for comments."""

    __slots__ = ()


class UnquotableError(ValueError):
    """The output language has no notation for a text at its place.

    Back ends report a diagnostic before they come to it.
    """

    def __init__(self, text: str, language: str) -> None:
        super().__init__(f"{language} cannot hold {str(text)[:80]!r} here")
