"""Base class of values that are compared without their places or spelling."""

from __future__ import annotations

from typing import ClassVar

import msgspec


class Unspelled(msgspec.Struct, frozen=True, eq=False):
    """A value whose comparison ignores the fields listed in `spelling`."""

    spelling: ClassVar[frozenset[str]] = frozenset()

    def _facts(self) -> tuple[object, ...]:
        return tuple(
            getattr(self, name)
            for name in self.__struct_fields__
            if name not in self.spelling
        )

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, Unspelled)
        return self._facts() == other._facts()

    def __hash__(self) -> int:
        return hash(self._facts())
