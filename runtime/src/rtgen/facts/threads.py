"""Which threads execution contexts tick in, in real time."""

from __future__ import annotations

from enum import StrEnum


class Threads(StrEnum):
    """`shared`: one thread for all contexts, but those that block; `own`: one for each."""

    SHARED = "shared"
    OWN = "own"
