"""Specialised readers of bodies with recurring counts, by one `struct` call.

Samples of robots often have the same shape: covariances of nine numbers, names of a frame. A
function that has seen a shape several times gets a reader for it, selected by the size of the body.
The reader compares the counts; if they differ, the function reads section by section.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from math import prod
from typing import Any, Final, TypeAlias

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.runtime.marshalling.layouts.layout import Entry, Run, Step
from rtgen.runtime.marshalling.layouts.nodes import (
    AtomArray,
    AtomSequence,
    Records,
    TextSequence,
)
from rtgen.runtime.marshalling.source.text import Namespace, entered

SIGHTINGS: Final = 16
"""Number of bodies of one shape before it gets a reader."""

WATCHED: Final = 1000
"""Maximum number of bodies without a reader that are counted by shape."""

READERS_KEPT: Final = 16
"""Maximum number of readers of a type."""

MAX_BODY: Final = 4096
"""Maximum octets of a body that gets a reader."""

Counts: TypeAlias = tuple[int, ...]
_Reader: TypeAlias = Callable[[type[Any], Any], Any]


def is_repeatable(steps: tuple[Step, ...]) -> bool:
    """Return whether a value's shape depends on counts in one run, of numbers and texts.

    Lengths of texts alone rarely recur: unsuccessful lookups cost more than a reader saves.
    """
    if len(steps) != 1 or not isinstance(steps[0], Run):
        return False
    sections = steps[0].sections
    nodes = [entry.field.node for section in sections for entry in section.entries]
    counted = [section.counted for section in sections if section.counted is not None]
    if not steps[0].known or any(section.bulk for section in sections):
        return False
    if not any(isinstance(field.node, AtomSequence) for field in counted):
        return False
    return not any(
        isinstance(n, Records) or (isinstance(n, AtomArray) and n.form != "list")
        for n in nodes
    ) and all(
        isinstance(field.node, TextSequence)
        or (isinstance(field.node, AtomSequence) and field.node.form != "numpy")
        for field in counted
    )


class Repeated:
    """The readers of a function by size of the body, and the data for making them.

    `layout` is the table of the run; `names` returns the variable of an entry, `further` those
    after it; `value` is the expression of the value.
    """

    def __init__(
        self,
        run: Run,
        layout: Any,
        names: Callable[[Entry], str],
        further: Callable[[Entry], list[str]],
        value: str,
        namespace: Namespace,
        title: str,
    ) -> None:
        self.little: dict[int, _Reader] = {}
        self.big: dict[int, _Reader] = {}
        self.watching = [self._watch]
        self._run = run
        self._layout = layout
        self._names = names
        self._further = further
        self._value = value
        self._namespace = namespace
        self._title = title
        self._left = WATCHED
        self._seen: dict[tuple[int, bool, Counts], int] = {}

    def lines(self, lines: list[str]) -> list[str]:
        """Return the body of the function around the lines that read section by section."""
        bind, free = self._namespace.bind, self._namespace.free
        little, big = bind("repeated_little", self.little), bind(
            "repeated_big", self.big
        )
        watching = bind("watching", self.watching)
        read, made, watch = free("read"), free("made"), free("watch")
        counts = ", ".join(self._names(e) for e in self._entries() if e.count)
        return [
            f"{read} = ({little} if little_endian else {big}).get(len(data))",
            f"if {read} is not None:",
            f"    {made} = {read}(cls, data)",
            f"    if {made} is not None:",
            f"        return {made}",
            *lines[:-1],
            f"for {watch} in {watching}:",
            f"    {watch}(len(data), little_endian, ({counts},))",
            lines[-1],
        ]

    def _entries(self) -> Iterator[Entry]:
        for section in self._run.sections:
            yield from section.entries

    def _watch(self, size: int, little_endian: bool, counts: Counts) -> None:
        """Count a body that was read section by section."""
        readers = self.little if little_endian else self.big
        key = size, bool(little_endian), counts
        self._seen[key] = seen = self._seen.get(key, 0) + 1
        if seen == SIGHTINGS and size not in readers and self._is_small(size, counts):
            readers[size] = self._reader(counts, little_endian)
        self._left -= 1
        if not self._left or len(self.little) + len(self.big) == READERS_KEPT:
            self.watching.clear()
            self._seen.clear()

    def _is_small(self, size: int, counts: Counts) -> bool:
        counted = [entry.field.node for entry in self._entries() if entry.count]
        items = [
            count
            for node, count in zip(counted, counts, strict=True)
            if isinstance(node, AtomSequence)
        ]
        return size <= MAX_BODY and sum(items) <= MAX_LIST_LENGTH

    def _reader(self, counts: Counts, little_endian: bool) -> _Reader:
        """Return the compiled reader of a shape, which returns None for another one."""
        following = iter(counts)
        numbers = (f"_{number}" for number in range(1 << 30))
        targets: list[str] = []
        conditions: list[str] = []
        gathered: list[str] = []
        known: dict[int, int] = {}
        for entry in self._entries():
            name, node = self._names(entry), entry.field.node
            if entry.count:
                count = known[id(entry.field)] = next(following)
                conditions.append(f"{name} != {count}")
            elif entry.star:
                length = (
                    prod(node.dimensions)
                    if isinstance(node, AtomArray)
                    else known[id(entry.field)]
                )
                items = [*islice(numbers, length)]
                gathered.append(f"    {name} = [{', '.join(items)}]")
                targets += items
                continue
            targets += [name, *self._further(entry)]
        table = self._layout.pack_little if little_endian else self._layout.pack_big
        text = "\n".join(
            [
                "def read(cls, data):",
                f"    {', '.join(targets)}, = unpack(data)",
                f"    if {' or '.join(conditions)}:",
                "        return None",
                *gathered,
                f"    return {self._value}\n",
            ]
        )
        order = "little" if little_endian else "big"
        file = entered(text, f"<{self._title}, {order}-endian, counts {counts}>")
        unpack = table.shape(counts).unpack
        values = {**self._namespace.values, "unpack": unpack}
        values["little_endian"] = little_endian
        namespace: dict[str, _Reader] = {}  # a class may have the function's name
        exec(compile(text, file, "exec"), values, namespace)
        return namespace["read"]
