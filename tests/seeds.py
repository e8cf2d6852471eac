"""The seed and the budget of the random tests of this run.

The seed of `make test` is that of the commit: each commit draws inputs of its own, and draws the
same whenever it is tested again; `make fuzz` draws others each time. `RTGEN_SEED` gives one, for
example that of a run that failed, which the head of pytest's report has. `RTGEN_BUDGET` multiplies
the number of drawn inputs, 1 if not set.
"""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WITHOUT_COMMIT = 10_769_057
"""The seed outside of a repository."""
_DISTANCE = 10_000_000
"""From the first case of one seed to that of the next."""


def commit(folder: Path = ROOT) -> str | None:
    """The commit of the working tree, None outside of a repository or without git."""
    command = ["git", "rev-parse", "--verify", "HEAD"]
    try:
        answer = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() or None


def seed_of(commit: str | None) -> int:
    """The seed of a commit: its first seven hexadecimal digits, as git abbreviates it."""
    return WITHOUT_COMMIT if commit is None else int(commit[:7], 16)


@cache
def seed() -> int:
    """The seed of all random tests of this run."""
    given = os.environ.get("RTGEN_SEED")
    # pytest-xdist's workers get it with the environment.
    os.environ["RTGEN_SEED"] = given or str(seed_of(commit()))
    return int(os.environ["RTGEN_SEED"])


def budget(count: int) -> int:
    """`count` inputs, times `RTGEN_BUDGET`."""
    return count * int(os.environ.get("RTGEN_BUDGET", "1"))


def cases(count: int) -> range:
    """The numbers of so many cases of a fuzzer, times `RTGEN_BUDGET`, from the seed on."""
    first = seed() * _DISTANCE
    return range(first, first + budget(count))
