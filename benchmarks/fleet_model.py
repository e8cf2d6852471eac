"""What a fleet costs on the network: a simulation of robots that join, with measured constants.

Robots join one after the other. Who learns of whom is simulated by the rules of each engine:
participants of a DDS domain announce themselves and all their endpoints to each other; Zenoh peers
open a session to each other; a client of a Zenoh router has one session, and hears of the processes
of its robot alone. `Constants` are the octets of each of these,
fitted by `fleet.py` to runs of up to some ten processes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Constants:
    """Octets on the network of one engine, where each of the processes has the same topics.

    `join` are those of a process alone, `pair` those between two that learn of each other (both
    ways); `idle` and `idle_pair` are the same for a second of silence. `memory` is that of a
    process in MiB, `memory_pair` what each further one adds.
    """

    join: float
    pair: float
    idle: float
    idle_pair: float
    memory: float
    memory_pair: float = 0.0


@dataclass
class Load:
    """What is counted: octets to join, octets in a second of silence, by network."""

    joined: float = 0.0
    idle: float = 0.0
    pairs: int = 0
    processes: int = 0
    most_memory: float = 0.0
    most_sessions: int = 0


class Segment:
    """Processes that learn of each other: a domain of DDS, or Zenoh peers."""

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self.load = Load()

    def join(self, others: int = 1) -> None:
        """Some processes join, one after the other."""
        c, load = self._constants, self.load
        for _ in range(others):
            load.joined += c.join + load.processes * c.pair
            load.idle += c.idle + load.processes * c.idle_pair
            load.pairs += load.processes
            load.processes += 1
            load.most_sessions = load.processes - 1
            load.most_memory = c.memory + (load.processes - 1) * c.memory_pair


class Router:
    """A Zenoh router with clients.

    A client hears of the clients of its partition (those of its robot) and of no others.
    """

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self.load = Load()
        self.partitions: dict[int, int] = {}

    def join(self, partition: int) -> None:
        """A client joins."""
        known = self.partitions.get(partition, 0)
        c, load = self._constants, self.load
        load.joined += c.join + known * c.pair
        load.idle += c.idle + known * c.idle_pair
        load.pairs += known
        load.processes += 1
        load.most_sessions += 1
        self.partitions[partition] = known + 1


@dataclass(frozen=True)
class Fleet:
    """Robots with some processes each; `site` robots share a router or a network."""

    robots: int
    processes: int = 3
    site: int = 250


def flat(fleet: Fleet, constants: Constants) -> Load:
    """All processes of all robots in one DDS domain, or as Zenoh peers of each other."""
    segment = Segment(constants)
    segment.join(fleet.robots * fleet.processes)
    return segment.load


def by_robot(fleet: Fleet, constants: Constants) -> Load:
    """A domain for each robot: the load of one; nothing of it leaves the robot."""
    segment = Segment(constants)
    segment.join(fleet.processes)
    return segment.load


def by_site(fleet: Fleet, constants: Constants) -> tuple[list[Load], int]:
    """A router for each site, all robots' processes its clients: their loads, and the links.

    Routers are joined in a star: each has a link to the first, so that the most links of one
    grow with the sites and not with the robots.
    """
    routers: list[Router] = []
    for robot in range(fleet.robots):
        if robot % fleet.site == 0:
            routers.append(Router(constants))
        for _ in range(fleet.processes):
            routers[-1].join(robot)
    links = max(len(routers) - 1, 0)
    return [router.load for router in routers], links


def fitted(points: Iterable[tuple[int, float]]) -> tuple[float, float]:
    """Cost of one and of a pair, by least squares: cost(n) = one * n + pair * n (n - 1) / 2.

    Negative values are noise of a small cost, and count as 0. Raises ValueError for less than two
    numbers of processes.
    """
    rows = [(float(n), n * (n - 1) / 2, cost) for n, cost in points]
    if len({n for n, _, _ in rows}) < 2:
        raise ValueError("two numbers of processes are needed")
    aa = sum(a * a for a, _, _ in rows)
    ab = sum(a * b for a, b, _ in rows)
    bb = sum(b * b for _, b, _ in rows)
    ay = sum(a * y for a, _, y in rows)
    by = sum(b * y for _, b, y in rows)
    determinant = aa * bb - ab * ab
    one, pair = (ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant
    if pair < 0:
        return ay / aa, 0.0
    if one < 0:
        return 0.0, by / bb
    return one, pair
