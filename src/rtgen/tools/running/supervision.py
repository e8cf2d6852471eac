"""`rtgen run --supervise`: a process for each group of components, restarted when it fails."""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.kit.translation import language
from rtgen.compiler.model import System
from rtgen.compiler.systems.rules import NOTICE
from rtgen.facts.extras import installation
from rtgen.runtime.errors import TransportError
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK, Refusal
from rtgen.tools.kit.signals import handled, of_ending, of_interrupting
from rtgen.tools.running import partition
from rtgen.tools.running.plan import Plan
from rtgen.tools.running.transports import ACTIVATED

if TYPE_CHECKING:
    from rtgen.runtime.corba.name_server import NameServer

_FIRST_DELAY, _MAX_DELAY = 0.5, 10.0
"""First and longest delay before a restart in seconds; it doubles each time."""
_STEADY = 60.0
"""Seconds of running after which earlier failures of a process are forgotten."""
_POLL_INTERVAL = 0.05
_SHUTDOWN_TIMEOUT = 15.0
"""Seconds that a process has for an orderly shutdown."""
_INSISTING = 1.0
"""Seconds after a signal from which a further one ends the processes at once."""
_REST_TIMEOUT = 1.0
"""Seconds that the processes started by one that has ended have for theirs, and its output."""
_LONGEST_LINE = 10_000
"""Maximum length of a line of a process; longer ones are divided."""


@dataclass(frozen=True, slots=True)
class Policy:
    """Restart policy: a failed process is restarted up to `restarts` times in a row."""

    restart: bool
    restarts: int


@dataclass(slots=True)
class Worker:
    """The process of a group of components."""

    name: str
    command: Sequence[str]
    decides: bool
    """Whether the run ends if this process ends by itself."""
    limit: float = math.inf
    """Seconds after which the process ends by itself."""
    process: subprocess.Popen[str] | None = None
    begun: float = 0.0
    failures: int = 0
    due: float | None = None
    done: bool = False
    activated: Path | None = None
    """Lists the foreign components that the process has activated."""
    output: threading.Thread | None = field(default=None, repr=False)

    @property
    def runs(self) -> bool:
        """Whether the process is running."""
        return self.process is not None and self.process.poll() is None


def divided(
    profile: System, groups: Sequence[str], outside: Sequence[str]
) -> list[frozenset[str]]:
    """Return the groups of instances; an ungrouped instance is a group of its own.

    Raises InputError for an unknown instance, Refusal for one in two groups.
    """
    partitions = [partition.named(group, profile, outside) for group in groups]
    for number, group in enumerate(partitions):
        for other in partitions[:number]:
            if twice := sorted(group & other):
                raise Refusal(f"--group: {', '.join(twice)} is in two groups")
    grouped = frozenset().union(*partitions)
    rest = [c.instance for c in profile.components]
    return partitions + [frozenset([n]) for n in rest if n not in grouped | {*outside}]


def commands(
    plan: Plan, groups: Sequence[frozenset[str]], more: Sequence[str]
) -> list[Worker]:
    """Return the processes of a plan; `more` are further options of each."""
    order = [c.instance for c in plan.profile.components]
    options, decisive = plan.options, plan.condition.instance
    workers = []
    for group in groups:
        names = ",".join(name for name in order if name in group)
        command = [sys.executable, "-m", "rtgen", "run", options.system]
        command += ["--told", "--clock", "real", "--only", names, *more]
        command += ["--language", language()]
        if options.until is not None and (decisive is None or decisive in group):
            command += ["--until", options.until]
        for value, text in zip(plan.values, options.settings, strict=True):
            command += ["--set", text] if value.instance in group else []
        limit = plan.condition.limit
        seconds = math.inf if limit is None else limit / SECOND
        workers.append(Worker(names, command, decisive in group, seconds))
    return workers


class Supervisor:
    """Starts processes, reports their ends, and restarts them."""

    def __init__(
        self, workers: Sequence[Worker], policy: Policy, console: Console
    ) -> None:
        self._workers = workers
        self._policy = policy
        self._console = console
        self._host = socket.gethostname()
        self._condition = ""
        self._signalled: list[float] = []
        """Times of the signals that end the run."""

    def run(self) -> int:
        """Supervise until the run ends, by itself or by a signal; return its exit code."""
        # An exception in a handler could come while a process is being started or ended.
        with handled(self._on_signal, *of_interrupting(), *of_ending()):
            try:
                for worker in self._workers:
                    if not self._signalled:
                        self._start(worker)
                self._tell()
                while not self._signalled:
                    ended = self._look()
                    if ended is not None:
                        return ended
                    time.sleep(_POLL_INTERVAL)
                return NO if self._lost else OK
            finally:
                self._end_all()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._signalled.append(time.monotonic())

    @property
    def _insisted(self) -> bool:
        """Whether a further signal came some time after the first."""
        times = self._signalled
        return len(times) > 1 and times[-1] - times[0] >= _INSISTING

    def _start(self, worker: Worker) -> None:
        worker.due = None
        worker.begun = time.monotonic()
        try:
            worker.process = subprocess.Popen(
                worker.command,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                text=True,
                errors="replace",
                start_new_session=True,  # Only the supervisor handles Ctrl-C.
            )
        except OSError as error:
            raise ToolError(f"{worker.name} cannot be started: {error}") from error
        worker.output = threading.Thread(target=self._copy, args=(worker,), daemon=True)
        worker.output.start()

    def _copy(self, worker: Worker) -> None:
        """Print a process's output, each line preceded by the name of its group."""
        assert worker.process is not None
        assert worker.process.stdout is not None
        heard = not self._console.quiet
        for line in iter(partial(worker.process.stdout.readline, _LONGEST_LINE), ""):
            ending = "" if line.endswith("\n") else "\n"
            try:
                if heard:
                    text = printable(f"{worker.name} | {line}", "\n\t")
                    sys.stderr.write(text + ending)
            except OSError:
                heard = False  # The terminal is gone; the process must not wait for it.

    def _look(self) -> int | None:
        """Check all processes; return the exit code if the run has ended."""
        now = time.monotonic()
        for worker in self._workers:
            if worker.due is not None and now >= worker.due:
                self._start(worker)
                self._tell()
            code = None if worker.process is None else worker.process.poll()
            if code is None or worker.done or worker.due is not None:
                continue
            self._end_rest(worker)
            self._release(worker)
            if code == BAD_INPUT:
                return BAD_INPUT
            if code == OK:
                worker.done = True
                if worker.decides:
                    return OK
            else:
                self._failed(worker, code, now)
                self._tell()
        if all(worker.done for worker in self._workers):
            return NO if self._lost else OK
        return None

    def _failed(self, worker: Worker, code: int, now: float) -> None:
        """Report that a process has failed, and schedule its restart."""
        assert worker.process is not None
        if now - worker.begun > _STEADY:
            worker.failures = 0
        worker.failures += 1
        pause = min(_FIRST_DELAY * 2 ** (worker.failures - 1), _MAX_DELAY)
        if code == NO and now - worker.begun >= worker.limit:
            follows = "its time was over"
        elif not self._policy.restart:
            follows = "it is not started again (--supervise never)"
        elif worker.failures > self._policy.restarts:
            follows = f"it is not started again after {self._policy.restarts} restarts"
        else:
            worker.due = now + pause
            follows = f"it is started again in {pause:g} s"
        worker.done = worker.due is None
        message = (
            f"{worker.name}: process {worker.process.pid} on {self._host} "
            f"{_end_of(code)}; {follows}"
        )
        self._console.findings([NOTICE.at(None, message)])

    @property
    def _lost(self) -> list[Worker]:
        """Processes that are not restarted."""
        return [w for w in self._workers if w.done and w.process and w.process.poll()]

    def _tell(self) -> None:
        """Report the condition of the system if it has changed."""
        lost = self._lost
        down = [
            w.name for w in self._workers if not w.runs and (not w.done or w in lost)
        ]
        condition = "complete"
        if down:
            condition = "failed" if lost else "degraded"
            condition += f", without {', '.join(down)}"
        if condition != self._condition:
            self._condition = condition
            self._console.say(f"condition: {condition}")

    def _end_all(self) -> None:
        """Shut the processes down; kill one that does not end."""
        for worker in self._workers:
            if worker.process is not None and worker.runs:
                worker.process.send_signal(signal.SIGTERM)
        deadline = time.monotonic() + _SHUTDOWN_TIMEOUT
        while any(worker.runs for worker in self._workers):
            if self._insisted or time.monotonic() > deadline:
                break
            time.sleep(_POLL_INTERVAL)
        for worker in self._workers:
            if worker.process is None:
                continue
            worker.process.kill()
            worker.process.wait()
            self._end_rest(worker)
            if worker.output is not None:
                # A process that has left the group may hold it open.
                worker.output.join(_REST_TIMEOUT)
            self._release(worker)

    def _end_rest(self, worker: Worker) -> None:
        """End the processes that one has started and left behind in its group."""
        if worker.process is None or sys.platform == "win32":
            return
        end = time.monotonic() + _REST_TIMEOUT
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(worker.process.pid, signal.SIGTERM)
            while time.monotonic() < end:
                os.killpg(worker.process.pid, 0)
                time.sleep(_POLL_INTERVAL)
            os.killpg(worker.process.pid, signal.SIGKILL)

    def _release(self, worker: Worker) -> None:
        """Deactivate the foreign components that a process has left ACTIVE at its end."""
        file = worker.activated
        if file is None or not file.exists() or not file.stat().st_size:
            return
        from rtgen.runtime.corba.orb import Orb
        from rtgen.runtime.corba.rt_objects.activation import release_file
        from rtgen.runtime.corba.rt_objects.objects import Exported

        with closing(Orb()) as orb:
            released = release_file(file, Exported(orb))
        for name, problem in released:
            said = problem or f"is deactivated: {worker.name} had activated it"
            self._console.findings([NOTICE.at(None, f"{name} {said}")])


def _end_of(code: int) -> str:
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"


def supervised(
    plan: Plan,
    console: Console,
    groups: Sequence[str],
    policy: Policy,
    more: Sequence[str],
) -> int:
    """Run a plan in processes, of `groups` of instances and of the others; return the exit code.

    `more` are options of each process. Without a naming service for CORBA, one is started; without
    a folder of checkpoints, they are kept until the run ends. Raises InputError, Refusal and
    ToolError.
    """
    carrying = plan.options.carrying
    if plan.options.simulated or carrying.transport == "direct":
        raise Refusal(
            "--supervise needs --clock real and --transport corba, dds or zenoh"
        )
    instances = divided(plan.profile, groups, sorted(plan.outside))
    is_corba = carrying.transport == "corba"
    with ExitStack() as ending:
        words = [*more]
        if is_corba:
            nameserver = carrying.nameserver
            if nameserver is None:
                nameserver = ending.enter_context(_name_server()).address
            words += ["--nameserver", nameserver]
            console.say(f"naming service: {nameserver}")
        if plan.options.checkpoints is None:
            folder = ending.enter_context(TemporaryDirectory(prefix="rtgen-"))
            words += ["--checkpoints", folder]
        workers = commands(plan, instances, words)
        if is_corba:
            lists = Path(ending.enter_context(TemporaryDirectory(prefix="rtgen-")))
            for number, worker in enumerate(workers):
                worker.activated = lists / str(number)
                worker.command = [
                    *worker.command,
                    f"--{ACTIVATED}",
                    str(worker.activated),
                ]
        return Supervisor(workers, policy, console).run()


def _name_server() -> NameServer:
    try:
        from rtgen.runtime.corba.name_server import NameServer

        return NameServer()
    except ImportError as error:
        raise ToolError(
            "--transport corba needs omniORBpy, which is not installed",
            hint=installation("corba"),
        ) from error
    except TransportError as error:
        raise ToolError(str(error)) from error
