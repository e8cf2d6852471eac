"""Tables of `struct` calls for the runs of a layout.

A run is given as sections of tokens. `I`, `3d`, `*i` are `struct` codes: one, three, as many as the
next count; `*48o/8` is 48 octets each, aligned to 8; `*48o/8-4` is 4 octets less in total; `*z` is
octets of which the last one, a string's NUL, is read separately. A leading `@4` says that the
section starts at an offset of 4 modulo 8; `=` that padding is fixed and the rest is a `struct`
format; `!` that `struct` does not read the section. A negative count is a number of items that are
packed as octets, or skipped when the section is read.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from struct import Struct
from typing import Any, TypeAlias, TypeVar

from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.layouts.envelopes import framing
from rtgen.runtime.marshalling.layouts.layout import (
    Run,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Records,
)
from rtgen.runtime.marshalling.layouts.packers import packer, struct_of

_V = TypeVar("_V")
_Reader: TypeAlias = tuple[Callable[..., tuple[Any, ...]], int]

SHAPES_KEPT = 512
"""Maximum number of cached shapes; a full table is cleared."""

_TOKEN = re.compile(r"(\*?)(\d*)([a-zA-Z])(?:/(\d+))?(?:-(\d+))?(?: |$)")
_SIZES = {
    "b": 1,
    "B": 1,
    "c": 1,
    "o": 1,
    "s": 1,
    "z": 1,
    "h": 2,
    "H": 2,
    "i": 4,
    "I": 4,
    "f": 4,
}


class Fixed:
    """Layout of a value of fixed size: one `Struct` for each byte order."""

    __slots__ = (
        "pack_big",
        "pack_little",
        "records_big",
        "records_little",
        "unpack_big",
        "unpack_little",
    )

    def __init__(self, format_: str) -> None:
        little, big = struct_of("<", format_), struct_of(">", format_)
        self.pack_little = packer("<", format_)
        self.pack_big = packer(">", format_)
        self.unpack_little: Callable[[Buffer], tuple[Any, ...]] = little.unpack
        self.unpack_big: Callable[[Buffer], tuple[Any, ...]] = big.unpack
        self.records_little: Callable[[Buffer], Iterator[tuple[Any, ...]]] = (
            little.iter_unpack
        )
        self.records_big: Callable[[Buffer], Iterator[tuple[Any, ...]]] = (
            big.iter_unpack
        )


class Settled:
    """Layout of a run without counts that is read in several sections.

    `read_*` has the `unpack_from` of each section.
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        whole = "".join(section[1:] for section in sections)
        self.pack_little = packer("<", whole)
        self.pack_big = packer(">", whole)
        self.read_little = tuple(_reader("<", s) for s in sections)
        self.read_big = tuple(_reader(">", s) for s in sections)


class Layout:
    """Layout of a run of values whose size depends on the counts in it.

    `pack_*` is a table from counts (a single one, or a tuple) to the packer of the shape. `read_*`
    has one reader for each section: `unpack_from` for a fixed one, else a table of (`unpack_from`,
    size) by count (0 without a count).
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        self.pack_little: Mapping[Any, Callable[..., bytes]] = _Shapes("<", *sections)
        self.pack_big: Mapping[Any, Callable[..., bytes]] = _Shapes(">", *sections)
        self.read_little, self.read_big = _readers("<", sections), _readers(
            ">", sections
        )


class Recurrent:
    """Layout of a whole value with several texts: `pack_*` as in `Layout`, for the first shapes.

    Later shapes have None: where lengths vary, making a shape takes ten times as long as the rest.
    """

    __slots__ = ("pack_big", "pack_little")

    def __init__(self, run: Run) -> None:
        texts = [section.text for section in run.sections]
        self.pack_little = _FirstShapes("<", *texts)
        self.pack_big = _FirstShapes(">", *texts)


class PhasedLayout:
    """Layout of a run whose start offset is known only at run time.

    `pack_*` takes the offset modulo 8 before the counts. A table of `read_*` is by count if its
    section's start is given (`@`), else by `count << 3 | offset & 7`.
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        little, big = _PhasedShapes("<", *sections), _PhasedShapes(">", *sections)
        self.pack_little: Mapping[Any, Callable[..., bytes]] = little
        self.pack_big: Mapping[Any, Callable[..., bytes]] = big
        self.read_little, self.read_big = _readers("<", sections), _readers(
            ">", sections
        )


class Framed:
    """Layout of a whole value with the headers of `framing`; `pack_*` as in `Layout`.

    Without counts it is the packer itself. `number` is the identifier in big-endian order.
    """

    __slots__ = ("pack_big", "pack_little")

    def __init__(self, run: Run, number: int | None, delimited: bool) -> None:
        little = None if number is None else number | 1
        self.pack_little = _framed("<", run, little, delimited)
        self.pack_big = _framed(">", run, number, delimited)


def _framed(order: str, run: Run, number: int | None, delimited: bool) -> Any:
    texts = [section.text for section in run.sections]
    if all(section.settled for section in run.sections):
        return framing(order, "".join(text[1:] for text in texts), number, delimited)
    return _FramedShapes(order, number, delimited, *texts)


def _readers(order: str, sections: Iterable[str]) -> tuple[Any, ...]:
    """Return the readers of the sections that `struct` reads."""
    return tuple(_reader(order, s) for s in sections if s[0] != "!")


def _reader(order: str, section: str) -> Any:
    if section[0] == "=":
        return struct_of(order, section[1:]).unpack_from
    kind = _Readers if section[0] == "@" else _PhasedReaders
    return kind(order, section)


class _Table(dict[Any, _V], ABC):
    """A cache filled on lookup, cleared when full."""

    def __init__(self, order: str, *sections: str) -> None:
        self._order = order
        self._sections = sections

    def __missing__(self, key: Any) -> _V:
        if len(self) >= SHAPES_KEPT:
            self.clear()
        value = self[key] = self._new(key)
        return value

    @abstractmethod
    def _new(self, key: Any) -> _V:
        """Compute the value of a key."""

    def shape(self, counts: Iterable[int]) -> Struct:
        """Return the shape of these counts, from offset 0, for reading."""
        return self._reading(0, counts)

    def _reading(self, phase: int, counts: Iterable[int]) -> Struct:
        arranged = _arranged(self._sections, phase, iter(counts), True)
        return struct_of(self._order, arranged)

    def _packing(self, phase: int, counts: Iterable[int]) -> Callable[..., bytes]:
        arranged = _arranged(self._sections, phase, iter(counts), False)
        return packer(self._order, arranged)


class _Shapes(_Table[Callable[..., bytes]]):
    def _new(self, key: Any) -> Callable[..., bytes]:
        return self._packing(0, key if isinstance(key, tuple) else (key,))


class _FirstShapes(_Table[Callable[..., bytes] | None]):
    def __missing__(self, key: Any) -> Callable[..., bytes] | None:
        return super().__missing__(key) if len(self) < SHAPES_KEPT else None

    def _new(self, key: Any) -> Callable[..., bytes]:
        return self._packing(0, key)


class _FramedShapes(_Table[Callable[..., bytes]]):
    def __init__(
        self, order: str, number: int | None, delimited: bool, *sections: str
    ) -> None:
        super().__init__(order, *sections)
        self._headers = number, delimited

    def _new(self, key: Any) -> Callable[..., bytes]:
        counts = iter(key if isinstance(key, tuple) else (key,))
        arranged = _arranged(self._sections, 0, counts, False)
        return framing(self._order, arranged, *self._headers)


class _PhasedShapes(_Table[Callable[..., bytes]]):
    def _new(self, key: Any) -> Callable[..., bytes]:
        phase, *counts = key if isinstance(key, tuple) else (key,)
        return self._packing(phase, counts)


class _Readers(_Table[_Reader]):
    def _new(self, key: int) -> _Reader:
        reader = self._reading(int(self._sections[0][1]), (key,))
        return reader.unpack_from, reader.size


class _PhasedReaders(_Table[_Reader]):
    def _new(self, key: int) -> _Reader:
        reader = self._reading(key & 7, (key >> 3,))
        return reader.unpack_from, reader.size


def _arranged(
    sections: Iterable[str], phase: int, counts: Iterator[int], reads: bool
) -> str:
    """Return the `struct` format of the sections from offset `phase`."""
    texts: list[str] = []
    offset = phase
    for section in sections:
        if section[0] == "=":
            texts.append(section[1:])
            offset += struct_of("<", section[1:]).size
            continue
        for star, digits, code, align, less in _TOKEN.findall(section):
            number = int(digits or 1) * (next(counts) if star else 1)
            if less and number:
                number -= int(less)
            size = _SIZES.get(code, 8)
            padding = -offset % int(align or size) if number or not star else 0
            if number < 0:
                number *= -size
                code, size = "x" if reads else "o", 1
            text = f"{number}{code}"
            if code == "z":
                text = f"{number - 1}s{'B' if reads else 'x'}" if number else "0s0s"
            texts.append(f"{padding}x{text}")
            offset += padding + number * size
    return "".join(texts)


class Layouts:
    """The tables of a function's runs, numbered."""

    def __init__(self) -> None:
        self._numbers: dict[int, int] = {}
        self._shapes: list[tuple[Run | Records, Any]] = []

    def of(self, part: Run | Records, whole: bool = False) -> Any:
        """Return the table of a run (`whole`: of a whole value), or of a record's element."""
        return self._shapes[self._number(part, whole) - 1][1]

    def variable(self, kind: str, part: Run | Records) -> str:
        """Return the variable for an attribute of a table."""
        return f"{kind}_{self._number(part)}"

    def _number(self, part: Run | Records, whole: bool = False) -> int:
        if id(part) not in self._numbers:
            self._shapes.append((part, _table(part, whole)))
            self._numbers[id(part)] = len(self._shapes)
        return self._numbers[id(part)]


def _table(part: Run | Records, whole: bool) -> Fixed | Settled | Layout | PhasedLayout:
    if isinstance(part, Records):
        return Fixed(part.format)
    texts = [section.text for section in part.sections]
    if all(section.settled for section in part.sections):
        return Fixed(texts[0][1:]) if whole and len(texts) == 1 else Settled(*texts)
    return Layout(*texts) if part.known else PhasedLayout(*texts)
