"""The topic `/clock` (rosgraph_msgs/msg/Clock): time of a run for nodes, and theirs for a run.

A node with the parameter `use_sim_time` takes its time from the topic.
"""

from __future__ import annotations

import time
from typing import Any, Final

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.failures import NOTE, log
from rtgen.runtime.ros2.network import Ros2Error, RosNetwork, RosTopic
from rtgen.runtime.ros2.turns import Turns
from rtgen.runtime.ros2.types import decoded, encoded, made
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND, SimulatedClock

CLOCK: Final = "rosgraph_msgs/msg/Clock"
_TOPIC: Final = "/clock"
_PERIOD: Final = SECOND // 100
_STEP: Final = SECOND // 1000
"""Period with which the foreign time is compared [ns]: the run is ahead of it by less."""
_MAX_RATE: Final = 1000.0
"""Maximum number of published times per second of the wall clock."""
_LEAP: Final = 10 * SECOND
"""A step of the foreign time that is not followed, but made at once [ns]."""
_STANDS: Final = 2.0
"""Seconds of the wall clock after which a time that stands is reported."""
_LONGEST_STAND: Final = 600.0
_SLICE: Final = 0.1
_REPORT_PERIOD: Final = 5.0
"""Seconds between two reports of leaps."""


class ClockError(Ros2Error):
    """No time comes from `/clock`."""


def publish_clock(
    network: RosNetwork, running: System, class_: type[Any], rate: float
) -> None:
    """Publish the time of a run in simulated time, at its pace. Raises Ros2Error.

    `class_` is that of rosgraph_msgs/msg/Clock, `rate` in simulated seconds per second.
    """
    publish = network.publisher(RosTopic(_TOPIC, class_), PROFILES["clock"])

    def tell() -> None:
        seconds, rest = divmod(running.clock.now(), SECOND)
        message = made(
            class_._descriptor_, {"clock": {"sec": seconds, "nanosec": rest}}
        )
        try:
            publish(encoded(message))
        except Ros2Error as error:
            log.warning("%s", error)

    running.every(max(_PERIOD, round(rate / _MAX_RATE * SECOND)), tell)


class FollowedClock:
    """Lets a run in simulated time follow the topic: it waits until its time has come.

    `SimulatedClock.now` is the time of the topic. The run stands while that stands. Where that goes
    back, or forward by more than 10 s, `now` does it, too, and the run goes on from where it is.
    """

    def __init__(
        self, network: RosNetwork, running: System, class_: type[Any], turns: Turns
    ) -> None:
        """Subscribe. Raises Ros2Error."""
        assert isinstance(running.clock, SimulatedClock)
        self._running = running
        self._clock = running.clock
        self._turns = turns
        self._class = class_
        self._latest: int | None = None
        self._reported = {"back": -_REPORT_PERIOD, "forward": -_REPORT_PERIOD}
        network.subscribe(RosTopic(_TOPIC, class_), PROFILES["clock"], self._take)

    def begin(self, patience: float) -> None:
        """Wait for the first time, and follow from now on. Raises ClockError.

        `patience` in seconds.
        """
        self._turns.rest(patience, lambda: self._latest is not None)
        if self._latest is None:
            raise ClockError(f"no time came from {_TOPIC} within {patience:g} s")
        self._turn()

    def _turn(self) -> None:
        self._wait(self._clock.time)
        self._running.at(self._clock.time + _STEP, self._turn)

    def _take(self, octets: bytes) -> None:
        try:
            stamp = decoded(self._class, octets).clock
        except CdrError as error:
            log.warning("%s: a message cannot be decoded: %s", _TOPIC, error)
            return
        now = stamp.sec * SECOND + stamp.nanosec
        if self._latest is None:
            self._clock.origin = now - self._clock.time
        else:
            step = now - self._latest
            if not 0 <= step <= _LEAP:
                self._clock.origin += step
                self._report_leap(step)
        self._latest = now

    def _report_leap(self, step: int) -> None:
        way = "back" if step < 0 else "forward"
        if time.monotonic() - self._reported[way] < _REPORT_PERIOD:
            return
        self._reported[way] = time.monotonic()
        log.log(NOTE, "%s leaps %s by %.3f s", _TOPIC, way, abs(step) / SECOND)

    def _reached(self, instant: int) -> bool:
        return self._latest is not None and self._latest - self._clock.origin >= instant

    def _wait(self, instant: int) -> None:
        """Wait until the foreign time is that of an instant of the run. Raises ClockError."""
        begun = time.monotonic()
        is_reported = False
        self._turns.rest(0.0)
        while not self._reached(instant) and not self._running.is_ending:
            self._turns.rest(_SLICE, lambda: self._reached(instant))
            standing = time.monotonic() - begun
            if standing > _LONGEST_STAND:
                raise ClockError(f"{_TOPIC} has stood for {_LONGEST_STAND:g} s")
            if standing > _STANDS and not is_reported:
                is_reported = True
                now = self._clock.now() / SECOND
                log.log(
                    NOTE, "%s stands at %.3f s, and the run waits for it", _TOPIC, now
                )
