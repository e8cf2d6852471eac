"""Decodes and parses a module, in any encoding, in Python 2 or 3."""

from __future__ import annotations

import ast
import re
import tokenize
import warnings
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.facts.decoded_text import with_line_feeds
from rtgen.facts.encodings import decode, labelled
from rtgen.facts.extras import installation
from rtgen.facts.files import UnreadableError, read_file
from rtgen.openrtm.python_modules import rules

_MAX_BYTES = 4 * 1024 * 1024
_FIXES = (
    *("except", "exec", "ne", "numliterals", "print", "raise", "repr"),
    *("tuple_params", "unicode"),
)
"""fissix fixers for Python 2: only syntax; names are kept, because nothing is executed."""

_MAX_CONVERTED = 300_000
"""Maximum length of a module that is converted, which takes seconds."""

_PARSE_ATTEMPTS = 20
"""CPython counts the depth of the trees of all threads together, and raises SystemError if another
thread parses at the same time, as the traceback module does.
"""

_CONVERTING = Lock()
"""Held while the converter is used: it has a state."""

_NOT_PYTHON_3 = "this is not Python 3"
_NOT_PYTHON = "this is neither Python 3 nor Python 2"
_DEEP = "too many"
_INDENT = re.compile(r"^[ \t]+", re.MULTILINE)
_BINARY_LONG = re.compile(r"\b(0[bB][01]+)[lL]\b")
"""A number of Python 2 that fissix does not read."""


@dataclass(frozen=True, slots=True)
class Source:
    """A module's text and tree; no tree if there are errors."""

    path: Path
    text: str
    tree: ast.Module | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def file(self) -> str:
        """The displayed path."""
        return self.path.as_posix()


def read_source(path: Path) -> Source:
    """Read the text and tree of a file; errors are among the diagnostics."""
    file = path.as_posix()
    start = Span(file, 1, 1, 1, 2)
    try:
        text, assumed = _decoded(read_file(path, _MAX_BYTES))
    except (UnreadableError, ValueError) as error:
        diagnostic = rules.UNREADABLE.at(start, f"{file} cannot be read: {error}")
        return Source(path, "", None, (diagnostic,))
    diagnostics: list[Diagnostic] = []
    if assumed is not None:
        message = (
            f"the file is not in the encoding that it declares; {assumed} is taken"
        )
        diagnostics.append(rules.ASSUMED.at(start, message))
    tree, wrong = _parsed(text, file)
    if wrong is not None and (changed := _python_3(text, wrong.message)) is not None:
        tree, _ = _parsed(changed, file)
        if tree is not None:
            _, of_python_2 = _parsed(_without_tabs(text), file)
            diagnostics.append(_assumption(text, of_python_2 or wrong, of_python_2))
            _place(tree, changed, text)
            return Source(path, text, tree, tuple(diagnostics))
    if wrong is not None:
        if wrong.message.startswith(_NOT_PYTHON_3) and _refactor() is not None:
            message = wrong.message.replace(_NOT_PYTHON_3, _NOT_PYTHON)
            wrong = replace(wrong, message=message, hint=None)
        return Source(path, text, None, (*diagnostics, wrong))
    if tree is not None and not text.isascii():
        _place(tree, text, text)
    return Source(path, text, tree, tuple(diagnostics))


def _assumption(
    text: str, wrong: Diagnostic, of_python_2: Diagnostic | None
) -> Diagnostic:
    """Return the warning about a text that is converted; `of_python_2` is in it without tabs."""
    assert wrong.span is not None
    line = text.split("\n")[wrong.span.line - 1]
    if of_python_2 is None:
        message = "tabs and spaces are mixed; a tab is read as eight columns"
        start, end = 1, len(_INDENT.sub("", line))
        end = max(2, len(line) - end + 1)
    else:
        message = "this is Python 2; its syntax is converted to read it"
        start = _column(line, _without_tabs(line), wrong.span.column - 1) + 1
        end = start + 1
    span = replace(wrong.span, column=start, end_column=end)
    return rules.ASSUMED.at(span, message)


def _place(tree: ast.Module, parsed: str, text: str) -> None:
    """Change places in the parsed text, with columns in octets, to those in the file's text."""
    lines, read = text.split("\n"), parsed.split("\n")
    numbers = _line_numbers(read, lines)

    def placed(number: int, octets: int) -> tuple[int, int]:
        of_parsed = read[number - 1]
        column = len(of_parsed.encode()[:octets].decode(errors="ignore"))
        own = numbers[number - 1]
        return own + 1, _column(lines[own], of_parsed, column)

    for node in ast.walk(tree):
        if isinstance(node, ast.stmt | ast.expr):
            end_line, end = node.end_lineno, node.end_col_offset
            assert end_line is not None
            assert end is not None
            node.lineno, node.col_offset = placed(node.lineno, node.col_offset)
            node.end_lineno, node.end_col_offset = placed(end_line, end)


def _line_numbers(read: list[str], lines: list[str]) -> list[int]:
    """Return for each line that was parsed the index of the file's line that it comes from.

    Parameters of Python 2 that are tuples become lines of their own.
    """
    last = len(lines) - 1
    if len(read) - len(lines) in (0, 1):
        return [min(number, last) for number in range(len(read))]
    numbers: list[int] = []
    matcher = SequenceMatcher(None, [*map(str.strip, lines)], [*map(str.strip, read)])
    for _, first, end, start, stop in matcher.get_opcodes():
        numbers += [
            min(first + number, max(first, end - 1), last)
            for number in range(stop - start)
        ]
    return numbers


def _column(line: str, parsed: str, column: int) -> int:
    """Return the place in a line of what its parsed form, of other indentation, has at `column`."""
    if line == parsed:
        return column
    inner = column - (len(parsed) - len(parsed.lstrip(" \t\f")))
    indent = len(line) - len(line.lstrip(" \t\f"))
    return min(indent + max(inner, 0), len(line))


def _decoded(data: bytes) -> tuple[str, str | None]:
    """Return the text, and the name of the encoding if it had to be guessed.

    PEP 263: a comment in the first two lines declares the encoding, which is UTF-8 without it.
    """
    try:
        declared, _ = tokenize.detect_encoding(BytesIO(data).readline)
        return with_line_feeds(labelled(data, declared)), None
    except (LookupError, SyntaxError, UnicodeDecodeError):
        read = decode(data)
        return read.normal, read.title


def _tree(text: str, file: str) -> ast.Module:
    for _ in range(_PARSE_ATTEMPTS - 1):
        try:
            return ast.parse(text, file)
        except SystemError:
            continue
    return ast.parse(text, file)


def _parsed(text: str, file: str) -> tuple[ast.Module | None, Diagnostic | None]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _tree(text, file), None
    except SyntaxError as error:
        line, column = error.lineno or 1, max(error.offset or 1, 1)
        span = Span(file, line, column, line, column + 1)
        message = f"{_NOT_PYTHON_3}: {error.msg}"
        hint = f"modules of Python 2 need the extra: {installation('python2')}"
        return None, rules.UNREADABLE.at(span, message, hint=hint)
    except (ValueError, RecursionError, MemoryError, SystemError) as error:
        span = Span(file, 1, 1, 1, 2)
        return None, rules.UNREADABLE.at(span, f"{file} cannot be read: {error}")


def _python_3(text: str, problem: str) -> str | None:
    """Convert the text to Python 3; None if that fails."""
    if len(text) > _MAX_CONVERTED or _NOT_PYTHON_3 not in problem or _DEEP in problem:
        return None
    if (refactor := _refactor()) is None:
        return None
    converter = _converter(refactor)
    errors = import_module("fissix.pgen2.parse").ParseError
    tokens = import_module("fissix.pgen2.tokenize").TokenError
    text = _BINARY_LONG.sub(r"\1", _without_tabs(text))
    try:
        with _CONVERTING:
            return str(converter.refactor_string(f"{text}\n", "module"))
    except (errors, tokens, IndentationError, RecursionError, ValueError, KeyError):
        # KeyError: a character that starts no token of Python
        return None


def _refactor() -> Any:
    """Return fissix's module; None if it is not installed."""
    try:
        return import_module("fissix.refactor")
    except ImportError:
        return None


def _without_tabs(text: str) -> str:
    """Return the text with indentation in spaces: Python 2 expands a tab to eight columns."""
    return _INDENT.sub(lambda match: match[0].expandtabs(8), text)


@cache
def _converter(refactor: Any) -> Any:
    """Return fissix's converter; its patterns take longer to compile than a module to convert."""
    return refactor.RefactoringTool([f"fissix.fixes.fix_{name}" for name in _FIXES])
