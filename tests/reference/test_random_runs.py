"""Random runs: no collision, no driving by old data, no false report of success.

`RTGEN_BUDGET` multiplies the runs, and `RTGEN_SEED` chooses others (see `seeds`); so does `python
tests/reference/random_runs.py 500 --first N`.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from random_runs import make
from seeds import cases


@pytest.mark.nightly
@pytest.mark.parametrize("seed", cases(4))
def test_a_random_run(seed: int, tmp_path: Path) -> None:
    run = make(seed, tmp_path)
    assert run.faults == [], (run.accidents, run.words)


def test_a_run_follows_from_its_seed(tmp_path: Path) -> None:
    once, again = (make(4, tmp_path, kind="plain") for _ in range(2))
    assert once == again


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("seed", "changed", "fault"),
    [
        # Odometry dies, and no component reacts.
        (
            18,
            ["PathFollower0.PositionTimeout=0", "Navigation0.PositionTimeout=0"],
            "s beyond",
        ),
        # Obstacles are detected too late.
        (
            1,
            [
                "ObstaclesAvoidance0.horizon=0.01",
                "CollisionDetection0.margin=0",
                "CollisionDetection0.radiusOfBodyArea=0.01",
                "ObstaclesAvoidance0.radiusOfBodyArea=0.01",
                "ObstaclesAvoidance0.clearance=0",
            ],
            "collision",
        ),
    ],
)
def test_a_run_that_must_not_be_is_found(
    seed: int, changed: list[str], fault: str, tmp_path: Path
) -> None:
    run = make(seed, tmp_path, changed=changed)
    assert any(fault in found for found in run.faults)
