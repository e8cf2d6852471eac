"""A process that a test starts, watches by what it prints, and ends."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from patience import PATIENCE


class LoggedProcess:
    """Runs until its end; all that it prints goes to a file."""

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
        """What it has printed."""
        return self._log.read_text(errors="replace")

    @property
    def runs(self) -> bool:
        """Whether it has not ended."""
        return self.process.poll() is None

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Wait for what happens while it runs, or has happened when it ends."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if not self.runs:
                assert condition(), self.text
            assert time.monotonic() < deadline, self.text
            time.sleep(0.02)

    def says(self, text: str, times: int = 1) -> None:
        """Wait until it has printed a text so many times."""
        self.wait_for(lambda: self.text.count(text) >= times)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """End it by a signal; its exit code."""
        self.process.send_signal(number)
        return self.code()

    def code(self) -> int:
        """Its exit code, once it has ended."""
        return self.process.wait(PATIENCE)
