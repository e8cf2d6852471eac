"""Two complete runs that many tests use."""

from __future__ import annotations

import pytest
from pipeline import GOAL, PATH, Recording, record


@pytest.fixture(scope="session")
def goal_run() -> Recording:
    """Return a run from (0, 0, 0) to (3.4, 7.7, -1.57)."""
    return record(GOAL)


@pytest.fixture(scope="session")
def path_run() -> Recording:
    """Return a run from (0, 0, 0) along (2, 0, 0), (2, 2, 0), (0, 2, 3.14)."""
    return record(PATH)
