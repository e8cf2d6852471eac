"""Quoting for Python: string literals, numbers, docstrings, comments; names and types unchanged."""

from __future__ import annotations

import re

from rtgen.compiler.backends.kit.quoting.code import Code, HashComment, UnquotableError

_CONTROL = re.compile(
    r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff"
    r"\u200e\u200f\u202a-\u202e\u2066-\u2069]"
)
"""Line ends, and control and direction characters, which change the appearance of text."""

_QUOTES = re.compile('"{3,}')
_INERT = re.compile(r"(?!.*\w \w)[\w.,:|\[\]{} ]*")
"""Names, types and parameters, without statements, calls, literals or line ends."""
_WORD = re.compile(r"\w+")


class Python(Code):
    """Python source text."""

    __slots__ = ()


_NOTHING = Python("")
_INSERTED = (Python, HashComment)
"""Types that templates insert unchanged."""


def quote(value: object) -> str:
    """Filter of Python templates: accepts code, numbers, names and type expressions.

    Raises UnquotableError for other texts: they need `literal`, `in_docstring` or `comment`.
    """
    if isinstance(value, _INSERTED):
        return value
    text = str(value)
    if isinstance(value, Code) or not _INERT.fullmatch(text):
        raise UnquotableError(text, "Python")
    if not text.isascii() and not all(map(_is_name, _WORD.findall(text))):
        raise UnquotableError(text, "Python")
    return Python(text)


def _is_name(word: str) -> bool:
    return word.isascii() or word.isidentifier()


def string_literal(value: str) -> Python:
    """Return a string literal in black's form: double quotes unless they need more escapes."""
    if _is_plain(value):
        return Python(f'"{value}"')
    body = repr(value + '"' + "'")[1:-4].replace("\\'", "'")
    if value.count('"') <= value.count("'"):
        return Python('"' + body.replace('"', '\\"') + '"')
    return Python("'" + body.replace("'", "\\'") + "'")


def number_literal(value: float) -> Python:
    """Return a number in black's form: no plus sign in an exponent."""
    return Python(repr(value).replace("e+", "e"))


def docstring(text: str, indent: int, otherwise: str = "") -> Python:
    """Return the text as a docstring with this indent, with a final newline.

    `otherwise` replaces a blank text; without it, a blank text gives nothing.
    """
    if not text:
        return docstring(otherwise, indent) if otherwise else _NOTHING
    if _is_plain(text) and (line := text.strip()):
        return Python(f'{" " * indent}"""{line}"""\n')
    lines = _escaped(text.expandtabs()).split("\n")
    body = "\n".join(line.rstrip() for line in lines).strip()
    if not body:
        return docstring(otherwise, indent) if otherwise else _NOTHING
    if body.startswith('"'):
        body = " " + body
    margin = " " * indent
    head, *rest = body.split("\n")
    common = min((len(line) - len(line.lstrip()) for line in rest if line), default=0)
    lines = [margin + '"""' + head]
    lines.extend(margin + line[common:] if line else "" for line in rest)
    if rest:
        lines.append(margin + '"""')
    else:
        lines[0] += ' """' if body.endswith('"') else '"""'
    return Python("\n".join(lines) + "\n")


def in_docstring(text: str) -> Python:
    """Return the text on one line, for use inside a docstring, but not at its end."""
    return Python(" ".join(_escaped(text).split()))


def comment_text(text: str) -> Python:
    """Return the text on one line, for a comment: control characters become spaces."""
    return Python(" ".join(_CONTROL.sub(" ", text).split()))


def _is_plain(text: str) -> bool:
    """Return whether the text is one line without escapes, as most texts are."""
    return (
        text.isascii() and text.isprintable() and '"' not in text and "\\" not in text
    )


def _escaped(text: str) -> str:
    """Escape the text for use in triple quotes."""
    text = _CONTROL.sub(" ", text.replace("\\", "\\\\"))
    return _QUOTES.sub(lambda match: '\\"' * len(match[0]), text)
