"""The simulation behind docs/fleets.md: discovery, and its cost."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import pytest

MODEL: dict[str, Any] = runpy.run_path(
    str(Path(__file__).parents[3] / "benchmarks" / "fleet_model.py")
)
Constants, Fleet = MODEL["Constants"], MODEL["Fleet"]
COSTS = Constants(
    join=100.0, pair=10.0, idle=3.0, idle_pair=2.0, memory=50.0, memory_pair=0.5
)


def test_everybody_in_one_domain_learns_of_everybody() -> None:
    for robots in (1, 7, 40):
        load, n = MODEL["flat"](Fleet(robots, processes=3), COSTS), 3 * robots
        assert load.processes == n
        assert load.pairs == n * (n - 1) // 2
        assert load.joined == 100.0 * n + 10.0 * load.pairs
        assert load.idle == 3.0 * n + 2.0 * load.pairs
        assert load.most_sessions == n - 1
        assert load.most_memory == 50.0 + 0.5 * (n - 1)


def test_a_domain_for_each_robot_does_not_grow_with_the_fleet() -> None:
    one, many = (MODEL["by_robot"](Fleet(robots), COSTS) for robots in (1, 1000))
    assert one == many
    assert one == MODEL["flat"](Fleet(1), COSTS)


def test_clients_of_routers_grow_with_their_robots_alone() -> None:
    sites, links = MODEL["by_site"](Fleet(1000, processes=3, site=250), COSTS)
    assert (len(sites), links) == (4, 3)
    whole = MODEL["flat"](Fleet(1, processes=3), COSTS)
    for load in sites:
        assert load.processes == load.most_sessions == 750
        assert load.pairs == 250 * whole.pairs
        assert load.joined == pytest.approx(250 * whole.joined)
        assert load.idle == pytest.approx(250 * whole.idle)
    uneven, _ = MODEL["by_site"](Fleet(251, processes=1), COSTS)
    assert [load.processes for load in uneven] == [250, 1]


def test_constants_are_found_again() -> None:
    for one, pair in ((100.0, 10.0), (5.0, 0.0), (0.0, 3.0)):
        points = [(n, one * n + pair * n * (n - 1) / 2) for n in (2, 4, 8)]
        assert MODEL["fitted"](points) == pytest.approx((one, pair), abs=1e-6)
    assert MODEL["fitted"]([(2, 20.0), (8, 60.0)])[1] == 0.0
    with pytest.raises(ValueError, match="two numbers"):
        MODEL["fitted"]([(2, 1.0), (2, 2.0)])
