# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Sequences in memory that is allocated once, and the error for values that exceed it."""

from array import array


class SizeError(ValueError):
    """A value that is too large for the memory allocated for it."""


class Numbers:
    """A sequence of numbers of one `array` type code, in an array of fixed capacity.

    `first` is the initial value of the items.
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
        """Remove all items."""
        self._length = 0

    def append(self, value: float) -> None:
        """Add a number. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._items[self._length] = value
        self._length += 1


class Values:
    """A sequence of texts or structs in a list of fixed capacity.

    With `make`, its items are structs that are reused; else texts of at most `most` octets of
    UTF-8, with `None` for free places.
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
        """Remove all items."""
        self._length = 0

    def append(self, value: object) -> None:
        """Append an item; structs are copied. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._put(self._length, value)
        self._length += 1

    def next_free(self) -> object:
        """Return the next free struct, which becomes the last item. Raises SizeError."""
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
    """Replace the items of a sequence by those of another sequence or list. Raises SizeError."""
    if target is source:
        return
    target.clear()
    for i in range(len(source)):
        target.append(source[i])


def copy_array(target, source) -> None:
    """Replace the items of an array of fixed length. Raises SizeError."""
    if len(source) != len(target):
        raise SizeError(f"{len(source)} items for an array of {len(target)}")
    for i in range(len(target)):
        target[i] = source[i]


def bounded(value, most: int):
    """Return octets, or a text in UTF-8, of at most `most` octets. Raises SizeError."""
    length = len(value.encode()) if isinstance(value, str) else len(value)
    if length > most:
        raise SizeError(f"{length} octets, room for {most}")
    return value


def exactly(value, length: int):
    """Return the octets of an array of exactly `length`. Raises SizeError."""
    if len(value) != length:
        raise SizeError(f"{len(value)} octets for an array of {length}")
    return value
