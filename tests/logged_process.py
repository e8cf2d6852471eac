"""A process that a test starts, observes by its output, and ends."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from patience import PATIENCE, until


class LoggedProcess:
    """A process whose output goes to a file."""

    def __init__(
        self,
        arguments: Sequence[str],
        folder: Path,
        environment: Mapping[str, str],
        log: Path,
        program: str = sys.executable,
    ) -> None:
        self._log = log
        with log.open("w") as output:
            self.process = subprocess.Popen(
                [program, *arguments],
                cwd=folder,
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def text(self) -> str:
        """The output so far."""
        return self._log.read_text(errors="replace")

    @property
    def runs(self) -> bool:
        """Whether the process is running."""
        return self.process.poll() is None

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Wait for a condition, while the process runs or when it ends."""
        until(lambda: condition() or not self.runs, shown=lambda: self.text)
        assert condition(), self.text

    def says(self, text: str, times: int = 1) -> None:
        """Wait until the output has a text that many times."""
        self.wait_for(lambda: self.text.count(text) >= times)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """End the process by a signal; return its exit code."""
        self.process.send_signal(number)
        return self.code()

    def code(self) -> int:
        """Return the exit code, once the process has ended."""
        return self.process.wait(PATIENCE)
