"""Escapes texts for RtcProfiles, and reads them back."""

from __future__ import annotations

import keyword
import re

from rtgen.typemap.idl_keywords import escaped

_BREAK = re.compile(r"\s*<br\s*/?>\s*|\s*\n\s*", re.IGNORECASE)
_OTHER = re.compile(r"[^A-Za-z0-9_]+")


def written(text: str) -> str:
    """Return a text of several lines as RTCBuilder keeps it in an attribute."""
    return "<br/>".join(text.splitlines())


def lines(text: str) -> str:
    """Return a text of an attribute, with its lines."""
    return "\n".join(line.strip() for line in _BREAK.split(text)).strip()


def one_line(text: str) -> str:
    """Return a text of an attribute in one line."""
    return " ".join(lines(text).split("\n"))


def summary(description: str, doc: str) -> str:
    """Return the description of a component in one line; may be empty."""
    return description or doc.strip().partition("\n")[0].strip()


def word(text: str, otherwise: str) -> str:
    """Remove characters that are illegal in identifiers."""
    name = _OTHER.sub("_", text).lstrip("_") or otherwise
    return name if name[0].isalpha() else f"{otherwise}_{name}"


def identifier(text: str, otherwise: str = "value") -> str:
    """Return the text as an identifier of IDL and Python."""
    name = word(text, otherwise)
    reserved = escaped(name) != name or keyword.iskeyword(name)
    return f"{name}_" if reserved else name
