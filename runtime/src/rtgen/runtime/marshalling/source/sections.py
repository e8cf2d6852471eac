"""Generates the text that reads the sections of a run."""

from __future__ import annotations

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.runtime.marshalling.layouts.layout import (
    Entry,
    Run,
    Section,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    AtomSequence,
    Field,
    Path,
    Records,
    Text,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.shapes import Layouts
from rtgen.runtime.marshalling.source.bulk import Sequences, Structured
from rtgen.runtime.marshalling.source.position import Position
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.text import Body, Locals


class Sections(Position):
    """A function under construction that reads runs.

    `_following` are values of the next element, which have variables of their own.
    """

    def __init__(self, references: References) -> None:
        super().__init__(Body(references.namespace))
        self._refer = references
        self._layouts = Layouts()
        self._locals = Locals(references.namespace)
        self._readers = 0
        self._following: tuple[Entry, ...] = ()

    def _run(self, run: Run, prefix: Path) -> None:
        readers = self._chosen(run)
        remaining = iter(readers)
        for section in run.sections:
            if section.bulk and section.counted is not None:
                self._take(section.counted, prefix, "offset")
                self._offset = None
            else:
                self._section(section, next(remaining), prefix)

    def _chosen(self, run: Run) -> list[str]:
        """Return the variables for the readers of a run's sections."""
        readers = []
        for section in run.sections:
            if not section.bulk:
                self._readers += 1
                readers.append(f"read_{self._readers}")
        targets = ", ".join(readers) if len(readers) > 1 else f"({readers[0]},)"
        number = self._layouts.variable("readers", run)
        self.body.choose(targets, number, self._layouts.of(run), "read")
        return readers

    def _take(self, field: Field, prefix: Path, end: str) -> None:
        """Generate the items of a sequence, read in one piece; the next offset is in `end`."""
        node = field.node
        assert isinstance(node, AtomSequence | Records)
        path = (*prefix, *field.path)
        layout = Sequences(node) if isinstance(node, AtomSequence) else Structured(node)
        take = self._locals.name(path, "take_")
        self.body.choose(take, take, layout, "take")
        name, count = self._locals.name(path), self._locals.name(path, "n_")
        self.body.add(f"{name}, {end} = {take}(data, {self._place()}, {count})")

    def _section(self, section: Section, reader: str, prefix: Path) -> None:
        targets = self._targets(section.entries, prefix)
        place = "" if self._offset == 0 else f", {self._place()}"
        if section.settled:
            self._assign(targets, f"{reader}(data{place})")
            self._advance(section.size)
        else:
            body = self.body
            counted = section.counted
            long = counted is not None and getattr(counted.node, "form", "") == "array"
            if long:
                assert counted is not None
                count = self._locals.name((*prefix, *counted.path), "n_")
                rest = [e for e in section.entries if e.field is not counted or e.count]
                body.block(f"if {count} > {MAX_LIST_LENGTH}:")
                self._take(counted, prefix, "_")
                key = self._key(section, prefix, "-")
                body.add(f"unpack, size = {reader}[{key}]")
                if rest:
                    skipped = self._targets(tuple(rest), prefix)
                    body.add(f"{skipped} = unpack(data{place})")
                body.end()
                body.block("else:")
            body.add(f"unpack, size = {reader}[{self._key(section, prefix)}]")
            self._assign(targets, f"unpack(data{place})")
            if long:
                body.end()
            if self._offset is None:
                self.body.add("offset += size")
            else:
                self.body.add(
                    f"offset = {self._offset} + size"
                    if self._offset
                    else "offset = size"
                )
                self._offset = None
        for entry in section.entries:
            self._check(entry, prefix)

    def _assign(self, targets: str, call: str) -> None:
        if targets.startswith("(*"):
            self.body.add(f"{targets[2:-2]} = list({call})")
        else:
            self.body.add(f"{targets} = {call}")

    def _key(self, section: Section, prefix: Path, sign: str = "") -> str:
        count = "0"
        if section.counted is not None:
            name = self._locals.name((*prefix, *section.counted.path), "n_")
            count = f"{sign}{name}"
        if section.known:
            return count
        phase = f"{self._place()} & 7"
        return phase if section.counted is None else f"{count} << 3 | {phase}"

    def _targets(self, entries: tuple[Entry, ...], prefix: Path) -> str:
        names = []
        for entry in entries:
            name = self._name(entry, prefix)
            names.append(f"*{name}" if entry.star else name)
            names += self._further(entry, prefix)
        if len(names) > 1:
            return ", ".join(names)
        return f"({names[0]},)"

    def _name(self, entry: Entry, prefix: Path = ()) -> str:
        path = (*prefix, *entry.field.path)
        if not entry.count and any(entry is following for following in self._following):
            return self._locals.name(path, "next_")
        return self._locals.name(path, "n_" if entry.count else "")

    def _further(self, entry: Entry, prefix: Path = ()) -> list[str]:
        """Return the variable for the last octet of a string, which `struct` reads separately."""
        if entry.count or getattr(entry.field.node, "text", None) is not Text.STRING:
            return []
        return [self._locals.name((*prefix, *entry.field.path), "nul_")]

    def _check(self, entry: Entry, prefix: Path) -> None:
        """Generate the check of the bound, directly after reading the count."""
        node = entry.field.node
        bound = (
            node.most
            if isinstance(node, TextSequence)
            else getattr(node, "bound", None)
        )
        if entry.count and bound is not None:
            count = self._locals.name((*prefix, *entry.field.path), "n_")
            self.refuse(f"{count} > {bound}")
