"""Common base of the nodes of all syntax trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar, dataclass_transform

T = TypeVar("T")


@dataclass_transform(eq_default=False, frozen_default=True)
def node(cls: type[T]) -> type[T]:
    """A frozen dataclass for type checkers; nothing at run time enforces it, which would make
    the parser slower by a sixth."""
    return dataclass(slots=True, eq=False, repr=False)(cls)
