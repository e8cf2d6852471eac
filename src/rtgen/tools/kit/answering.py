"""Stores the answers of commands, which `answers` repeats."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from rtgen.compiler.kit import plugins, stored_files
from rtgen.facts import looks
from rtgen.tools.kit import answers
from rtgen.tools.kit.console import is_noted, noted_output
from rtgen.tools.kit.exits import FAILED

_METADATA = (".dist-info", ".egg-info")


def answered(arguments: list[str], command: Callable[[], int]) -> int:
    """Run a command and return its exit code; its answer is stored if it can be given again.

    It is not stored if a plug-in takes part, which may look at anything, or if a file has changed
    meanwhile or just before.
    """
    began = time.time_ns()
    called = answers.circumstances(arguments)
    with looks.noted() as seen, noted_output() as output:
        code = command()
        is_whole = is_noted()
    if not is_whole or code == FAILED or plugins.announced(*plugins.Group):
        return code
    for name in _of_packages():
        seen.setdefault(name, looks.status(name))
    looked = [(name, each, looks.digest(name)) for name, each in sorted(seen.items())]
    if all(
        looks.status(name) == status and looks.is_settled(status, began)
        for name, status in seen.items()
    ):
        circumstances = answers.in_full(called)
        data = answers.Answer(circumstances, looked, output, code).packed()
        if len(data) <= answers.MAX_BYTES:
            stored_files.write(stored_files.folder(), answers.name_of(called), data)
    return code


def _of_packages() -> Iterator[str]:
    """Yield looks at the installed packages: libraries, and what announces plug-ins."""
    for place in map(Path, sys.path):
        if place.is_dir():
            yield f"{looks.NAMES}{place}"
            for name in plugins.names_in(place):
                if name.endswith(_METADATA):
                    # Paths take as long as all else.
                    yield f"{looks.CONTENT}{place}/{name}/entry_points.txt"
