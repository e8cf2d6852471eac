"""Faults on their way out of a value: each level that they pass adds its part of the path."""

from __future__ import annotations

from rtgen.runtime.cdr import FAILURES, CdrError


class Fault(ValueError):
    """What is wrong, and where: the parts of the path, the innermost first."""

    def __init__(self, message: str) -> None:
        self.message = message
        self.parts: list[str] = []
        super().__init__(message)

    def error(self, root: str) -> CdrError:
        """The error to raise, with its path from `root` on."""
        return CdrError(root + "".join(reversed(self.parts)), self.message)


LOCATED = tuple(f for f in FAILURES if f is not RecursionError)
"""What gets a place. A recursion without end has none."""


def located(failure: Exception, part: str) -> Fault:
    """The failure as a fault, with a further part of its path in front."""
    if not isinstance(failure, Fault):
        failure = Fault(str(failure) or type(failure).__name__)
    failure.parts.append(part)
    return failure
