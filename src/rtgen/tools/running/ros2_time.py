"""The time of a run with `--ros2`: real, simulated at a pace, or that of the topic `/clock`."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rtgen import runtime
from rtgen.compiler.diagnostics import ToolError
from rtgen.tools.kit.exits import Refusal

if TYPE_CHECKING:
    from rtgen.runtime.ros2.network import RosNetwork
    from rtgen.tools.running.plan import RunOptions


@dataclass(frozen=True, slots=True)
class RosTime:
    """`rate` is the pace of simulated time, `follows`: the time is that of `/clock`.

    `patience` is the longest time without a first message of it [s].
    """

    simulated: bool
    follows: bool
    rate: float | None
    patience: float

    @classmethod
    def of(cls, options: RunOptions) -> RosTime:
        """Return that of a run. Raises Refusal for options that contradict each other."""
        rate, follows = options.live.rate, options.follows_ros
        if follows and options.ros2 is None:
            raise Refusal("--clock ros goes with --ros2")
        if follows and rate is not None:
            raise Refusal("--rate goes with --clock sim: the pace is that of /clock")
        if options.ros2 is not None and options.simulated and not follows and not rate:
            raise Refusal(
                "--ros2 needs --clock real, --clock ros, or simulated time at a pace: --rate 1"
            )
        return cls(options.simulated, follows, rate, options.carrying.patience)

    def prepare(self, network: RosNetwork) -> None:
        """Let what comes in simulated time be handled in its thread."""
        if self.simulated:
            from rtgen.runtime.ros2.turns import Turns

            network.turns = Turns()

    def begin(
        self, network: RosNetwork, running: runtime.System
    ) -> Callable[[float], None]:
        """Publish the time, or wait for it and follow it; return what waits, in seconds.

        Raises ToolError, Ros2Error.
        """
        turns = network.turns
        if turns is None:
            return time.sleep
        from rtgen.runtime.ros2.clock import (
            CLOCK,
            ClockError,
            FollowedClock,
            publish_clock,
        )
        from rtgen.tools.running.ros2_classes import message_classes

        class_ = message_classes(CLOCK)[CLOCK]
        if not self.follows:
            assert self.rate is not None
            publish_clock(network, running, class_, self.rate)
            return turns.rest
        clock = FollowedClock(network, running, class_, turns)
        try:
            clock.begin(self.patience)
        except ClockError as error:
            hint = "a simulator publishes it, ros2 bag play --clock, or rtgen run --ros2 --rate 1"
            raise ToolError(str(error), hint=hint) from error
        return turns.rest
