"""The last large arrays of numbers, to reuse the memory of those that are no longer in use.

`array` allocates memory only by filling it, which takes more than half as long as a copy. In
CPython, the number of references to an array shows whether anything else refers to it; `zip` reuses
its tuple for the same reason. Views of an array refer to it, too.
"""

from __future__ import annotations

import sys
from array import array
from collections import deque
from operator import call
from typing import Any, Generic, TypeVar
from weakref import getweakrefcount

from rtgen.runtime.marshalling.reference_counts import EXACT

_KEPT = 4
_MAX_OCTETS = 2 << 20
"""Maximum size of each array, so that at most four times as much memory is kept."""

_A = TypeVar("_A", bound="array[Any]")


_COUNTS = sys.getrefcount, getweakrefcount


def _oldest(arrays: deque[_A]) -> tuple[list[_A], int, int]:
    """Remove the oldest array; return it in a list, and the numbers of references to it.

    No local variable refers to the array, and both calls are one step of the interpreter, so that
    neither a tracer nor a signal handler can change one of the numbers.
    """
    held = [arrays.popleft()]
    references, weak_references = map(call, _COUNTS, held * 2)
    return held, references, weak_references


_UNUSED = _oldest(deque([array("b")]))[1] if EXACT else 0
"""The number of references to an array to which only `_oldest` refers; 0 if it is not exact."""


class LastArrays(Generic[_A]):
    """A few of the last arrays, from the oldest to the newest."""

    def __init__(self) -> None:
        self._arrays: deque[_A] = deque(maxlen=_KEPT if _UNUSED else 0)

    def unused(self, code: str, count: int) -> _A | None:
        """Return the oldest array if it has this type and length, and nothing refers to it."""
        if len(self._arrays) < _KEPT:
            return None
        try:
            held, *references = _oldest(self._arrays)
        except IndexError:  # other threads have taken all
            return None
        if references != [_UNUSED, 0]:
            return None
        oldest = held.pop()
        fits = len(oldest) == count and oldest.typecode == code
        return oldest if fits else None

    def keep(self, array: _A) -> None:
        """Add the newest array."""
        if len(array) * array.itemsize <= _MAX_OCTETS:
            self._arrays.append(array)
