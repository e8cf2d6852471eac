"""IDL: literals, strings of annotations and directives, documentation comments."""

from __future__ import annotations

import re

_PLAIN = frozenset(map(chr, range(32, 127))).difference("\\\"'")
_BODY = re.compile(r'(?:[^"\\\x00-\x1f]|\\[^\x00-\x1f])*')
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff\ufeff]")


def characters(text: str, wide: bool) -> str:
    """Escape a text for a literal: non-ASCII characters by their codes, where escapes have them."""
    return "".join(_character(c, wide) for c in text)


def readable_string(text: str, quote: str = '"', wide: bool = False) -> str:
    """Return a literal in an annotation, or for readers: printable characters are kept."""
    body = (
        c if c.isprintable() and c not in ("\\", quote) else _character(c, wide)
        for c in text
    )
    return f"{'L' if wide else ''}{quote}{''.join(body)}{quote}"


def repository_id(name: str, text: str) -> str:
    """Return a directive that sets a repository id, with its escapes as written.

    The directive has no escapes, so an id that contains some is set by a declaration.
    """
    if "\\" not in text and '"' not in text and text.isprintable():
        return f'#pragma ID ::{name} "{text}"'
    literal = f'"{text}"' if _BODY.fullmatch(text) else readable_string(text)
    return f"typeid ::{name} {literal};"


def comment_lines(text: str) -> list[str]:
    """Return the lines of a text inside a block comment; none for a blank text."""
    text = _CONTROL.sub(" ", text).replace("*/", "* /")
    return text.split("\n") if text.strip() else []


def _character(character: str, wide: bool) -> str:
    if character in _PLAIN:
        return character
    code = ord(character)
    if code > (0xFFFF if wide else 0xFF):
        return character  # no escape is so long
    return f"\\u{code:04x}" if wide else f"\\x{code:02x}"
