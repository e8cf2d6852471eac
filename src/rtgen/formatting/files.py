"""Formats whole files, keeping their encoding, byte-order mark and line ends."""

from __future__ import annotations

import codecs
from dataclasses import dataclass
from pathlib import PurePath

from rtgen.diagnostics import InputError
from rtgen.formatting import DEFAULT, Options, changed_text, toml
from rtgen.formatting.rules import NO_TOKENS, OTHER_FILE
from rtgen.formatting.tokens import Language, LexicalError
from rtgen.frontends.cdl.text import encodings
from rtgen.frontends.kit.library import MAX_BYTES
from rtgen.frontends.kit.lines import LineTable

LANGUAGES = {".idl": Language.IDL, ".cdl": Language.CDL}
"""Language by suffix, in lower case."""

SUFFIXES = (*LANGUAGES, toml.SUFFIX)
"""Suffixes of files that can be formatted."""

_BYTES = "latin-1"


@dataclass(frozen=True, slots=True)
class Content:
    """A decoded file, with what is needed to encode it again."""

    text: str
    codec: str
    mark: bytes
    line_end: str

    def encoded(self, text: str) -> bytes:
        """Encode another text in the same way."""
        return self.mark + text.replace("\n", self.line_end).encode(self.codec)


def check_name(name: str) -> None:
    """Raise InputError for a file that cannot be formatted."""
    if PurePath(name).suffix.lower() not in SUFFIXES:
        known = ", ".join(f"*{suffix}" for suffix in SUFFIXES)
        message = f"{name} has no form that rtgen knows"
        raise InputError([OTHER_FILE.at(None, message, hint=f"it knows {known}")])


def content(data: bytes, language: Language | None, kcode: str = "auto") -> Content:
    """Decode a file; `kcode` is the encoding of CDL files."""
    mark = codecs.BOM_UTF8 if data.startswith(codecs.BOM_UTF8) else b""
    body = data.removeprefix(mark)
    is_cdl = language is Language.CDL
    wanted = encodings.codec(data, kcode) if is_cdl else "utf-8"
    codec = next((c for c in (wanted, "utf-8") if _is_kept(body, c)), _BYTES)
    text = body.decode(codec)
    windows = text.count("\r\n")
    line_end = "\r\n" if 2 * windows > text.count("\n") else "\n"
    return Content(text.replace("\r\n", "\n"), codec, mark, line_end)


def _is_kept(data: bytes, codec: str) -> bool:
    """Return whether decoding and encoding gives the same bytes."""
    try:
        return data.decode(codec).encode(codec) == data
    except UnicodeError:
        return False


def format_bytes(
    data: bytes,
    name: str,
    options: Options = DEFAULT,
    *,
    kcode: str = "auto",
    lines: tuple[int, int] | None = None,
) -> bytes:
    """Return the formatted content of the file `name`; `lines` limits the changes to a range.

    Raises InputError for a file that cannot be formatted or has an invalid token, ToolError if its
    formatter is not installed.
    """
    check_name(name)
    language = LANGUAGES.get(PurePath(name).suffix.lower())
    if len(data) > MAX_BYTES:
        message = f"{name} is larger than {MAX_BYTES:,} bytes"
        raise InputError([OTHER_FILE.at(None, message)])
    read = content(data, language, kcode)
    if language is None:
        return read.encoded(toml.changed_text(read.text, name, options, lines))
    try:
        return read.encoded(changed_text(read.text, language, options, lines))
    except LexicalError as error:
        span = LineTable(name, read.text).span(error.start, error.end)
        found = NO_TOKENS.at(span, error.message, hint=error.hint)
        raise InputError([found]) from None
