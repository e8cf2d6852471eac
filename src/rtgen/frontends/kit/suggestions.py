"""Names that someone may have meant."""

from __future__ import annotations

from collections.abc import Iterable

_MAX_COMPARED = 500
"""Of more candidates those are compared that begin alike and are about as long: it takes time."""

_MAX_GUESSES = 200
"""For so many mistakes of one sort a near name is looked for, since that takes time."""


class Guesses:
    """Near names for the first mistakes of one sort, each word looked for once."""

    def __init__(self) -> None:
        self._known: dict[str, str | None] = {}

    def nearest(self, word: str, candidates: Iterable[str]) -> str | None:
        """As the function of that name; None where there were too many mistakes before."""
        if word not in self._known and len(self._known) < _MAX_GUESSES:
            self._known[word] = nearest(word, candidates)
        return self._known.get(word)


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate most like `word`: equal but for case, else by difflib; None if none
    is.
    """
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

    found = get_close_matches(word, choices, n=1, cutoff=0.7)
    return found[0] if found else None
