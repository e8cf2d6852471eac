"""The pipeline starts in any order of activation of its components."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import permutations
from math import hypot
from multiprocessing import get_context
from random import Random

import pytest
from msgspec.structs import replace
from pipeline import MAX_DURATION, at_end, build, goal, profile, truth
from seeds import budget, seed

from refnav.geometry import Pose, wrap
from rtgen.compiler.model import Activation

TARGET = (0.3, 0.0, 0.5)


navigation = cache(profile)


def end_of(order: tuple[str, ...]) -> Pose:
    """Return the end of the base if one component is activated every 50 ms, in this order."""
    steps = [
        Activation(instance=name, sequence=number, wait_ms=50 if number else 0)
        for number, name in enumerate(order)
    ]
    with build(replace(navigation(), activation=tuple(steps)), goal(*TARGET)) as system:
        assert system.run(MAX_DURATION, at_end), order
        return truth(system)


def spread(ends: list[Pose]) -> tuple[float, float]:
    """Return the size of a box round all ends [m], and of their headings [rad]."""
    xs, ys, _ = zip(*ends, strict=True)
    turns = [wrap(end.theta - ends[0].theta) for end in ends]
    return hypot(max(xs) - min(xs), max(ys) - min(ys)), max(turns) - min(turns)


def test_forward_and_backward_orders() -> None:
    names = tuple(c.instance for c in navigation().components)
    ends = [end_of(order) for order in (names, names[::-1])]
    apart, turned = spread(ends)
    assert apart < 0.01
    assert turned < 0.01


@pytest.mark.nightly
@pytest.mark.slow
def test_any_order_ends_in_one_place() -> None:
    """Some of the 720 orders, all with `make fuzz`."""
    orders = list(permutations(c.instance for c in navigation().components))
    assert len(orders) == 720
    orders = Random(seed()).sample(orders, min(budget(48), len(orders)))
    # Not by fork: the tests run in a process that has threads.
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        ends = list(pool.map(end_of, orders, chunksize=6))
    apart, turned = spread(ends)
    assert apart < 0.01
    assert turned < 0.01
    x, y, theta = TARGET
    assert all(hypot(end.x - x, end.y - y) < 0.05 for end in ends)
    assert all(abs(wrap(end.theta - theta)) < 0.03 for end in ends)
