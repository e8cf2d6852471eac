"""Prints Python in black's format: line splitting, module header.

A statement is written on one line; `fit` splits it if it is longer than 88 columns, as black would:
a bracket pair is opened, with one item per line and a trailing comma (which keeps black from
joining them again), starting with the last pair (in a `def`, a `class` and a tuple of targets with
the first). A statement without a bracket to open, because its names are too long, is marked with `#
fmt: skip`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import msgspec

from rtgen.compiler.backends import Owner
from rtgen.compiler.backends.kit.quoting.code import HashComment
from rtgen.compiler.backends.kit.quoting.names import Names
from rtgen.compiler.backends.kit.quoting.python import comment_text
from rtgen.compiler.backends.kit.rendering import render

WIDTH = 88
"""Maximum line length of black."""

SKIPPED = "  # fmt: skip"
"""Marks a line that black leaves unchanged."""

_OFF, _ON = "# fmt: off", "# fmt: on"
_SWITCH = "# fmt: o"
"""Common start of both comments."""
_STEP = 4
_MARK = re.compile(
    r""""(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[()\[\]{}]|, ?| for | = | else """
)
_SUBSCRIPT = re.compile(r"""[\w)\]}"']\[""")
"""Brackets whose only item is not followed by a comma, which would make it a tuple."""
_LONE_COLON = re.compile(r"""["'()\[\]{},\s]:\Z""")
_LONE_LITERAL = re.compile(r""" *(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"),""")
"""An item that no line break can shorten."""
_LITERAL = re.compile(r''''(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"''')


def _split(text: str, separator: str, most: int = -1) -> list[str]:
    """Like `text.split(separator, most)`, but string literals are not split."""
    hidden = _LITERAL.sub(lambda match: "\0" * len(match[0]), text)
    parts, start = [], 0
    for part in hidden.split(separator, most):
        parts.append(text[start : start + len(part)])
        start += len(part) + len(separator)
    return parts


class _Group(msgspec.Struct):
    """A bracket pair of a statement.

    `separators` are places between items: the end of one and the start of the next. `comma`: the
    items are separated by commas, and a trailing comma is allowed.
    """

    start: int
    comma: bool = True
    end: int = 0
    separators: list[tuple[int, int]] = []
    inner: list[_Group] = []

    def items(self) -> list[tuple[int, int]]:
        """Return start and end of the items; none of them is empty."""
        begins = [self.start + 1, *[begin for _, begin in self.separators]]
        ends = [*[end for end, _ in self.separators], self.end - 1]
        return [(b, e) for b, e in zip(begins, ends, strict=True) if b < e]


def fit(statement: str, indent: int = 0) -> str:
    """Return a one-line statement indented, and split if it is too long.

    `indent` is in columns and includes the first line. No newline at the end.
    """
    if indent + len(statement) <= WIDTH:
        return " " * indent + statement
    text = statement
    if text.startswith("from ") and not text.endswith(")"):
        text = text.replace(" import ", " import (", 1) + ")"
    opened = _Statement(text).opened(indent)
    if opened is None:
        return f"{' ' * indent}{statement}{SKIPPED}"
    return "\n".join(opened)


class Bracketed:
    """Items in a bracket pair after a text, such as `head(item, item)`; items can be nested.

    `head` ends with the opening bracket; `closing` is `,)` after the only item of a tuple. `flat`
    is the text on one line.
    """

    __slots__ = ("_closing", "_head", "_items", "flat")

    def __init__(
        self, head: str, items: Sequence[str | Bracketed], closing: str = ")"
    ) -> None:
        self._head, self._items, self._closing = head, items, closing
        texts = [item if isinstance(item, str) else item.flat for item in items]
        self.flat: str = f"{head}{', '.join(texts)}{closing}"

    def lines(self, indent: int, ending: str = "") -> list[str]:
        """Return the lines with `ending` appended; brackets are opened if a line is too long."""
        margin = " " * indent
        if indent + len(self.flat) + len(ending) <= WIDTH or not self._items:
            return [f"{margin}{self.flat}{ending}"]
        lines = [margin + self._head]
        for item in self._items:
            if isinstance(item, str):
                lines.append(f"{margin}    {item},")
            else:
                lines += item.lines(indent + _STEP, ",")
        return [*lines, f"{margin}{self._closing[-1]}{ending}"]


def tuple_of(items: Sequence[str | Bracketed], head: str = "") -> Bracketed:
    """Return a tuple of the items, after a text."""
    return Bracketed(f"{head}(", items, ",)" if len(items) == 1 else ")")


def fit_bracketed(statement: Bracketed, indent: int) -> str:
    """Return the statement indented and split as by `fit`, without a search.

    If a head or an item must be split, too, the result is one line, for `fit_text`.
    """
    lines = statement.lines(indent)
    long = [line for line in lines if len(line) > WIDTH]
    if not all(map(_LONE_LITERAL.fullmatch, long)):
        return " " * indent + statement.flat
    return "\n".join(lines)


def fit_text(text: str) -> str:
    """Return a module with its long statements split; docstrings and comments are unchanged.

    Also unchanged are marked lines, and text between `# fmt: off` and `# fmt: on`. A docstring must
    start and end on lines of its own, as `docstring` writes it.
    """
    lines = text.split("\n")
    if max(map(len, lines)) <= WIDTH:
        return text
    inside = off = False
    for place, line in enumerate(lines):
        if len(line) <= WIDTH and '"""' not in line and _SWITCH not in line:
            continue
        bare = line.lstrip()
        begins = bare.startswith('"""') and not off
        quotes = line.count('"""') if inside or begins else 0
        if not inside and bare in (_OFF, _ON):
            off = bare == _OFF
        unchanged = len(line) <= WIDTH or inside or quotes or off
        unchanged = unchanged or bare.startswith("#") or bare.endswith(SKIPPED)
        if not unchanged and not _LONE_LITERAL.fullmatch(bare):
            lines[place] = fit(bare, len(line) - len(bare))
        inside ^= quotes == 1
    return "\n".join(lines)


def _with_result_wrapped(lines: list[str], indent: int) -> list[str]:
    """Return a long last line of a `def` with its annotation in brackets, if that helps."""
    margin = " " * indent
    result = (
        lines[-1].removeprefix(f"{margin}) -> ").removesuffix(": ...").removesuffix(":")
    )
    if len(lines[-1]) <= WIDTH or result == lines[-1] or "[" in result:
        return lines
    inner = [" " * (indent + _STEP) + result]
    if len(inner[0]) > WIDTH:
        first, *others = _split(result, " | ")
        inner = [
            " " * (indent + _STEP) + text
            for text in (first, *(f"| {o}" for o in others))
        ]
    if max(map(len, inner)) > WIDTH and len(inner) == 1:
        return lines
    ending = ": ..." if lines[-1].endswith(": ...") else ":"
    return [*lines[:-1], f"{margin}) -> (", *inner, f"{margin}){ending}"]


def _open_choice(target: str, value: str, indent: int) -> list[str]:
    """Return `target = (` a conditional expression `)`, on three lines if necessary."""
    margin = " " * (indent + _STEP)
    body = [margin + value]
    if len(body[0]) > WIDTH:
        chosen, rest = _split(value, " if ", 1)
        condition, other = _split(rest, " else ", 1)
        body = [margin + chosen, f"{margin}if {condition}", f"{margin}else {other}"]
    return [f"{' ' * indent}{target} = (", *body, " " * indent + ")"]


def _union(text: str, indent: int, ending: str) -> list[str]:
    """Return an item `A | None` or `name: A | None`, whose type black splits before each `|`."""
    margin = " " * indent
    name, *annotations = _split(text, ": ", 1)
    if not annotations:
        first, *others = _split(text, " | ")
        lines = [margin + first, *(f"{margin}| {other}" for other in others)]
        return [*lines[:-1], lines[-1] + ending]
    [annotation] = annotations
    if len(_split(annotation, " | ")) == 1:
        return [margin + text + ending]
    body = [margin + " " * _STEP + annotation]
    if len(body[0]) > WIDTH:
        body = _union(annotation, indent + _STEP, "")
    return [f"{margin}{name}: (", *body, f"{margin}){ending}"]


class _Statement:
    """A statement on one line, with the places of its brackets."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._sign = -1
        """Offset of the first ` = ` outside of brackets, else -1."""
        self._targets = False
        """Whether there is a comma before the sign."""
        self._choice = False
        """Whether there is an `else` after the sign."""
        self._groups = self._outermost()

    def _outermost(self) -> list[_Group]:
        outermost: list[_Group] = []
        enclosing: list[_Group] = []
        for match in _MARK.finditer(self._text):
            mark = match[0]
            if mark in "([{":
                group = _Group(match.start())
                (enclosing[-1].inner if enclosing else outermost).append(group)
                enclosing.append(group)
            elif mark in ")]}":
                group = enclosing.pop()
                group.end = match.end()
                if _SUBSCRIPT.match(self._text, max(group.start - 1, 0)):
                    group.comma &= bool(group.separators)
            elif not enclosing:
                self._outside(mark, match.start())
            elif mark == " for ":
                enclosing[-1].separators.append((match.start(), match.start() + 1))
                enclosing[-1].comma = False
            elif mark[0] == "," and enclosing[-1].comma:
                enclosing[-1].separators.append(match.span())
        return outermost

    def _outside(self, mark: str, place: int) -> None:
        """Record an operator outside of brackets."""
        if mark == " = " and self._sign < 0:
            self._sign = place
        elif mark == " else ":
            self._choice |= self._sign >= 0
        elif mark == ", ":
            self._targets |= self._sign < 0

    def opened(self, indent: int) -> list[str] | None:
        """Return the statement with an opened bracket pair; None if there is none to open."""
        text, sign = self._text, self._sign
        if self._choice:
            return _open_choice(text[:sign], text[sign + 3 :], indent)
        groups = [group for group in self._groups if group.end - group.start > 2]
        if not groups:
            return None
        if text.startswith(("def ", "class ", "from ")):
            return _with_result_wrapped(self._whole(groups[0], indent), indent)
        if self._targets and sign >= 0:
            bracketed = _Statement(f"({text[:sign]}){text[sign:]}")
            return bracketed._whole(bracketed._groups[0], indent)
        last = groups[-1]
        raises = text.startswith("raise ")
        at_end = raises or last.end == len(text) or _LONE_COLON.search(text)
        needs_head = raises or sign >= 0 or text.startswith("return ")
        if not at_end or (needs_head and indent + last.start + 1 > WIDTH):
            return None
        return self._whole(last, indent)

    def _whole(self, group: _Group, indent: int) -> list[str]:
        """Return the statement as lines with the group opened."""
        return self._open(group, self._groups, 0, len(self._text), indent, "")

    def _open(
        self,
        group: _Group,
        siblings: list[_Group],
        begin: int,
        end: int,
        indent: int,
        ending: str,
    ) -> list[str]:
        """Return the text between two offsets as lines with a group opened, then `ending`."""
        lines = self._lines(siblings, begin, group.start + 1, indent, "")
        items, inner, comma = group.items(), indent + _STEP, ","
        if not group.comma:
            comma = ""
            if inner + group.end - group.start - 2 <= WIDTH:
                items = [(group.start + 1, group.end - 1)]
        margin, room = " " * inner, WIDTH - inner - len(comma)
        for start, stop in items:
            if stop - start <= room:
                lines.append(f"{margin}{self._text[start:stop]}{comma}")
            else:
                lines += self._item(group.inner, start, stop, inner, comma)
        return lines + self._lines(siblings, group.end - 1, end, indent, ending)

    def _lines(
        self, groups: list[_Group], begin: int, end: int, indent: int, ending: str
    ) -> list[str]:
        """Return an item, or the head or end of a statement, as lines, then `ending`."""
        flat = " " * indent + self._text[begin:end] + ending
        if len(flat) > WIDTH:
            for group in reversed(groups):
                full = group.end - group.start > 2
                if full and begin <= group.start and group.end <= end:
                    return self._open(group, groups, begin, end, indent, ending)
        return [flat]

    def _item(
        self, groups: list[_Group], begin: int, end: int, indent: int, ending: str
    ) -> list[str]:
        """Return an item of a group that is too long for a line, as lines."""
        if any(begin <= group.start < end for group in groups):
            return self._lines(groups, begin, end, indent, ending)
        return _union(self._text[begin:end], indent, ending)


def header(
    version: str, sources: Iterable[str], owner: Owner = Owner.RTGEN
) -> tuple[str, ...]:
    """Return the lines of a generated file's header, without comment marks.

    `sources` are the keys of the inputs, each once. Their digests are only in the manifest, so that
    a change of an input only changes affected files.
    """
    text = render(
        "header.txt.j2",
        version=Names(version),
        sources=[Names(comment_text(key)) for key in dict.fromkeys(sources)],
        created_once=owner is Owner.USER,
    )
    return tuple(map(_comment_line, text.splitlines()))


def _comment_line(line: str) -> str:
    """Return a line for a comment of any language: without control characters, and without a
    backslash at the end, which continues a comment of IDL.
    """
    indent = line[: len(line) - len(line.lstrip())]
    return (indent + comment_text(line)).rstrip("\\ ")


def header_comment(
    version: str, sources: Iterable[str], owner: Owner = Owner.RTGEN
) -> HashComment:
    """Return the header as `#` comment, with a final newline."""
    lines = header(version, sources, owner)
    return HashComment("".join(f"# {text}\n" for text in lines))
