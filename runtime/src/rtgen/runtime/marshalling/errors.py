"""Errors of codecs: `CdrError`, and faults in nested values, whose path each level extends."""

from __future__ import annotations

import struct
from typing import TypeAlias

Buffer: TypeAlias = bytes | bytearray | memoryview
"""Types of input data."""

FAILURES = (
    struct.error,
    ArithmeticError,
    AttributeError,
    BufferError,
    LookupError,
    NotImplementedError,
    RecursionError,
    TypeError,
    ValueError,
)
"""The exceptions of a codec for an invalid value or input."""


class CdrError(ValueError):
    """A value that cannot be marshalled, or octets that cannot be unmarshalled.

    `path` names the place: `TimedPose2D.data.position.x`, `Path.points[3].y`.
    """

    def __init__(self, path: str, message: str) -> None:
        self.path = path
        self.message = message
        super().__init__(f"{path}: {message}")

    def __reduce__(self) -> tuple[type[CdrError], tuple[str, str]]:
        return (CdrError, (self.path, self.message))


class Fault(ValueError):
    """An error with its place: the parts of the path, innermost first."""

    def __init__(self, message: str) -> None:
        self.message = message
        self.parts: list[str] = []
        super().__init__(message)

    def error(self, root: str) -> CdrError:
        """Return the exception to raise; the path starts at `root`."""
        return CdrError(root + "".join(reversed(self.parts)), self.message)


LOCATED = tuple(f for f in FAILURES if f is not RecursionError)
"""Exceptions that get a path. Infinite recursion gets none."""


def located(failure: Exception, part: str) -> Fault:
    """Convert an exception to a fault, or extend the path of a fault."""
    if not isinstance(failure, Fault):
        failure = Fault(str(failure) or type(failure).__name__)
    failure.parts.append(part)
    return failure
