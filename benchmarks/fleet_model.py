"""Network load of a fleet: a simulation of robots that join, with measured constants.

Robots join one after the other. Discovery is simulated by the rules of each engine: participants of
a DDS domain announce themselves and all their endpoints to each other; Zenoh peers open a session
to each other; a client of a Zenoh router has one session, and discovers only the processes of its
robot. `Constants` are the octets of each of these, fitted by `fleet.py` to runs of up to some ten
processes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Constants:
    """Octets on the network of one engine, where each process has the same topics.

    `join` are those of a process alone, `pair` those between two that discover each other (both
    ways); `idle` and `idle_pair` are the same for a second without samples. `memory` is that of a
    process in MiB, `memory_pair` that of each further one.
    """

    join: float
    pair: float
    idle: float
    idle_pair: float
    memory: float
    memory_pair: float = 0.0


@dataclass
class Load:
    """Octets on the network: to join, and in a second without samples."""

    joined: float = 0.0
    idle: float = 0.0
    pairs: int = 0
    processes: int = 0
    most_memory: float = 0.0
    most_sessions: int = 0


class Segment:
    """Processes that discover each other: a domain of DDS, or Zenoh peers."""

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self.load = Load()

    def join(self, others: int = 1) -> None:
        """Add processes, one after the other."""
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

    A client discovers the clients of its partition (those of its robot) and no others.
    """

    def __init__(self, constants: Constants) -> None:
        self._constants = constants
        self.load = Load()
        self.partitions: dict[int, int] = {}

    def join(self, partition: int) -> None:
        """Add a client."""
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
    """Return the load if all processes are in one DDS domain, or Zenoh peers of each other."""
    segment = Segment(constants)
    segment.join(fleet.robots * fleet.processes)
    return segment.load


def by_robot(fleet: Fleet, constants: Constants) -> Load:
    """Return the load of one robot, if each robot has a domain of its own."""
    segment = Segment(constants)
    segment.join(fleet.processes)
    return segment.load


def by_site(fleet: Fleet, constants: Constants) -> tuple[list[Load], int]:
    """Return the loads with a router for each site, and the largest number of links of a router.

    Routers are joined in a star: each has a link to the first, so that the links of one grow with
    the sites and not with the robots.
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
    """Fit cost(n) = one * n + pair * n (n - 1) / 2 by least squares; return `one` and `pair`.

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
