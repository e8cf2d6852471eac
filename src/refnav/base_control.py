"""What drives the base, wherever its wheels are: the velocity that it is to have, Stop and Go."""

from __future__ import annotations

from typing import Protocol

from refnav.geometry import Pose
from refnav.kinematics import TwoWheels
from refrobots import RefHard, iis
from rtgen.runtime import InPort


class TravelSwitch(RefHard):
    """What a user interface switches: its Go releases the base, whoever has stopped it.

    `bumper` is the same for a bumper, whose Go takes back no more than its own Stop.
    """

    def __init__(self) -> None:
        self.stopped = False
        self.bumper = Bumper(self)
        self._by_hand = False

    def Stop(self) -> None:
        """Stop the travelling base."""
        self.stopped = self._by_hand = True

    def Go(self) -> None:
        """Let the stopped base travel."""
        self.stopped = self._by_hand = False

    def release(self) -> None:
        """Let the base travel, unless it was stopped by hand."""
        self.stopped = self._by_hand


class Bumper(RefHard):
    """What a bumper switches."""

    def __init__(self, switch: TravelSwitch) -> None:
        self._switch = switch

    def Stop(self) -> None:
        """Stop the travelling base."""
        self._switch.stopped = True

    def Go(self) -> None:
        """Let the base travel, unless it was stopped by hand."""
        self._switch.release()


class BaseParameters(Protocol):
    """The parameters that turn velocities into wheel speeds [m, s]."""

    WheelTread: float
    WheelRadiusLeft: float
    WheelRadiusRight: float
    CommandTimeout: float


class PlantSizes(Protocol):
    """The parameters with the true sizes of a simulated base [m]."""

    PlantWheelTread: float
    PlantWheelRadiusLeft: float
    PlantWheelRadiusRight: float


class PlantStart(Protocol):
    """The parameters that say where a simulated base stands at first [m, rad]."""

    PlantStart_x: float
    PlantStart_y: float
    PlantStart_theta: float


def start_of(parameters: PlantStart) -> Pose:
    """Where the simulated base stands when it is first activated."""
    return Pose(
        parameters.PlantStart_x, parameters.PlantStart_y, parameters.PlantStart_theta
    )


def true_wheels(parameters: PlantSizes) -> TwoWheels:
    """The wheels of the simulated base."""
    return TwoWheels(
        parameters.PlantWheelRadiusLeft,
        parameters.PlantWheelRadiusRight,
        parameters.PlantWheelTread,
    )


class BaseControl:
    """Makes wheel speeds of the newest velocity; of none, once none has come for too long."""

    def __init__(
        self,
        port: InPort[iis.TimedVelocity2D],
        parameters: BaseParameters,
        switch: TravelSwitch,
    ) -> None:
        self._port = port
        self._parameters = parameters
        self._switch = switch
        self.start(0)

    def start(self, now: int) -> None:
        """At rest from now [ns] on, until a velocity comes."""
        self._switch.Go()
        self._vx = 0.0
        self._va = 0.0
        self._heard = now

    def wheel_speeds(self, now: int) -> tuple[float, float]:
        """The speeds that the left and the right wheel are to have now [ns]; in rad/s."""
        parameters = self._parameters
        port = self._port
        if port.is_new() and (command := port.read_newest()) is not None:
            self._vx = command.data.vx
            self._va = command.data.va
            self._heard = now
        elif 0.0 < parameters.CommandTimeout * 1e9 < now - self._heard:
            self._vx = self._va = 0.0
        if self._switch.stopped:
            return 0.0, 0.0
        sideways = 0.5 * self._va * parameters.WheelTread
        return (
            (self._vx - sideways) / parameters.WheelRadiusLeft,
            (self._vx + sideways) / parameters.WheelRadiusRight,
        )
