# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Sequences in memory that is set aside once, and what is too large for it."""

from array import array


class SizeError(ValueError):
    """A value that is larger than the room that was set aside for it."""


class Numbers:
    """A sequence of numbers of one `array` type code, in an array that never grows.

    `first` is what the items are at first.
    """

    __slots__ = ("_items", "_length")

    def __init__(self, code: str, room: int, length: int = 0, first: int = 0) -> None:
        self._items: array[float] = array(code, [first] * room)
        self._length = length

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> float:
        return self._items[_place(index, self._length)]

    def __setitem__(self, index: int, value: float) -> None:
        self._items[_place(index, self._length)] = value

    def clear(self) -> None:
        """Make it empty."""
        self._length = 0

    def append(self, value: float) -> None:
        """Add a number. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._items[self._length] = value
        self._length += 1


class Values:
    """A sequence of texts or structs in a list that never grows.

    With `make` its items are structs that are filled in place; else texts of at most `most` octets
    of UTF-8, and `None` marks what is free.
    """

    __slots__ = ("_items", "_length", "_make", "_most")

    def __init__(
        self, make: "type | None", room: int, length: int = 0, most: int = 0
    ) -> None:
        self._make = make
        self._most = most
        self._items: list[object] = [make() if make else None for _ in range(room)]
        self._length = length

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> object:
        return self._items[_place(index, self._length)]

    def __setitem__(self, index: int, value: object) -> None:
        self._put(_place(index, self._length), value)

    def clear(self) -> None:
        """Make it empty."""
        self._length = 0

    def append(self, value: object) -> None:
        """Add an item, structs by value. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._put(self._length, value)
        self._length += 1

    def next_free(self) -> object:
        """Return the struct behind the last, which from now on belongs to it. Raises SizeError."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._length += 1
        return self._items[self._length - 1]

    def _put(self, place: int, value: object) -> None:
        if self._make:
            self._items[place]._copy_(value)  # type: ignore[attr-defined]
        else:
            self._items[place] = bounded(value, self._most)


def _place(index: int, length: int) -> int:
    if index < 0:
        index += length
    if not 0 <= index < length:
        raise IndexError("index out of range")
    return index


def copy_items(target, source) -> None:
    """Replace the items of a sequence by those of another one or of a list. Raises SizeError."""
    if target is source:
        return
    target.clear()
    for i in range(len(source)):
        target.append(source[i])


def copy_array(target, source) -> None:
    """Replace the items of an array, whose length is fixed. Raises SizeError."""
    if len(source) != len(target):
        raise SizeError(f"{len(source)} items for an array of {len(target)}")
    for i in range(len(target)):
        target[i] = source[i]


def bounded(value, most: int):
    """Octets, or a text in UTF-8, that are at most so long. Raises SizeError."""
    length = len(value.encode()) if isinstance(value, str) else len(value)
    if length > most:
        raise SizeError(f"{length} octets, room for {most}")
    return value


def exactly(value, length: int):
    """Octets of an array, which are exactly so many. Raises SizeError."""
    if len(value) != length:
        raise SizeError(f"{len(value)} octets for an array of {length}")
    return value
