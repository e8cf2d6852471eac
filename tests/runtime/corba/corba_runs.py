"""Runs over omniORB in processes of their own, and the other side in the tests' process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from patience import PATIENCE, until

from rtgen import runtime
from rtgen.runtime.corba.transport import NamedCorba

ROOT = Path(__file__).parents[3]
BOARD = ROOT / "specs" / "tecs" / "rh3_board.xml"
NAVIGATION = ROOT / "specs" / "navigation" / "rh3_goal.xml"
REAL = ["--clock", "real", "--transport", "corba"]


class Run:
    """`rtgen run` in a process of its own, in real time, over omniORB."""

    def __init__(
        self, project: Path, *arguments: str, system: Path = Path("calc.xml")
    ) -> None:
        folder = ROOT if system.is_absolute() else project
        self.errors = project / f"errors-{time.monotonic_ns()}.txt"
        self.log = self.errors.with_suffix(".jsonl")
        command = [sys.executable, "-m", "rtgen", "run", str(system), "--clock", "real"]
        command += ["--transport", "corba", "--log", str(self.log), *arguments]
        paths = [str(project), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        with self.errors.open("w", encoding="utf-8") as errors:
            self.process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )

    def error_text(self) -> str:
        """The standard error so far."""
        return self.errors.read_text(encoding="utf-8")

    def wait_for(self, text: str) -> None:
        """Wait until standard error has a text."""
        self.until(lambda: text in self.error_text())

    def end(self) -> int:
        """End the process in order; return its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.code()

    def code(self) -> int:
        """Wait for the end; return the exit code."""
        self.output, _ = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode

    def kill(self) -> None:
        """Kill the process, if it still runs."""
        self.process.kill()
        assert self.process.stdout is not None
        if not self.process.stdout.closed:
            self.process.communicate()

    def until(self, condition: Callable[[], object]) -> None:
        """Wait until a condition holds, which the process fulfils."""
        until(lambda: self.process.poll() is not None or condition())
        assert condition(), self.error_text()

    def samples(self) -> list[dict[str, Any]]:
        """Return the samples written so far."""
        lines = self.log.read_text().split("\n")[:-1]
        events = [json.loads(line) for line in lines]
        return [event for event in events if event["event"] == "sample"]

    def results(self) -> list[tuple[int, str]]:
        """Return the samples of Caller0."""
        values = [event["value"] for event in self.samples()]
        return [(value["number"], value["error"]) for value in values]


class Here:
    """The other side in this process: a system with Caller0, which does not tick."""

    def __init__(self, stack: ExitStack, names: str, timeout: float = 2.0) -> None:
        from calc_nodes import Caller  # type: ignore[import-not-found]

        self.transport = stack.enter_context(
            NamedCorba(name_server=names, timeout=timeout)
        )
        self.system = stack.enter_context(
            runtime.System(runtime.RealClock(), self.transport)
        )
        self.caller = Caller("Caller0")
        self.system.add(self.caller)

    def connect(self, **properties: str) -> None:
        """Connect the caller with the component of another process."""
        names = {key.replace("_", "."): text for key, text in properties.items()}
        self.system.connect(("Caller0", "adding"), ("Counter0", "adding"), names)

    @property
    def adder(self) -> Any:
        """The stub."""
        return self.caller.adder.object


def answers(here: Here) -> bool:
    """Return whether a call is answered."""
    try:
        return bool(here.adder.add(2, 3) == 5)
    except runtime.CommunicationFailure:
        return False
