"""Typed access to the values of an object dictionary: the base of generated `<Module>Objects`."""

from __future__ import annotations

from typing import Any, Generic, Self, TypeVar, cast, overload

from rtgen.runtime.canopen.hooks import Getter, Setter

T = TypeVar("T")


class Objects:
    """Values by the names of their objects. A generated class has an `Entry` for each of them.

    `get` and `set_` are asked for a value by index and sub-index.
    """

    __slots__ = ("_get", "_set")

    def __init__(self, get: Getter, set_: Setter) -> None:
        self._get = get
        self._set = set_


class Entry(Generic[T]):
    """The attribute for a variable."""

    __slots__ = ("number",)

    def __init__(self, index: int, subindex: int = 0) -> None:
        self.number = index, subindex

    @overload
    def __get__(self, owner: None, class_: type[Objects]) -> Self: ...

    @overload
    def __get__(self, owner: Objects, class_: type[Objects]) -> T: ...

    def __get__(self, owner: Objects | None, class_: type[Objects]) -> Self | T:
        return self if owner is None else cast("T", owner._get(self.number))

    def __set__(self, owner: Objects, value: T) -> None:
        owner._set(self.number, cast("Any", value))
