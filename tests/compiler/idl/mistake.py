"""A mistake in a definition: the text, with § at the position of the message; message; hint."""

import re

Mistake = tuple[str, str, str]

FIRST_WORD = re.compile(r"§(\w+)")


def marked(text: str) -> str:
    """Return the word after §."""
    found = FIRST_WORD.search(text)
    assert found is not None
    return found[1]


def misspelt(text: str, meant: str) -> Mistake:
    """Return the mistake of a misspelt keyword."""
    message = f"IDL0102: '{marked(text)}' is not known here"
    return text, message, f"did you mean '{meant}'?"


def unknown(text: str, hint: str) -> Mistake:
    """Return the mistake of a name without a declaration."""
    return text, f"IDL0200: {marked(text)} is unknown", hint
