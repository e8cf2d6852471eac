"""Layouts of values that are joined from parts: texts of any length, and what is between them.

One `struct` call for several texts needs a shape for each combination of their lengths, of which
there are too many to keep where lengths vary.
"""

from __future__ import annotations

from struct import Struct

import msgspec

from rtgen.runtime.marshalling.layouts.layout import (
    ALIGNED,
    Position,
    Run,
    Step,
    has_count,
    pad,
    steps_of,
    token_of,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    AtomSequence,
    Field,
    Node,
    Records,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.shapes import SHAPES_KEPT

PADDINGS = b"", b"\0\0\0", b"\0\0", b"\0"
"""Padding to a multiple of 4 by the count of octets modulo 4."""

NULS = tuple(b"\0" + padding for padding in PADDINGS)
"""The NUL of a string and its padding, by the count modulo 4."""


class _Heads(dict[int, bytes]):
    """Counts in octets, cleared when full."""

    def __init__(self, order: str) -> None:
        self._pack = Struct(f"{order}I").pack

    def __missing__(self, count: int) -> bytes:
        if len(self) >= SHAPES_KEPT:
            self.clear()
        head = self[count] = self._pack(count)
        return head


class Heads:
    """The counts before texts in each byte order."""

    heads_big = _Heads(">")
    heads_little = _Heads("<")


def formats_between(run: Run, start: Position) -> list[str] | None:
    """Return the formats before each text of a run and after the last one.

    None if it has less than two texts or other counts, or if a position depends on a length.
    """
    formats = [""]
    position, inside = start, False
    for field in run.fields:
        node = field.node
        is_text = isinstance(node, TextSequence)
        if not is_text and has_count(node):
            return None
        token, size, align = ("", 0, 4) if is_text else token_of(node)
        if position.modulus % align or (inside and align != 4):
            return None
        formats[-1] += pad(-position.remainder % align) + token.partition("/")[0]
        position, inside = position.aligned(align).after(size), is_text
        if is_text:
            formats.append("")
            position = ALIGNED
    return formats if len(formats) > 2 else None


def aligned_element(element: Node) -> Run | None:
    """Return the run of an element, padded so that the next one begins at a multiple of 4.

    None if elements do not begin at such multiples, or places in them depend on more than that.
    """
    steps: tuple[Step, ...] = steps_of(element, ALIGNED)
    if len(steps) != 1 or not isinstance(steps[0], Run) or not steps[0].known:
        return None
    run = steps[0]
    first = run.fields[0].node
    last = run.sections[-1]
    if last.counted is None or last.bulk:
        return None
    if not has_count(first) and token_of(first)[2] != 4:
        return None
    if size_at_end(run) is None or not _ends_aligned(run):
        return None
    padded = msgspec.structs.replace(last, text=f"{last.text} 0I")
    return msgspec.structs.replace(run, sections=(*run.sections[:-1], padded))


def _ends_aligned(run: Run) -> bool:
    """Return whether the end modulo 4 depends at most on a count at the very end."""
    offset = 0
    for number, field in enumerate(_tail(run)):
        _, size, align = token_of(field.node)
        if not number and align != 4:
            return False
        offset += -offset % align + size
    return offset % 4 == 0


def _tail(run: Run) -> list[Field]:
    """Return the fields after the last count."""
    places = [i for i, field in enumerate(run.fields) if has_count(field.node)]
    return list(run.fields[places[-1] + 1 :])


def size_at_end(run: Run) -> int | None:
    """Return the size of each item that ends a run; 4 if other values end it.

    None if the size of the items also depends on something else than their number.
    """
    match run.fields[-1].node:
        case TextSequence():
            return 1
        case AtomSequence(atom=atom):
            return atom.size
        case Records(length=None, stride=stride, padding=padding):
            return None if padding else stride
    return 4
