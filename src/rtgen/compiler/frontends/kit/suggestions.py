"""Suggestions for misspelt names."""

from __future__ import annotations

from collections.abc import Iterable
from operator import ne

_MAX_COMPARED = 500
"""Number of candidates above which only those of similar start and length are compared."""

_COMPARED = 3
"""Number of the most similar candidates among which one that differs in a letter is preferred."""

_MAX_GUESSES = 200
"""Maximum number of errors of one kind for which suggestions are searched, which is slow."""


class Guesses:
    """Suggestions for the first errors of one kind; each word is searched once."""

    def __init__(self) -> None:
        self._cache: dict[str, str | None] = {}

    def nearest(self, word: str, candidates: Iterable[str]) -> str | None:
        """Return the result of the function `nearest`; None after too many errors."""
        if word not in self._cache and len(self._cache) < _MAX_GUESSES:
            self._cache[word] = nearest(word, candidates)
        return self._cache.get(word)


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate most similar to `word`: equal except for case, else by difflib."""
    if len(word) > 200:
        return None
    choices = list(candidates)
    folded = word.lower()
    for choice in choices:
        if choice.lower() == folded:
            return choice
    if len(choices) > _MAX_COMPARED:
        slack = len(word) // 4 + 1
        choices = [
            choice
            for choice in choices
            if abs(len(choice) - len(word)) <= slack
            and choice[:2].lower() == folded[:2]
        ]
    if len(choices) > _MAX_COMPARED:
        return None
    from difflib import get_close_matches

    matches = get_close_matches(word, choices, n=_COMPARED, cutoff=0.7)
    # One other letter is likelier than one that is missing.
    alike = [each for each in matches if differ_in_one(each, word)]
    return next(iter((*alike, *matches)), None)


def differ_in_one(one: str, other: str) -> bool:
    """Return whether two words of one length differ in one letter."""
    return len(one) == len(other) and sum(map(ne, one, other)) == 1


def guess(word: str, candidates: Iterable[str]) -> str | None:
    """Return a hint with the candidate most similar to `word`, if there is one."""
    near = nearest(word, candidates)
    return f"did you mean {near}?" if near else None
