"""The form of a text of IDL or CDL, and the edits towards it.

`format_text` works on the text before preprocessing, so that files which are only parts can be
formatted, too. The style is that of the examples in OMG IDL 4.2 and of the signatures of TECS.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rtgen.tools.fmt.layout import Layout, Line
from rtgen.tools.fmt.tokens import Language, LexicalError, tokens
from rtgen.tools.fmt.wrapping import Frame

__all__ = [
    "DEFAULT",
    "Edit",
    "Language",
    "LexicalError",
    "Options",
    "changed_text",
    "edits",
    "format_text",
]


@dataclass(frozen=True, slots=True)
class Options:
    """Style options: maximum columns of a line, and columns of an indentation step."""

    line_length: int = 100
    indent: int = 4


@dataclass(frozen=True, slots=True)
class Edit:
    """An edit that replaces [start, end) of a text."""

    start: int
    end: int
    text: str


DEFAULT = Options()


def format_text(text: str, language: Language, options: Options = DEFAULT) -> str:
    """Format a text. Raises LexicalError for an invalid token.

    Line ends are `\n`, in the text and in the result.
    """
    return changed_text(text, language, options, None)


def changed_text(
    text: str,
    language: Language,
    options: Options,
    lines: tuple[int, int] | None,
    check: Callable[[], None] = lambda: None,
) -> str:
    """Apply the `edits` to the text. Raises LexicalError."""
    parts: list[str] = []
    done = 0
    for edit in edits(text, language, options, lines, check):
        parts += text[done : edit.start], edit.text
        done = edit.end
    return "".join([*parts, text[done:]])


def edits(
    text: str,
    language: Language,
    options: Options = DEFAULT,
    lines: tuple[int, int] | None = None,
    check: Callable[[], None] = lambda: None,
) -> list[Edit]:
    """Return the changes of `format_text`, in order; `lines` limits them to statements in a range.

    `lines` are the first and the last line, from 1. `check` is called now and then, and can end the
    work by an exception. Raises LexicalError.
    """
    tokens_of_text = tokens(text, language, check)
    frame = Frame(options.line_length, options.indent)
    laid = Layout(text, tokens_of_text, language, frame).run(check)
    _align(laid)
    low, high = (0, len(text) + 1) if lines is None else _offsets(text, lines)
    changed: list[Edit] = []
    start, parts = 0, [""]
    for line in [*laid, None]:
        token = None if line is None else tokens_of_text[line.token]
        if token is None or token.breaks:
            end = len(text)
            if token is not None and line is not None and line.token:
                end = (
                    text.find("\n", tokens_of_text[line.token - 1].end, token.start) + 1
                )
            elif token is not None:
                end = 0
            new = "".join(parts)
            if text[start:end] != new and start < high and end > low:
                changed.append(Edit(start, end, new))
            start, parts = end, []
        if line is not None:
            parts.append(_shown(line))
    return changed


def _offsets(text: str, lines: tuple[int, int]) -> tuple[int, int]:
    """Return the start offset of the first line and the end offset of the last one."""
    ends = [0, *(match.end() for match in re.finditer("\n", text)), len(text) + 1]
    first, last = (min(number, len(ends) - 1) for number in lines)
    return ends[first - 1], ends[last]


def _shown(line: Line) -> str:
    blank = "\n" if line.blank else ""
    trailing = "".join(f" {comment}" for comment in line.trailing)
    return f"{blank}{line.text}{trailing}\n"


def _align(lines: Sequence[Line]) -> None:
    """Align trailing comments of consecutive lines if they are aligned in the source."""
    run: list[Line] = []
    for line in [*lines, None]:
        fits = line is not None and _has_short_comment(line)
        below = line is not None and run and line.column == run[0].column
        if line is not None and fits and below and not line.blank:
            run.append(line)
            continue
        if len(run) > 1:
            width = max(len(each.text) for each in run)
            for each in run:
                each.text = each.text.ljust(width)
        run = [line] if line is not None and fits else []


def _has_short_comment(line: Line) -> bool:
    texts = (line.text, *line.trailing)
    return bool(line.trailing) and not any("\n" in text for text in texts)
