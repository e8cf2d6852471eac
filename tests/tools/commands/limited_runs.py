"""Runs command lines in processes of limited memory and time; started as a program by `Runs`.

The program imports the command line once, and forks for each run.
"""

from __future__ import annotations

import json
import os
import resource
import selectors
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

MEGABYTE = 1 << 20
MEMORY = 500 * MEGABYTE
SECONDS = 10
"""Limits of memory [octets] and of processor time [s]."""
ENDED_BY_CLOCK = "clock"
"""The code of a run that waits for something, and was ended."""


@dataclass(frozen=True)
class Run:
    """What a command line did."""

    code: int | str
    output: str
    errors: str


class Runs:
    """Runs of command lines in a folder."""

    def __init__(self, folder: Path, patience: float) -> None:
        self._folder = folder
        self._patience = patience
        self._program: subprocess.Popen[str] | None = None

    def __enter__(self) -> Self:
        environment = {**os.environ, "NO_COLOR": "1"}
        self._program = subprocess.Popen(
            [sys.executable, __file__, str(self._folder), str(self._patience)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        assert self._program is not None
        with self._program:
            pass

    def run(self, words: Sequence[str], folder: str = ".") -> Run:
        """Return what a command line does in a folder."""
        assert self._program is not None
        assert self._program.stdin is not None
        assert self._program.stdout is not None
        self._program.stdin.write(json.dumps([folder, *words]) + "\n")
        self._program.stdin.flush()
        return Run(**json.loads(self._program.stdout.readline()))


def _child(run: Any, words: Sequence[str], output: int, errors: int) -> None:
    """Run a command line with its limits, and end the process."""
    code = 99
    try:
        os.setsid()
        for limit, value in (
            (resource.RLIMIT_DATA, MEMORY),
            (resource.RLIMIT_CPU, SECONDS),
            (resource.RLIMIT_CORE, 0),
        ):
            resource.setrlimit(limit, (value, value))
        nothing = os.open(os.devnull, os.O_RDONLY)
        for number, stream in enumerate((nothing, output, errors)):
            os.dup2(stream, number)
        code = run(words, ends=True)
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _waited(child: int, patience: float) -> int | str:
    """Return the exit code of a process; one that does not end is killed."""
    number = os.pidfd_open(child)
    try:
        with selectors.DefaultSelector() as selector:
            selector.register(number, selectors.EVENT_READ)
            ended = selector.select(patience)
        if not ended:
            os.killpg(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    finally:
        os.close(number)
    return os.waitstatus_to_exitcode(status) if ended else ENDED_BY_CLOCK


def _main() -> None:
    from rtgen.cli import run

    os.chdir(sys.argv[1])
    patience = float(sys.argv[2])
    for name in ("compiler.compilation", "compiler.systems.reading", "cli.options"):
        __import__(f"rtgen.{name}")
    for line in sys.stdin:
        streams = [os.memfd_create("output") for _ in range(2)]
        child = os.fork()
        if child == 0:
            folder, *words = json.loads(line)
            os.chdir(folder)
            _child(run, words, *streams)
        code = _waited(child, patience)
        texts = [os.pread(each, MEGABYTE, 0) for each in streams]
        for each in streams:
            os.close(each)
        output, errors = (each.decode("utf-8", "backslashreplace") for each in texts)
        answer = {"code": code, "output": output, "errors": errors}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    _main()
