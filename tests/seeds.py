"""The seed and the budget of the random tests of this run.

`make test` draws the inputs of one seed, so that a commit fails by what it changes; `make fuzz`
draws others each time. `RTGEN_SEED` gives one, for example that of a run that failed, which the
head of pytest's report has. `RTGEN_BUDGET` multiplies the number of drawn inputs, 1 if not set.
"""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SEED = 10_769_057
"""The seed of `make test`."""
_DISTANCE = 10_000_000
"""From the first case of one seed to that of the next."""


def commit() -> str:
    """The commit of the working tree, zeros outside of a repository."""
    command = ["git", "rev-parse", "HEAD"]
    answer = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False
    )
    return answer.stdout.strip() or "0" * 40


@cache
def seed() -> int:
    """The seed of all random tests of this run."""
    given = os.environ.get("RTGEN_SEED")
    # pytest-xdist's workers get it with the environment.
    os.environ["RTGEN_SEED"] = given or str(SEED)
    return int(os.environ["RTGEN_SEED"])


def budget(count: int) -> int:
    """`count` inputs, times `RTGEN_BUDGET`."""
    return count * int(os.environ.get("RTGEN_BUDGET", "1"))


def cases(count: int) -> range:
    """The numbers of so many cases of a fuzzer, times `RTGEN_BUDGET`, from the seed on."""
    first = seed() * _DISTANCE
    return range(first, first + budget(count))
