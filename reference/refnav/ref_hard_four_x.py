"""RefHardFourX: drives a base by four CANopen drives, through the ports of their proxies."""

from __future__ import annotations

from math import pi

from refnav.base_control import BaseControl, TravelSwitch
from refnav.canopen_base import CanopenBase, WheelPorts, sample
from refrobots import ftmd
from refrobots.components.ref_hard_four_x import RefHardFourXBase
from rtgen.runtime import RTC_OK, ReturnCode_t

_DEGREE = pi / 180.0


class RefHardFourX(RefHardFourXBase):
    """A base with four driven wheels; those of a side have one speed.

    Its observables are `truth`, the pose (x, y, theta) [m, rad] by the wheels' encoders and the
    plant's geometry, and `wheels`, the speeds of the wheels [rad/s]: front left, rear left, front
    right, rear right.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Place the base and offer its services."""
        switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(switch)
        self.BumpRefHard.set_servant(switch.bumper)
        self._base = CanopenBase(
            [self._wheel("front_left"), self._wheel("rear_left")],
            [self._wheel("front_right"), self._wheel("rear_right")],
            self.config,
            BaseControl(self.InTargetVelocity, self.config, switch),
        )
        self.observables["truth"] = lambda: self._base.plant.pose
        self.observables["wheels"] = lambda: self._base.wheels
        return RTC_OK

    def _wheel(self, name: str) -> WheelPorts:
        return WheelPorts(
            name.replace("_", " "),
            self.in_ports[f"{name}_status"],
            self.in_ports[f"{name}_motion"],
            self.out_ports[f"{name}_control"],
            self.out_ports[f"{name}_target"],
            ftmd.Rpdo1,
            ftmd.Rpdo3,
            unit=_DEGREE,
        )

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest; the drives may be missing yet."""
        self._base.start(self.now())
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Stop the wheels."""
        self._base.stop()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the wheels."""
        self._base.stop()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Command the drives, and send the wheel angles once all drives send theirs."""
        angles = self._base.step(self.now())
        if angles is not None:
            turned = sample(angles)
            self.stamp(turned)
            self.OutWheelAngle.write(turned)
        return RTC_OK
