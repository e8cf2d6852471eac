"""A check of a conformance test, whatever is tested."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Generic, Protocol, TypeAlias, TypeVar

from rtgen.cli.conformance.report import Outcome, Verdict

Problems: TypeAlias = Iterator[str | None]
"""A problem for each thing that was checked, None where it is as it should be."""


class Subject(Protocol):
    """What is tested; `faults` are the exceptions by which it shows that a check has failed."""

    faults: ClassVar[tuple[type[Exception], ...]]

    def explained(self, fault: Exception) -> str:
        """A fault as the problem of a check."""


S = TypeVar("S", bound=Subject)


class SkipError(Exception):
    """The check does not apply, or must not be made; the text says why."""


class Permission(Enum):
    """What a check may need from the user: the option, with why the check is skipped without."""

    ACTUATE = "it may move something: --actuate"
    DEFAULTS = "values may have been set on purpose: --defaults"
    EXIT = "it ends the component: --exit"


@dataclass(frozen=True, slots=True)
class Check(Generic[S]):
    """A check: its name in reports, what it asserts, by which clause, and what makes it so.

    One that needs a permission runs only if that is given.
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
        """The outcome of a check that was not made."""
        return self._outcome(Verdict.SKIPPED, 0, [reason])

    def _outcome(self, verdict: Verdict, tried: int, problems: list[str]) -> Outcome:
        return Outcome(
            self.name, self.title, self.clause, verdict, tried, tuple(problems)
        )
