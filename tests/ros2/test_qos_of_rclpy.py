"""What fits, compared with rclpy of the installed distributions."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from ros2_peers import DISTRIBUTIONS, installation

from rtgen.facts.ros_qos import Durability, Liveliness, Profile, Reliability, misfits

pytestmark = [pytest.mark.peer, pytest.mark.waits]

SCRIPT = Path(__file__).with_name("rclpy_compatible.py")
TIMES = (None, 10**9, 10**8)
POLICIES = (
    tuple(Reliability),
    (Durability.TRANSIENT_LOCAL, Durability.VOLATILE),
    (Liveliness.AUTOMATIC, Liveliness.MANUAL_BY_TOPIC),
    TIMES,
    TIMES,
)


def described(values: tuple[Any, ...]) -> Profile:
    reliability, durability, liveliness, deadline, lease = values
    return Profile(
        reliability=reliability,
        durability=durability,
        liveliness=liveliness,
        deadline=deadline,
        lease=lease,
    )


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_all_pairs_of_profiles(distribution: str) -> None:
    pairs = [*product(product(*POLICIES), repeat=2)]
    made = installation(distribution)
    found = json.loads(made.output(SCRIPT, text=json.dumps(pairs)))
    expected = [not misfits(*map(described, pair)) for pair in pairs]
    assert found == expected
    assert True in found
    assert False in found
