"""Common base of RefHardRh2 and RefHardRh3, which differ in the gear."""

from __future__ import annotations

from math import tau
from typing import Generic, Protocol, TypeVar

from refnav.base_control import (
    BaseControl,
    BaseParameters,
    PlantRoom,
    PlantSizes,
    PlantStart,
    TravelSwitch,
    contact,
    furnish,
    start_of,
    true_wheels,
)
from refnav.map_text import MapError
from refnav.messages import pose_message, pose_of
from refnav.plant import Plant, counted
from refrobots import RefHard, checkpoints, iis, rtc
from rtgen.runtime import (
    RTC_OK,
    Component,
    InPort,
    OutPort,
    Provider,
    ReturnCode_t,
)


class BaseSettings(BaseParameters, PlantRoom, PlantSizes, PlantStart, Protocol):
    """The parameters of a simulated base [m, rad/s]."""

    Velocity_limit: float
    Acceleration_limit: float
    GearRatio: float
    EncoderCount: int
    EncoderConstant_L: float
    EncoderConstant_R: float


P = TypeVar("P", bound=BaseSettings)


class SimulatedRefHard(Component, Generic[P]):
    """The simulated base.

    Like hardware, it outlives its driver: if the system keeps checkpoints, the base keeps its
    place, its stop and its encoders over a restart of the component's process.

    Its observables are `truth`, the true pose (x, y, theta) [m, rad], and `wheels`, the speeds of
    the left and the right wheel [rad/s].
    """

    config: P
    InTargetVelocity: InPort[iis.TimedVelocity2D]
    OutWheelAngle: OutPort[rtc.TimedDoubleSeq]
    PlantPose: OutPort[iis.TimedPose2D]
    InventGUIRefHard: Provider[RefHard]
    BumpRefHard: Provider[RefHard]

    def on_initialize(self) -> ReturnCode_t:
        """Place the base and offer its services."""
        self._base = Plant(true_wheels(self.config))
        self._angles = rtc.TimedDoubleSeq(data=[0.0, 0.0])
        self._switch = switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(switch)
        self.BumpRefHard.set_servant(switch.bumper)
        self._control = BaseControl(self.InTargetVelocity, self.config, switch)
        self._kept = self.add_checkpoint(checkpoints.Base)
        self.observables["truth"] = lambda: self._base.pose
        self.observables["wheels"] = lambda: tuple(self._base.speeds)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Switch the motors on, at rest; the base stays at its place."""
        config = self.config
        self._base.kinematics = true_wheels(config)
        try:
            furnish(self._base, config, self.folder)
        except MapError as error:
            return self.fail(f"PlantRoom: {error}")
        kept = self._kept.restored()
        if kept is not None:
            self._base.restore(pose_of(kept.pose), kept.angles)
        self._base.start(start_of(config))
        self._now = self.now()
        self._control.start(self._now)
        if kept is not None:
            self._switch.restore(stopped=kept.stopped, by_hand=kept.by_hand)
        return self.on_rate_changed(ec_id)

    def on_rate_changed(self, ec_id: int) -> ReturnCode_t:
        """Adopt the period of the executions."""
        context = self.get_context(ec_id)
        assert context is not None, "the component takes part in it"
        self._period = 1.0 / context.get_rate()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake: without the component the wheels are not driven."""
        self._base.halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._base.halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Simulate the wheels since the last execution, and send their angles."""
        config = self.config
        base = self._base
        now = self.now()
        # The base's controller ignores overruns: an overrun costs time, but does not change the
        # path.
        dt = min((now - self._now) * 1e-9, self._period)
        self._now = now
        # First the wheels move at their previous speeds: a command acts from now on.
        base.roll(dt)
        if base.touches:
            return self.fail(contact(base))
        wanted = self._control.wheel_speeds(now)
        base.drive(wanted, config.Velocity_limit, config.Acceleration_limit * dt)
        count = tau / (config.EncoderCount * config.GearRatio)
        if self._kept.is_kept:
            self._keep()
        left, right = base.angles
        angles = self._angles
        angles.data[0] = counted(left, count) * config.EncoderConstant_L
        angles.data[1] = counted(right, count) * config.EncoderConstant_R
        self.stamp(angles)
        self.OutWheelAngle.write(angles)
        self.PlantPose.offer(self._pose)
        return RTC_OK

    def _pose(self) -> iis.TimedPose2D:
        pose = iis.TimedPose2D(data=pose_message(self._base.pose))
        self.stamp(pose)
        return pose

    def _keep(self) -> None:
        base, switch = self._base, self._switch
        self._kept.save(
            checkpoints.Base(
                pose_message(base.pose), base.angles, switch.stopped, switch.by_hand
            )
        )
