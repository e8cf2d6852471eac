"""Sentences of comments."""

from __future__ import annotations

import re

_END = re.compile(r"\s*\n\s*\n|(?<=[.!?])\s+(?=[^a-z0-9\s])|(?<=。)")


def split_sentence(text: str) -> tuple[str, str]:
    """Return the first sentence of a text, and what follows, with the space between them."""
    text = text.strip()
    end = _END.search(text)
    return (text, "") if end is None else (text[: end.start()], text[end.start() :])


def first_sentence(text: str) -> str:
    """Return the first sentence of a text as one line."""
    return " ".join(split_sentence(text)[0].split())
