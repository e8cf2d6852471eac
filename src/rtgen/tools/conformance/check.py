"""A check of a conformance test, of any kind of subject."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Final, Generic, Protocol, TypeAlias, TypeVar

from rtgen.tools.conformance.report import Outcome, Verdict

Problems: TypeAlias = Iterator[str | None]
"""A problem for each thing checked, None if it passed."""


def unequal(what: str, actual: object, expected: object) -> str | None:
    """Return the problem of a value that is not the expected one."""
    return None if actual == expected else f"{what} is {actual!r}, not {expected!r}"


class Subject(Protocol):
    """The tested subject; `faults` are the exceptions that mean that a check failed."""

    faults: ClassVar[tuple[type[Exception], ...]]

    def explained(self, fault: Exception) -> str:
        """Return a fault as a problem of the check."""


S = TypeVar("S", bound=Subject)


class SkipError(Exception):
    """The check is not applicable, or not permitted; the text says why."""


class Permission(Enum):
    """A permission for checks: the option, and why a check is skipped without it."""

    ACTUATE = "it may move something: --actuate"
    DEFAULTS = "values may have been set on purpose: --defaults"
    EXIT = "it ends the component: --exit"


ACTUATE: Final = Permission.ACTUATE


@dataclass(frozen=True, slots=True)
class Check(Generic[S]):
    """A check: its name in reports, its assertion, the clause of the standard, its function.

    A check that needs a permission only runs if that is given.
    """

    name: str
    title: str
    clause: str
    run: Callable[[S], Problems]
    needs: Permission | None = None

    def outcome(self, subject: S, permissions: Collection[Permission]) -> Outcome:
        """Run the check on a subject."""
        if self.needs is not None and self.needs not in permissions:
            return self.skipped(self.needs.value)
        tried = 0
        problems: list[str] = []
        try:
            for problem in self.run(subject):
                tried += 1
                problems += [] if problem is None else [problem]
        except SkipError as reason:
            return self.skipped(str(reason))
        except subject.faults as fault:
            problems.append(subject.explained(fault))
        if not tried and not problems:
            return self.skipped("the description has nothing of it")
        verdict = Verdict.FAILED if problems else Verdict.PASSED
        return self._outcome(verdict, tried, problems)

    def skipped(self, reason: str) -> Outcome:
        """Return the outcome of a skipped check."""
        return self._outcome(Verdict.SKIPPED, 0, [reason])

    def _outcome(self, verdict: Verdict, tried: int, problems: list[str]) -> Outcome:
        return Outcome(
            self.name, self.title, self.clause, verdict, tried, tuple(problems)
        )


def check(
    name: str, title: str, clause: str, needs: Permission | None = None
) -> Callable[[Callable[[S], Problems]], Check[S]]:
    """Return a decorator that makes a check of the function that yields its problems."""
    return lambda run: Check(name, title, clause, run, needs)
