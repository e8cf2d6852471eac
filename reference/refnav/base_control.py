"""Control of a base with any kind of wheels: commanded velocity, Stop and Go."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from refnav.geometry import Pose
from refnav.kinematics import TwoWheels
from refnav.map_text import text_of
from refnav.newest import Newest
from refnav.plant import Plant
from refnav.room import Room, parse
from refrobots import RefHard, iis
from rtgen.runtime import InPort


class TravelSwitch(RefHard):
    """The switch of a user interface: its Go releases the base, whoever stopped it.

    `bumper` is the switch of a bumper, whose Go only cancels its own Stop.
    """

    def __init__(self) -> None:
        self.stopped = False
        self.bumper = Bumper(self)
        self._by_hand = False

    def Stop(self) -> None:
        """Stop the base."""
        self.stopped = self._by_hand = True

    def Go(self) -> None:
        """Release the base."""
        self.stopped = self._by_hand = False

    @property
    def by_hand(self) -> bool:
        """Whether this switch itself stopped the base."""
        return self._by_hand

    def restore(self, *, stopped: bool, by_hand: bool) -> None:
        """Restore the state of the switch from a checkpoint."""
        self.stopped, self._by_hand = stopped, by_hand

    def release(self) -> None:
        """Release the base, unless it was stopped by hand."""
        self.stopped = self._by_hand


class Bumper(RefHard):
    """The switch of a bumper."""

    def __init__(self, switch: TravelSwitch) -> None:
        self._switch = switch

    def Stop(self) -> None:
        """Stop the base."""
        self._switch.stopped = True

    def Go(self) -> None:
        """Release the base, unless it was stopped by hand."""
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
    """The parameters of the start pose of a simulated base [m, rad]."""

    PlantStart_x: float
    PlantStart_y: float
    PlantStart_theta: float


class PlantRoom(Protocol):
    """The parameters of the obstacles of a simulated base [m]."""

    PlantRoom: str
    PlantRadius: float


def furnish(plant: Plant, parameters: PlantRoom, folder: Path) -> None:
    """Add the room of the parameters to the simulated base. Raises MapError."""
    plant.radius = parameters.PlantRadius
    name = parameters.PlantRoom
    plant.room = parse(text_of(folder, name), name) if name else Room(())


def contact(plant: Plant) -> str:
    """Return the condition to report while the base touches an obstacle."""
    return f"contact with an obstacle at ({plant.x:.3f}, {plant.y:.3f})"


def start_of(parameters: PlantStart) -> Pose:
    """Return the pose of the simulated base at its first activation."""
    return Pose(
        parameters.PlantStart_x, parameters.PlantStart_y, parameters.PlantStart_theta
    )


def true_wheels(parameters: PlantSizes) -> TwoWheels:
    """Return the wheels of the simulated base."""
    return TwoWheels(
        parameters.PlantWheelRadiusLeft,
        parameters.PlantWheelRadiusRight,
        parameters.PlantWheelTread,
    )


class BaseControl:
    """Computes wheel speeds from the newest velocity; 0 once the velocity is too old."""

    def __init__(
        self,
        port: InPort[iis.TimedVelocity2D],
        parameters: BaseParameters,
        switch: TravelSwitch,
    ) -> None:
        self._command = Newest[iis.TimedVelocity2D](
            port, lambda: parameters.CommandTimeout
        )
        self._parameters = parameters
        self._switch = switch
        self.start(0)

    def start(self, now: int) -> None:
        """Start at rest at the time `now` [ns], until a velocity arrives."""
        self._switch.Go()
        self._vx = 0.0
        self._va = 0.0
        self._command.start(now)

    def wheel_speeds(self, now: int) -> tuple[float, float]:
        """Return the target speeds of the left and the right wheel at `now` [ns]; in rad/s."""
        parameters = self._parameters
        if (command := self._command.read_newest(now)) is not None:
            self._vx = command.data.vx
            self._va = command.data.va
        elif self._command.is_late(now):
            self._vx = self._va = 0.0
        if self._switch.stopped:
            return 0.0, 0.0
        sideways = 0.5 * self._va * parameters.WheelTread
        return (
            (self._vx - sideways) / parameters.WheelRadiusLeft,
            (self._vx + sideways) / parameters.WheelRadiusRight,
        )
