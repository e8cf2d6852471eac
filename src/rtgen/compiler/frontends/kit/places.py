"""Finds a text of the model in the files that it was read from."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit.lines import LineTable

_WORDS = re.compile(r"\w+")


def place_of(sources: Mapping[str, str], text: str) -> Span | None:
    """Return the first place of a text in files by name, else that of its longest word.

    For diagnostics about texts whose places the model does not have.
    """
    for spelling in _spellings(text):
        for file, source in sources.items():
            start = source.find(spelling)
            if start >= 0:
                return LineTable(file, source).span(start, start + len(spelling))
    return None


def _spellings(text: str) -> Iterator[str]:
    """Yield the ways in which languages may write the text, then its words."""
    from xml.sax.saxutils import escape  # imports urllib, which most runs do not need

    stripped = text.strip()
    escaped = json.dumps(stripped, ensure_ascii=False)[1:-1]
    ways = (stripped, escaped, escape(stripped, {'"': "&quot;"}))
    words = sorted(_WORDS.findall(text), key=len, reverse=True)
    yield from (each for each in dict.fromkeys((*ways, *words)) if each)
