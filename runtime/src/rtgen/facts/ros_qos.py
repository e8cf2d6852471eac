"""ROS 2 quality of service: policies with the numbers of rmw, rmw's profiles (Jazzy), what fits."""

from __future__ import annotations

from collections.abc import Iterator
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
    """`rmw_qos_durability_policy_e`; only peers have the negative ones, which are DDS's alone."""

    PERSISTENT = -2
    TRANSIENT = -1
    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class Liveliness(IntEnum):
    """`rmw_qos_liveliness_policy_e`; only peers have MANUAL_BY_NODE, which is deprecated."""

    AUTOMATIC = 1
    MANUAL_BY_NODE = 2
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

SECOND: Final = 10**9


class Misfit(NamedTuple):
    """A policy of which a publisher offers less than a subscription requests, with both values."""

    policy: str
    offered: str
    requested: str


def misfits(offered: Profile, requested: Profile) -> list[Misfit]:
    """Return the policies by which a subscription gets nothing from a publisher.

    These are DDS's rules (DDS 1.4, 2.2.3, column RxO; 2.2.3.4, 2.2.3.7, 2.2.3.11, 2.2.3.14); depth,
    history and lifespan concern one end only.
    """
    return list(_misfits(offered, requested))


def _misfits(offered: Profile, requested: Profile) -> Iterator[Misfit]:
    # The smaller number of these two is the stronger value.
    for name in ("reliability", "durability"):
        mine, theirs = getattr(offered, name), getattr(requested, name)
        if mine > theirs:
            yield Misfit(name, word(mine), word(theirs))
    if _longer(offered.deadline, requested.deadline):
        yield _of_times("deadline", offered.deadline, requested.deadline)
    if offered.liveliness < requested.liveliness:
        kinds = word(offered.liveliness), word(requested.liveliness)
        yield Misfit("liveliness", *kinds)
    if _longer(offered.lease, requested.lease):
        yield _of_times("lease", offered.lease, requested.lease)


def _longer(offered: int | None, requested: int | None) -> bool:
    return requested is not None and (offered is None or offered > requested)


def _of_times(name: str, offered: int | None, requested: int | None) -> Misfit:
    return Misfit(name, seconds(offered), seconds(requested))


def word(value: IntEnum) -> str:
    """Return a value as rtgen.toml has it, `best_effort`."""
    return value.name.lower()


def seconds(time: int | None) -> str:
    """Return a time in nanoseconds as rtgen.toml has it, `0.1`; `inf` for none."""
    return "inf" if time is None else f"{time / SECOND:.9g}"


def values_of(unfit: list[Misfit]) -> str:
    """Return the values of both ends that do not fit."""
    return ", ".join(
        f"{each.policy} is {each.offered} at the publisher, {each.requested} at the subscription"
        for each in unfit
    )


def change(unfit: list[Misfit], *, writes: bool) -> str:
    """Return the two ways to make ends fit; `writes`: the publisher is this end."""
    offered, requested = (
        ", ".join(f"{name} = {_quoted(value)}" for name, value in values)
        for values in (
            [(each.policy, each.offered) for each in unfit],
            [(each.policy, each.requested) for each in unfit],
        )
    )
    here, there = (requested, offered) if writes else (offered, requested)
    return f"state {here} for this end ([ros2.topics] in rtgen.toml), or {there} for the other"


def _quoted(value: str) -> str:
    return value if value[0].isdigit() or value == "inf" else f'"{value}"'
