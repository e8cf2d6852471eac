"""Base class of the nodes of all syntax trees."""

from __future__ import annotations

from typing import dataclass_transform

import msgspec


@dataclass_transform(eq_default=False, frozen_default=True)
class Node(msgspec.Struct, frozen=True, eq=False):
    """A frozen node that is compared by identity."""


class Spanned(Node):
    """A node with the offsets of its text, [start, end)."""

    start: int
    end: int
