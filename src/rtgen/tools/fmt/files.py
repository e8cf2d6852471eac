"""Formats whole files, keeping their encoding, byte-order mark and line ends."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePath

from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.compiler.frontends.kit.lines import LineTable
from rtgen.facts import encodings
from rtgen.facts.decoded_text import Decoded, NotEncodableError
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.tools.fmt import DEFAULT, Options, changed_text, toml
from rtgen.tools.fmt.rules import NO_TOKENS, OTHER_FILE
from rtgen.tools.fmt.tokens import Language, LexicalError

LANGUAGES = {**dict.fromkeys(IDL_SUFFIXES, Language.IDL), ".cdl": Language.CDL}
"""Language by suffix, in lower case."""

SUFFIXES = (*LANGUAGES, toml.SUFFIX)
"""Suffixes of files that can be formatted."""


@dataclass(frozen=True, slots=True)
class Content:
    """A decoded file, with what is needed to encode it again."""

    text: str
    decoded: Decoded
    line_end: str

    def encoded(self, text: str) -> bytes:
        """Encode another text in the same way. Raises NotEncodableError."""
        return self.decoded.encode(text.replace("\n", self.line_end))


def check_name(name: str) -> None:
    """Raise InputError for a file that cannot be formatted."""
    if PurePath(name).suffix.lower() not in SUFFIXES:
        patterns = ", ".join(f"*{suffix}" for suffix in SUFFIXES)
        message = f"{name} has no form that rtgen knows"
        raise InputError([OTHER_FILE.at(None, message, hint=f"it knows {patterns}")])


def content(data: bytes, language: Language | None, encoding: str = "auto") -> Content:
    """Decode a file; `encoding`, of `decoded_text.NAMES`, is the one asked for."""
    decoded = encodings.decode(data, encoding, standard=language is None)
    windows = decoded.text.count("\r\n")
    line_end = "\r\n" if 2 * windows > decoded.text.count("\n") else "\n"
    return Content(decoded.normal, decoded, line_end)


def format_bytes(
    data: bytes,
    name: str,
    options: Options = DEFAULT,
    *,
    encoding: str = "auto",
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
    read = content(data, language, encoding)
    try:
        if language is None:
            new = toml.changed_text(read.text, name, options, lines)
        else:
            new = changed_text(read.text, language, options, lines)
        return read.encoded(new)
    except NotEncodableError as error:
        message = f"{name} cannot be written in its encoding: {error}"
        hint = "convert the file to UTF-8 first"
        raise InputError([OTHER_FILE.at(None, message, hint=hint)]) from None
    except LexicalError as error:
        span = LineTable(name, read.text).span(error.start, error.end)
        diagnostic = NO_TOKENS.at(span, error.message, hint=error.hint)
        raise InputError([diagnostic]) from None
