"""Escapes texts in RtcProfiles, and unescapes them."""

from __future__ import annotations

import keyword
import re

from rtgen.compiler.typemap.idl_keywords import escaped
from rtgen.facts.comments import first_sentence

_BREAK = re.compile(r"\s*<br\s*/?>\s*|\s*\n\s*", re.IGNORECASE)
_OTHER = re.compile(r"[^A-Za-z0-9_]+")


def written(text: str) -> str:
    """Escape line ends as RTCBuilder does in an attribute."""
    return "<br/>".join(text.splitlines())


def lines(text: str) -> str:
    """Restore the line ends in an attribute's text."""
    return "\n".join(line.strip() for line in _BREAK.split(text)).strip()


def one_line(text: str) -> str:
    """Join the lines of an attribute's text."""
    return " ".join(lines(text).split("\n"))


def summary(description: str, doc: str) -> str:
    """Return the one-line description of a component; may be empty."""
    return description or first_sentence(doc)


def word(text: str, otherwise: str) -> str:
    """Remove characters that identifiers cannot have."""
    name = _OTHER.sub("_", text).lstrip("_") or otherwise
    return name if name[0].isalpha() else f"{otherwise}_{name}"


def identifier(text: str, otherwise: str = "value") -> str:
    """Convert a text to an identifier of IDL and Python."""
    name = word(text, otherwise)
    reserved = escaped(name) != name or keyword.iskeyword(name)
    return f"{name}_" if reserved else name
