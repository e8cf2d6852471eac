"""Runs the commands on definitions that are short with large effects, deep, or many."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import growing_cdl
import growing_devices
import growing_idl
import growing_modules
import growing_systems
from fuzzing import ViolationError
from growth import Kind

from rtgen.cli import run

KINDS: dict[str, Kind] = {
    **growing_idl.KINDS,
    **growing_cdl.KINDS,
    **growing_devices.KINDS,
    **growing_systems.KINDS,
    **growing_modules.KINDS,
}
Case = tuple[str, int, tuple[str, ...]]
"""A kind, a size, and the words of a command."""

CASES: tuple[Case, ...] = tuple(
    (name, size, command)
    for name, each in KINDS.items()
    for size in each.sizes
    for command in each.commands
)
"""All cases, in a fixed order."""

_MESSAGES = 1_000_000
"""Maximum number of characters in the output of a command."""


class GrowthTarget:
    """Runs the commands on all definitions, each within the limits of the other fuzzers."""

    def __init__(self, folder: Path, cases: Sequence[Case] = CASES) -> None:
        self._folder = folder
        self._cases = cases
        os.environ["RTGEN_CACHE_DIR"] = str(folder / "cache")

    def make(self, number: int) -> bytes:
        """Return the words of a case."""
        name, size, command = self._cases[number]
        return f"{name} {size}: {' '.join(command)}".encode()

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Run a case; raises for an internal error, or for too much output."""
        name, size, command = self._cases[max(number, 0)]
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            for file, text in KINDS[name].make(size).items():
                Path(folder, file).write_text(text)
            messages = io.StringIO()
            with (
                chdir(folder),
                Path(os.devnull).open("w") as nothing,
                redirect_stdout(nothing),
                redirect_stderr(messages),
            ):
                code = run(command)
        output = messages.getvalue()
        if code not in (0, 1, 2) or len(output) > _MESSAGES:
            where = f"{name} {size}: exit code {code}, {len(output):,} characters"
            raise ViolationError(f"{output[-500:]}\n{where}")
        yield ("accepted", "accepted", "refused")[code]
