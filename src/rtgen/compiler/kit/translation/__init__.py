"""Texts for people in their language: that of an option, else of the project, else of the locale.

Messages are made in English, as machine formats show them, and translated where they are printed:
`translated` finds the template that a message was made from in the catalogue of the language.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

ENGLISH = "en"
LANGUAGES = (ENGLISH, "ja")

_LOCALE = ("LC_ALL", "LC_MESSAGES", "LANG")


class _Choice:
    """The language of the command that runs, found when a text is printed."""

    language: str | None = None
    of_project: Callable[[], str | None] | None = None


@contextmanager
def of_command(
    of_project: Callable[[], str | None], chosen: str | None = None
) -> Iterator[None]:
    """Print texts in the language of a command: `chosen`, else `of_project()`, else the locale's.

    Texts that a program prints afterwards have the language that they had before.
    """
    before = _Choice.language, _Choice.of_project
    _Choice.language, _Choice.of_project = chosen, of_project
    try:
        yield
    finally:
        _Choice.language, _Choice.of_project = before


def language() -> str:
    """Return the language of texts, one of LANGUAGES; that of the locale outside of commands."""
    if _Choice.language is not None:
        return _Choice.language
    if _Choice.of_project is None:
        return _of_locale()
    _Choice.language = _Choice.of_project() or _of_locale()
    return _Choice.language


def _of_locale() -> str:
    """Return the language of the first variable of the locale that is set, as POSIX has it."""
    locale = next(filter(None, map(os.environ.get, _LOCALE)), ENGLISH)
    name = locale.partition(".")[0].partition("_")[0].lower()
    return name if name in LANGUAGES else ENGLISH


def translated(text: str) -> str:
    """Return a text in the language; in English if the catalogue does not have it."""
    if language() == ENGLISH:
        return text
    from rtgen.compiler.kit.translation.catalogue import catalogue

    return catalogue(language()).translated(text)


def translated_word(word: str) -> str:
    """Return a word that stands alone, such as the head of a column, in the language."""
    if language() == ENGLISH:
        return word
    from rtgen.compiler.kit.translation.catalogue import WORD, catalogue

    return catalogue(language(), WORD).translated(word)


def listed(texts: Iterable[str]) -> str:
    """Return texts in the language as one, with its comma between them."""
    return (", " if language() == ENGLISH else "、").join(texts)


def translated_lines(text: str) -> str:
    """Return lines of text, each in the language; the space before them stays."""
    if language() == ENGLISH:
        return text
    lines = []
    for line in text.split("\n"):
        bare = line.lstrip()
        lines.append(line[: len(line) - len(bare)] + translated(bare))
    return "\n".join(lines)


def translated_paragraph(text: str) -> str:
    """Return a paragraph of a page, which has no insertions, in the language."""
    if language() == ENGLISH:
        return text
    from rtgen.compiler.kit.translation.catalogue import catalogue

    return catalogue(language()).paragraph(text)


def translated_page(page: str) -> str:
    """Return a page of Markdown with each paragraph in the language; code stays."""
    if language() == ENGLISH:
        return page
    from rtgen.compiler.kit.translation.blocks import blocks, joined

    parts = (
        translated_paragraph(joined(block)) if is_text else block
        for block, is_text in blocks(page)
    )
    return "\n\n".join(parts)
