"""Common base of the control components of the four robots; the subclasses have the body."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from refnav.body import Body
from refnav.following import REST, WAYS, Command, Follower, FollowingParameters
from refnav.geometry import Pose
from refnav.newest import Newest
from refrobots import iis, rtc
from rtgen.runtime import RTC_OK, SECOND, Component, InPort, OutPort, ReturnCode_t


class RobotParameters(FollowingParameters, Protocol):
    """The parameters that all robots have [m, rad, s]."""

    robot_id: int
    following: str
    CommandTimeout: float
    TargetTimeout: float
    start_x: float
    start_y: float
    start_theta: float


P = TypeVar("P", bound=RobotParameters)


class Robot(Component, Generic[P]):
    """Executes travel commands of the first and second phase, or follows another robot.

    The newest input decides which. Its observables are `truth` and `odometry`, the true pose and
    that by the encoders (x, y, theta) [m, rad], and `velocity`, that of the body [m/s, m/s, rad/s].
    """

    config: P
    velocity: InPort[rtc.TimedVelocity]
    moving_command: InPort[iis.TimedVelocity]
    target_position: InPort[iis.TimedPosition]
    self_position: OutPort[iis.TimedPosition]

    @abstractmethod
    def _make_body(self) -> Body:
        """Return the body, by the parameters."""

    def on_initialize(self) -> ReturnCode_t:
        """Publish pose and velocity."""
        self._body: Body | None = None
        self._position = iis.TimedPosition()
        config = self.config
        command_age = lambda: config.CommandTimeout  # noqa: E731
        self._first = Newest[rtc.TimedVelocity](self.velocity, command_age)
        self._second = Newest[iis.TimedVelocity](self.moving_command, command_age)
        self._target = Newest[iis.TimedPosition](
            self.target_position, lambda: config.TargetTimeout
        )
        self._show("truth", lambda body: body.plant.pose)
        self._show("odometry", lambda body: body.odometry)
        self._show("velocity", lambda body: body.plant.velocity)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Wait for input. The first activation creates and places the robot."""
        config = self.config
        if self._body is None:
            self._body = self._make_body()
            self._body.place(Pose(config.start_x, config.start_y, config.start_theta))
        self._now = self.now()
        self._wait()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake: without the component the wheels are not driven."""
        return self._brake()

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        return self._brake()

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Move on, and send the position."""
        body = self._body
        assert body is not None
        now = self.now()
        dt = (now - self._now) / SECOND
        self._now = now
        body.roll(dt)
        self._listen(now)
        if self._follower is not None:
            command = self._follower.command(
                body.odometry, self.config, sideways=body.goes_sideways
            )
        else:
            command = self._command
        body.drive(*command, dt)
        position = self._position
        position.id = [self.config.robot_id]
        position.x, position.y, position.theta = body.odometry
        self.stamp(position)
        self.self_position.write(position)
        return RTC_OK

    def _show(self, name: str, value: Callable[[Body], tuple[float, ...]]) -> None:
        self.observables[name] = lambda: () if self._body is None else value(self._body)

    def _brake(self) -> ReturnCode_t:
        if self._body is not None:
            self._body.halt()
        return RTC_OK

    def _wait(self) -> None:
        self._command = REST
        for commands in (self._first, self._second):
            commands.start(self._now)
        self._follower: Follower | None = None
        self._leader: list[int] = []

    def _listen(self, now: int) -> None:
        command = None
        if (first := self._first.read_newest(now)) is not None:
            command = Command(first.v, 0.0, first.w)
        if (second := self._second.read_newest(now)) is not None:
            command = Command(second.vx, second.vy, second.w)
        if command is not None:
            self._wait()
            self._command = command
        elif self._first.is_late(now) and self._second.is_late(now):
            self._command = REST
        if (target := self._target.read_newest(now)) is not None:
            self._follow(target)
        elif self._follower is not None and self._target.is_late(now):
            self._follower = None

    def _follow(self, target: iis.TimedPosition) -> None:
        # The track of another robot cannot be continued, so a new leader gets a new follower.
        if self._follower is None or target.id != self._leader:
            self._follower = WAYS[self.config.following]()
            self._leader = list(target.id)
        self._follower.observe(Pose(target.x, target.y, target.theta))
