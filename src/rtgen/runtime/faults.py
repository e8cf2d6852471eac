"""Errors in nested values: each level adds its part of the path."""

from __future__ import annotations

from rtgen.runtime.cdr import FAILURES, CdrError


class Fault(ValueError):
    """The error and its place: the parts of the path, innermost first."""

    def __init__(self, message: str) -> None:
        self.message = message
        self.parts: list[str] = []
        super().__init__(message)

    def error(self, root: str) -> CdrError:
        """The exception to raise, with the path starting at `root`."""
        return CdrError(root + "".join(reversed(self.parts)), self.message)


LOCATED = tuple(f for f in FAILURES if f is not RecursionError)
"""Exceptions that get a path. Infinite recursion has none."""


def located(failure: Exception, part: str) -> Fault:
    """Convert an exception to a fault, or extend the path of a fault."""
    if not isinstance(failure, Fault):
        failure = Fault(str(failure) or type(failure).__name__)
    failure.parts.append(part)
    return failure
