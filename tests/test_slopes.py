"""16 times the input costs a command at most 20 times, in lines of Python that it executes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
from seeds import budget, seed

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"
sys.path.append(str(FOLDER))

import slopes  # noqa: E402

SHAPES = sorted(slopes.SHAPES)
"""All of them with a `RTGEN_BUDGET` of 1 or more."""


@pytest.mark.nightly
@pytest.mark.parametrize(
    "shape", Random(seed()).sample(SHAPES, min(len(SHAPES), budget(len(SHAPES))))
)
def test_costs_grow_with_the_input(shape: str) -> None:
    command = [sys.executable, str(FOLDER / "slopes.py"), "--only", shape]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, done.stdout


def _work(count: int) -> None:
    for _ in range(count):
        pass


@pytest.mark.parametrize(
    ("power", "fixed", "expected"), [(1, 0, 16), (1, 500, 16), (2, 0, 64)]
)
def test_growth_of_counted_lines(power: int, fixed: int, expected: int) -> None:
    costs = []
    for factor in slopes.FACTORS:
        with slopes.Lines() as counted:
            _work(fixed + 10 * factor**power)
        costs.append(counted.cost)
    assert slopes.growth(costs) == expected
