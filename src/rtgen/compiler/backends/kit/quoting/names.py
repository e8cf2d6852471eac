"""Files in which templates only insert names: IDL, CDL, C, EDS, TOML, Markdown of `rtgen new`."""

from __future__ import annotations

import re

from rtgen.compiler.backends.kit.quoting.code import Code, UnquotableError

_NAME = re.compile(r"[A-Za-z0-9_./:-]*")


class Names(Code):
    """Text of such a file."""

    __slots__ = ()


def quote_name(value: object) -> str:
    """Filter of such templates: accepts code and names. Raises UnquotableError for other texts."""
    if isinstance(value, Names):
        return value
    text = str(value)
    if isinstance(value, Code) or not _NAME.fullmatch(text):
        raise UnquotableError(text, "a file that allows only names")
    return Names(text)
