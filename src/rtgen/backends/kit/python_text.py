"""Prints Python in black's format: line fitting, module header.

A statement is written on one line; `fit` splits it if it is longer than 88 columns, as black
would: a bracket pair is opened, one item a line with a trailing comma (which keeps black from
joining them again), starting with the last pair (in a `def`, a `class` and a tuple of targets
with the first). A statement without a bracket to open, because its names are too long, is marked
with `# fmt: skip`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TypeAlias

import msgspec

from rtgen.backends import Owner
from rtgen.backends.kit.quoting.code import HashComment
from rtgen.backends.kit.quoting.python import comment_text

WIDTH = 88
"""Maximum line length of black."""

SKIPPED = "  # fmt: skip"
"""Marks a line that black leaves unchanged."""

_OFF, _ON = "# fmt: off", "# fmt: on"
_SWITCH = "# fmt: o"
"""The beginning of both."""
_STEP = 4
_CLOSING = {"(": ")", "[": "]", "{": "}"}
_OPENING = {closing: opening for opening, closing in _CLOSING.items()}
_TOKEN = re.compile(
    r"""("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[()\[\]{}]|, ?| for | = |[^"'()\[\]{},\s]+|\s)"""
)


_LITERAL = re.compile(r''''(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"''')


def _split(text: str, separator: str, most: int = -1) -> list[str]:
    """Like `text.split(separator, most)`, but string literals are not split."""
    hidden = _LITERAL.sub(lambda found: "\0" * len(found[0]), text)
    parts, start = [], 0
    for part in hidden.split(separator, most):
        parts.append(text[start : start + len(part)])
        start += len(part) + len(separator)
    return parts


class _Group(msgspec.Struct, frozen=True):
    """A bracket pair with its content, and its text on one line.

    `comma`: the items are separated by commas, and a trailing one is legal.
    """

    opening: str
    items: tuple[_Part | _Line, ...]
    closing: str
    flat: str
    comma: bool = True


class _Line(msgspec.Struct, frozen=True):
    """A logical line, or an item of a group, made of parts."""

    parts: tuple[_Part, ...]


_Part: TypeAlias = str | _Group


def _flat(parts: Iterable[_Part]) -> str:
    """The text on one line, however long."""
    return "".join([part if isinstance(part, str) else part.flat for part in parts])


def fit(statement: str, indent: int = 0) -> str:
    """The statement, written on one line, indented and split if it is too long.

    `indent` is in columns; the first line is indented too. No newline at the end.
    """
    if indent + len(statement) <= WIDTH:
        return " " * indent + statement
    text = statement
    if text.startswith("from ") and not text.endswith(")"):
        text = text.replace(" import ", " import (", 1) + ")"
    opened = _open_statement(_parse(text), indent, text)
    if opened is None:
        return f"{' ' * indent}{statement}{SKIPPED}"
    return "\n".join(opened)


def fit_text(text: str) -> str:
    """A module with its long statements split; docstrings and comments stay as they are.

    So does a line that is marked, and what is between `# fmt: off` and `# fmt: on`. A docstring
    has to begin and to end at a line of its own, as `docstring` makes them.
    """
    lines: list[str] = []
    inside = off = False
    for text_line in text.split("\n"):
        short = inside or len(text_line) <= WIDTH
        if short and '"""' not in text_line and _SWITCH not in text_line:
            lines.append(text_line)
            continue
        bare = text_line.lstrip()
        begins = bare.startswith('"""') and not off
        quotes = text_line.count('"""') if inside or begins else 0
        if not inside and bare in (_OFF, _ON):
            off = bare == _OFF
        kept = off or bare.startswith("#") or bare.endswith(SKIPPED)
        if len(text_line) <= WIDTH or inside or quotes or kept:
            lines.append(text_line)
        else:
            lines.append(fit(bare, len(text_line) - len(bare)))
        inside ^= quotes == 1
    return "\n".join(lines)


def _open_statement(
    parts: tuple[_Part, ...], indent: int, flat: str
) -> list[str] | None:
    sign = next((i for i, p in enumerate(parts) if p == " = "), None)
    if sign is not None and "else" in parts[sign:]:
        return _open_choice(parts[: sign + 1], parts[sign + 1 :], indent)
    groups = [i for i, p in enumerate(parts) if isinstance(p, _Group) and p.items]
    if not groups:
        return None
    if flat.startswith(("def ", "class ", "from ")):
        return _with_result_wrapped(_open(parts, groups[0], indent, ""), indent)
    if sign is not None and ", " in parts[:sign]:
        targets = _Group("(", _at_commas(parts[:sign]), ")", f"({_flat(parts[:sign])})")
        return _open((targets, *parts[sign:]), 0, indent, "")
    head = indent + len(_flat(parts[: groups[-1]])) + 1
    at_end = groups[-1] == len(parts) - 1 or parts[-1] == ":"
    at_end |= flat.startswith("raise ")
    needs_head = sign is not None or flat.startswith(("return ", "raise "))
    if not at_end or (needs_head and head > WIDTH):
        return None
    return _open(parts, groups[-1], indent, "")


def _with_result_wrapped(lines: list[str], indent: int) -> list[str]:
    """The last line of a `def` that is too long: its annotation in brackets, if that helps."""
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


def _open_choice(
    target: tuple[_Part, ...], value: tuple[_Part, ...], indent: int
) -> list[str]:
    """`target = (` a conditional expression `)`, the expression in three lines if need be."""
    margin = " " * (indent + _STEP)
    text = _flat(value)
    body = [margin + text]
    if len(body[0]) > WIDTH:
        chosen, rest = _split(text, " if ", 1)
        condition, other = _split(rest, " else ", 1)
        body = [margin + chosen, f"{margin}if {condition}", f"{margin}else {other}"]
    head = _flat(target)
    return [f"{' ' * indent}{head}(", *body, " " * indent + ")"]


def _parts(item: _Part | _Line) -> tuple[_Part, ...]:
    return item.parts if isinstance(item, _Line) else (item,)


def _lines(parts: tuple[_Part, ...], indent: int, ending: str) -> list[str]:
    """An item or the end of a statement as lines, `ending` after it."""
    flat = " " * indent + _flat(parts) + ending
    if len(flat) <= WIDTH:
        return [flat]
    groups = [i for i, p in enumerate(parts) if isinstance(p, _Group) and p.items]
    if not groups:
        return [flat]
    return _open(parts, groups[-1], indent, ending)


def _item(parts: tuple[_Part, ...], indent: int, ending: str) -> list[str]:
    """An item of a group as lines."""
    lines = _lines(parts, indent, ending)
    if (
        len(lines) > 1
        or len(lines[0]) <= WIDTH
        or any(isinstance(part, _Group) for part in parts)
    ):
        return lines
    return _union(_flat(parts), indent, ending)


def _union(text: str, indent: int, ending: str) -> list[str]:
    """An item `A | None`, or `name: A | None`, whose type black splits before each `|`."""
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


def _open(parts: tuple[_Part, ...], index: int, indent: int, ending: str) -> list[str]:
    """The parts as lines with the group of that index opened."""
    group = parts[index]
    assert isinstance(group, _Group)
    lines = _lines((*parts[:index], group.opening), indent, "")
    items, comma = group.items, ","
    if not group.comma:
        body = " ".join([_flat(_parts(item)) for item in items])
        items = (body,) if indent + _STEP + len(body) <= WIDTH else items
        comma = ""
    for item in items:
        lines.extend(_item(_parts(item), indent + _STEP, comma))
    return lines + _lines((group.closing, *parts[index + 1 :]), indent, ending)


def _at_commas(parts: tuple[_Part, ...]) -> tuple[_Line, ...]:
    found: list[list[_Part]] = [[]]
    for part in parts:
        if part == ", ":
            found.append([])
        else:
            found[-1].append(part)
    return tuple(_Line(tuple(item)) for item in found)


def _parse(text: str) -> tuple[_Part, ...]:
    """The parts of a text: groups, and the tokens between them."""
    levels: list[list[list[_Part]]] = [[[]]]
    clauses: list[bool] = [False]
    for token in _TOKEN.findall(text):
        if token in _CLOSING:
            levels.append([[]])
            clauses.append(False)
        elif token in _OPENING:
            group = _group(token, levels.pop(), clauses.pop())
            levels[-1][-1].append(group)
        elif token == " for " and len(levels) > 1:
            levels[-1].append(["for "])
            clauses[-1] = True
        elif token[0] == "," and len(levels) > 1 and not clauses[-1]:
            levels[-1].append([])
        else:
            levels[-1][-1].append(token)
    return tuple(levels[0][0])


def _group(closing: str, items: list[list[_Part]], comprehension: bool) -> _Group:
    opening = _OPENING[closing]
    lines = tuple([_Line(tuple(item)) for item in items if item])
    comma = not comprehension and (opening != "[" or len(lines) != 1)
    inside = (", " if comma else " ").join([_flat(line.parts) for line in lines])
    # A single item keeps its trailing comma on one line too, as a tuple needs it.
    lone = "," if len(items) == 2 and not items[1] and len(lines) == 1 else ""
    return _Group(opening, lines, closing, f"{opening}{inside}{lone}{closing}", comma)


def header(
    version: str, sources: Iterable[str], owner: Owner = Owner.RTGEN
) -> tuple[str, ...]:
    """The lines of a generated file's header, without comment marks.

    `sources` are the keys of the inputs, each named once. Their digests are only in the manifest,
    so that a change of an input only changes affected files.
    """
    named = [comment_text(key) for key in dict.fromkeys(sources)]
    if owner is Owner.USER:
        return (
            f"Created once by rtgen {version} from {', '.join(named)}.",
            "Yours to edit: rtgen never touches it again.",
        )
    origin = (
        (f"from {named[0]}.",)
        if len(named) == 1
        else ("from", *(f"  {n}" for n in named))
    )
    return (
        f"Generated by rtgen {version} {origin[0]}",
        *origin[1:],
        "Owned by rtgen: edits are overwritten by the next run.",
    )


def header_comment(
    version: str, sources: Iterable[str], owner: Owner = Owner.RTGEN
) -> HashComment:
    """The header as a comment of Python and the like, with the newline at its end."""
    lines = header(version, sources, owner)
    return HashComment("".join(f"# {text}\n" for text in lines))
