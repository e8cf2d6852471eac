"""ROS 2 quality of service: policies with the numbers of rmw, and rmw's profiles (Jazzy)."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple


class History(IntEnum):
    """`rmw_qos_history_policy_e`."""

    KEEP_LAST = 1
    KEEP_ALL = 2


class Reliability(IntEnum):
    """`rmw_qos_reliability_policy_e`."""

    RELIABLE = 1
    BEST_EFFORT = 2


class Durability(IntEnum):
    """`rmw_qos_durability_policy_e`."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class Liveliness(IntEnum):
    """`rmw_qos_liveliness_policy_e`."""

    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3


class Profile(NamedTuple):
    """A QoS profile. `deadline`, `lifespan` and `lease` are in nanoseconds, None for none."""

    depth: int = 10
    reliability: Reliability = Reliability.RELIABLE
    durability: Durability = Durability.VOLATILE
    history: History = History.KEEP_LAST
    deadline: int | None = None
    lifespan: int | None = None
    liveliness: Liveliness = Liveliness.AUTOMATIC
    lease: int | None = None


PROFILES: Final = {
    "default": Profile(),
    "sensor_data": Profile(5, Reliability.BEST_EFFORT),
    "services_default": Profile(),
    "parameters": Profile(1000),
    "parameter_events": Profile(1000),
    "clock": Profile(1, Reliability.BEST_EFFORT),
    "rosout": Profile(1000, durability=Durability.TRANSIENT_LOCAL, lifespan=10 * 10**9),
    "static_tf": Profile(1, durability=Durability.TRANSIENT_LOCAL),
    "map": Profile(1, durability=Durability.TRANSIENT_LOCAL),
    "action_status": Profile(1, durability=Durability.TRANSIENT_LOCAL),
}
"""`rmw_qos_profile_*`; others are from rclcpp (`clock`), rcl (`rosout`), tf2_ros (`static_tf`),
nav2 (`map`) and rcl_action (`action_status`).
"""

GRAPH: Final = Profile(1, durability=Durability.TRANSIENT_LOCAL)
"""The profile of the writers of `ros_discovery_info`."""
