"""Runs numbered cases in worker processes with a limit on time and memory for each input.

A case's number alone determines its input. If a worker dies, its case is recorded and the remaining
cases go to a new worker.
"""

from __future__ import annotations

import gc
import math
import multiprocessing
import resource
import shutil
import signal
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import FrameType
from typing import Protocol

SECONDS = 5.0
"""Maximum processor time for one input [s]."""

MEMORY = 500 * 1024 * 1024
"""Maximum address space of a worker, including the interpreter."""

MAX_FAILURES = 100
"""Number of failures after which a run ends."""

_WORKER_TIMEOUT = 120.0
_CHUNK = 10_000
_SHARED_MEMORY = Path("/dev/shm")


class ViolationError(Exception):
    """A result for an input violates a guarantee."""


class TimeUp(BaseException):
    """An input took too much time; `except Exception` does not catch this."""


class Target(Protocol):
    """The code under test."""

    def make(self, number: int) -> bytes:
        """Return the input of a case."""

    def check(self, number: int, data: bytes) -> Iterable[str]:
        """Process an input; raises for a defect, returns labels to count."""


Factory = Callable[[Path], Target]
"""Creates the target in a worker, which has a folder of its own."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A case that showed a defect, which is the last line of `detail`."""

    number: int
    detail: str

    @property
    def title(self) -> str:
        """The defect in one line."""
        return self.detail.rstrip().rpartition("\n")[2]


@dataclass(slots=True)
class Report:
    """The results of a run, and its cost."""

    cases: int = 0
    octets: int = 0
    labels: Counter[str] = field(default_factory=Counter)
    failures: list[Failure] = field(default_factory=list)
    slowest: tuple[float, int] = (0.0, -1)
    peak: int = 0
    seconds: float = 0.0
    processor: float = 0.0
    """Processor time of the workers, including their start."""

    def add(self, other: Report) -> None:
        """Add the figures of another run."""
        self.cases += other.cases
        self.octets += other.octets
        self.labels += other.labels
        self.failures += other.failures
        self.slowest = max(self.slowest, other.slowest)
        self.peak = max(self.peak, other.peak)
        self.processor += other.processor

    def __str__(self) -> str:
        rate = self.cases / self.seconds if self.seconds else 0.0
        size = self.octets / self.cases if self.cases else 0.0
        lines = [
            f"cases             {self.cases}",
            f"cases per second  {rate:.1f}",
            f"octets per case   {size:.0f}",
            f"slowest [s]       {self.slowest[0]:.3f} (case {self.slowest[1]})",
            f"peak memory [MB]  {self.peak / 2**20:.0f}",
            f"failures          {len(self.failures)}",
        ]
        lines += [
            f"{label:<17} {count}" for label, count in sorted(self.labels.items())
        ]
        return "\n".join(lines)


class Watch:
    """Stops an input that takes too much processor time, without slowing the others down.

    A timer ticks while the processor is used; an input that is still running at the second tick
    ends in TimeUp, so its limit is one to two ticks.
    """

    def __init__(self, tick: float) -> None:
        self._inputs = 0
        self._seen = 0
        self._on = False
        signal.signal(signal.SIGPROF, self._look)
        signal.setitimer(signal.ITIMER_PROF, tick, tick)

    def _look(self, _signal: int, _frame: FrameType | None) -> None:
        if self._on and self._seen == self._inputs:
            raise TimeUp("an input takes too much time")
        self._seen = self._inputs

    @contextmanager
    def input(self) -> Iterator[None]:
        """Watch the processing of one input."""
        self._inputs += 1
        self._on = True
        try:
            yield
        finally:
            self._on = False

    def end(self) -> None:
        """Remove the timer."""
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, signal.SIG_DFL)


def attempt(
    target: Target, number: int, data: bytes, report: Report, watch: Watch
) -> None:
    """Check an input and record the result."""
    start = time.perf_counter()
    try:
        with watch.input():
            report.labels.update(target.check(number, data))
        if time.perf_counter() - start > report.slowest[0]:
            # Without the load of other processes: once more, by processor time.
            start = time.process_time()
            with watch.input():
                list(target.check(number, data))
            taken = time.process_time() - start
            report.slowest = max(report.slowest, (taken, number))
    except (Exception, TimeUp):
        report.failures.append(Failure(number, traceback.format_exc()))
    report.cases += 1
    report.octets += len(data)


def run(
    factory: Factory,
    numbers: Sequence[int],
    *,
    jobs: int = 1,
    chunk: int = _CHUNK,
    progress: Callable[[Report], None] = lambda _report: None,
) -> Report:
    """Run cases, calling `progress` after each chunk, which has a worker of its own.

    An interrupt ends the run; the results so far are reported.
    """
    total = Report()
    start = time.monotonic()
    pending = [numbers[i : i + chunk] for i in range(0, len(numbers), chunk)][::-1]
    workers: dict[Connection, _Worker] = {}
    with tempfile.TemporaryDirectory(
        dir=_SHARED_MEMORY if _SHARED_MEMORY.is_dir() else None
    ) as scratch:
        try:
            while pending or workers:
                while pending and len(workers) < jobs:
                    worker = _Worker(factory, pending.pop(), Path(scratch))
                    workers[worker.channel] = worker
                for channel in wait(list(workers), _WORKER_TIMEOUT):
                    assert isinstance(channel, Connection)
                    worker = workers.pop(channel)
                    report, rest = worker.result()
                    total.add(report)
                    if rest:
                        pending.append(rest)
                    total.seconds = time.monotonic() - start
                    progress(total)
                for worker in workers.values():
                    worker.look()
                if len(total.failures) >= MAX_FAILURES:
                    pending.clear()
        except KeyboardInterrupt:
            for worker in workers.values():
                worker.end()
    return total


class _Worker:
    """A process that works on cases, as the parent sees it."""

    def __init__(self, factory: Factory, numbers: Sequence[int], scratch: Path) -> None:
        context = multiprocessing.get_context("spawn")
        self._numbers = numbers
        self._current = context.Value("q", numbers[0], lock=False)
        self.channel, theirs = context.Pipe(duplex=False)
        self._folder = Path(tempfile.mkdtemp(dir=scratch))
        self._process = context.Process(
            target=_work,
            args=(factory, numbers, self._folder, self._current, theirs),
            daemon=True,
        )
        self._seen, self._since = -1, time.monotonic()
        self._process.start()
        theirs.close()

    def look(self) -> None:
        """End a worker whose input has not changed since the previous call, long ago."""
        now = time.monotonic()
        if self._current.value != self._seen:
            self._seen, self._since = self._current.value, now
        elif now - self._since > _WORKER_TIMEOUT:
            self._process.kill()

    def end(self) -> None:
        """End the worker at once."""
        self._process.kill()
        self._process.join()

    def result(self) -> tuple[Report, Sequence[int]]:
        """Return the report and the remaining cases, once the channel is ready."""
        try:
            report: Report = self.channel.recv()
            rest: Sequence[int] = ()
        except EOFError:
            self._process.join()
            number = self._current.value
            code = self._process.exitcode
            done = self._numbers.index(number) + 1
            report = Report(cases=done)
            report.failures.append(Failure(number, f"the worker ended with {code}"))
            rest = self._numbers[done:]
        self.channel.close()
        self._process.join()
        shutil.rmtree(self._folder, ignore_errors=True)
        return report, rest


def _work(
    factory: Factory,
    numbers: Sequence[int],
    folder: Path,
    current: object,
    channel: Connection,
) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    target = factory(folder)
    report = Report()
    target.check(-1, b"")
    gc.freeze()
    watch = Watch(SECONDS / 2)
    for number in numbers:
        current.value = number  # type: ignore[attr-defined]
        attempt(target, number, target.make(number), report, watch)
        if len(report.failures) >= MAX_FAILURES:
            break
    report.peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    report.processor = time.process_time()
    channel.send(report)
    channel.close()


def log_uniform(low: float, high: float, draw: float) -> int:
    """Return a number from `low` to `high`, uniform in its logarithm; `draw` is from 0 to 1."""
    return round(math.exp(math.log(low) + draw * (math.log(high) - math.log(low))))
