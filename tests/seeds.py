"""Seed and budget of the random tests of this run.

`make test` draws the same inputs each time, so that what fails is due to a change. `make nightly`
draws by a seed that depends on the commit, `make fuzz` other inputs each time. `RTGEN_SEED` sets
a seed, for example that of a failed run, which pytest prints in its header. `RTGEN_BUDGET`
multiplies the numbers of drawn inputs that tests state, by default 0.2; the workflow takes 5
each night, `make fuzz` 30. From 1 on, `make nightly` runs all of its tests, instead of a
quarter of them.
"""

from __future__ import annotations

import math
import os
import subprocess
import zlib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SEED = 10_769_057
"""The seed of `make test`."""
TURNS = 4
"""A commit takes one of so many parts of the tests of `make nightly`."""
_SEED_DISTANCE = 10_000_000
"""Distance between the first cases of two seeds."""


def commit(folder: Path = ROOT) -> str | None:
    """Return the commit of the working tree, None outside of a repository or without git."""
    command = ["git", "rev-parse", "--verify", "HEAD"]
    try:
        answer = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return None
    return answer.stdout.strip() or None


def seed_of(commit: str | None) -> int:
    """Return the seed of a commit: its first seven hexadecimal digits, as git abbreviates it."""
    return SEED if commit is None else int(commit[:7], 16)


@cache
def seed() -> int:
    """Return the seed of all random tests of this run."""
    given = os.environ.get("RTGEN_SEED")
    # Workers of pytest-xdist inherit it with the environment.
    os.environ["RTGEN_SEED"] = given or str(SEED)
    return int(os.environ["RTGEN_SEED"])


def budget(count: int, *, least: int = 1) -> int:
    """Return `count` times `RTGEN_BUDGET`, but not fewer than `least`."""
    return max(least, math.ceil(count * _share()))


def is_for_all() -> bool:
    """Return whether the budget is for all of what a seed chooses a part of."""
    return _share() >= 1


def has_turn(name: str) -> bool:
    """Return whether a name is in the part that the seed chooses, or the budget is for all."""
    return is_for_all() or (zlib.crc32(name.encode()) + seed()) % TURNS == 0


def _share() -> float:
    return float(os.environ.get("RTGEN_BUDGET", "0.2"))


def cases(count: int, *, always: int = 0) -> list[int]:
    """Return the numbers of `always` cases, which no seed changes, and of `budget(count)` others.

    What a test asserts to appear among its cases, whatever the seed, appears among the former.
    """
    first = seed() * _SEED_DISTANCE
    return [*range(always), *range(first, first + budget(count))]


if __name__ == "__main__":
    # The seed of `make nightly`.
    print(seed_of(commit()))
