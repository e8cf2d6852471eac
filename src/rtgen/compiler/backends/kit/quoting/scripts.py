"""Scripts: words of a POSIX shell, parts of batch files, strings of Ruby."""

from __future__ import annotations

import re
import shlex

from rtgen.compiler.backends.kit.quoting.code import Code, HashComment, UnquotableError
from rtgen.compiler.backends.kit.quoting.python import comment_text

_SHELL = re.compile(r"[\w@%+=:,./-]+")
_BATCH = re.compile(r"[\w.,:\\/ -]*")
_NOT_IN_REM = re.compile(r"[^A-Za-z0-9_.,:;()\[\]/ @+-]")
_RUBY = re.compile(r"[\w.,:\-/ ]*")


class Shell(Code):
    """Text of a POSIX shell."""

    __slots__ = ()


class Batch(Code):
    """Text of a Windows batch file."""

    __slots__ = ()


class Ruby(Code):
    """Text of Ruby."""

    __slots__ = ()


def shell_word(value: object) -> Shell:
    """Quote any text as one word of a shell. Raises UnquotableError for a NUL."""
    text = str(value)
    if "\0" in text:
        raise UnquotableError(text, "a shell")
    return Shell(text if _SHELL.fullmatch(text) else shlex.quote(text))


def shell_comment(text: str) -> Shell:
    """Return the text on one line, for a `#` comment."""
    return Shell(comment_text(text))


def quote_shell(value: object) -> str:
    """Filter of templates of shell scripts: accepts code, quotes words."""
    return value if isinstance(value, Shell | HashComment) else shell_word(value)


def batch_comment(text: str) -> Batch:
    """Return the text for `rem`: characters that the command processor interprets become `_`."""
    return Batch(_NOT_IN_REM.sub("_", text))


def quote_batch(value: object) -> str:
    """Filter of templates of batch files: accepts code, and texts that need no quoting.

    Raises UnquotableError for others: no quoting is understood by all commands.
    """
    if isinstance(value, Batch):
        return value
    text = str(value)
    if isinstance(value, Code) or not _BATCH.fullmatch(text):
        raise UnquotableError(text, "a batch file")
    return Batch(text)


def ruby_string(value: object) -> Ruby:
    """Return a string literal in single quotes."""
    text = str(value).replace("\\", "\\\\").replace("'", "\\'")
    return Ruby(f"'{text}'")


def ruby_comment(text: str) -> Ruby:
    """Return the text on one line, for a `#` comment."""
    return Ruby(comment_text(text))


def quote_ruby(value: object) -> str:
    """Filter of Ruby templates: accepts code, and texts without special characters."""
    if isinstance(value, Ruby | HashComment):
        return value
    text = str(value)
    if isinstance(value, Code) or not _RUBY.fullmatch(text):
        raise UnquotableError(text, "Ruby")
    return Ruby(text)
