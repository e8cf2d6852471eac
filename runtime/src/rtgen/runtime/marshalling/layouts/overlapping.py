"""Layouts by which the elements of a sequence are read: the end of one with the count in the next.

A `struct` call reads the rest of an element, and what the next one begins with.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec

from rtgen.runtime.marshalling.layouts.layout import (
    ANYWHERE,
    Entry,
    Run,
    fields_of,
    steps_of,
    steps_of_fields,
)
from rtgen.runtime.marshalling.layouts.nodes import Node, TextSequence


class Overlapping(NamedTuple):
    """The runs of the elements in a sequence.

    `first` begins the first element. `rest` is the remainder of an element, and the values that
    begin the next one (`following`). `last` is read instead of the last section of `rest` at the
    end: it has no octets for those values.
    """

    first: Run
    rest: Run
    last: Run
    following: tuple[Entry, ...]


def overlapping(element: Node) -> Overlapping | None:
    """Return the runs of an element; None if a `struct` call would not be saved."""
    steps = steps_of(element, ANYWHERE)
    if len(steps) != 1 or not isinstance(steps[0], Run) or len(steps[0].sections) < 2:
        return None
    run = steps[0]
    begin = run.sections[0]
    ends_with_list = any(entry.star for entry in run.sections[-1].entries)
    if ends_with_list or any(section.bulk for section in run.sections):
        return None
    if any(entry.star or _has_bound(entry) for entry in begin.entries):
        return None
    (twice,) = steps_of_fields(2 * fields_of(element), ANYWHERE)
    assert isinstance(twice, Run)
    rest = twice.sections[1 : len(run.sections)]
    if len(twice.sections) != 2 * len(run.sections) - 1 or twice.known:
        return None
    final = rest[-1]
    number = len(begin.entries)
    tokens = final.text.split(" ")[:-number]
    last = msgspec.structs.replace(final, text=" ".join(tokens + number * ["0s"]))
    return Overlapping(
        msgspec.structs.replace(twice, sections=(begin,)),
        msgspec.structs.replace(twice, sections=rest),
        msgspec.structs.replace(twice, sections=(last,)),
        final.entries[-number:],
    )


def _has_bound(entry: Entry) -> bool:
    node = entry.field.node
    bound = (
        node.most if isinstance(node, TextSequence) else getattr(node, "bound", None)
    )
    return entry.count and bound is not None
