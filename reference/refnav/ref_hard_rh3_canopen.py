"""RefHardRh3Canopen: drives the base by two CANopen drives, through the ports of their proxies."""

from __future__ import annotations

from refnav.base_control import BaseControl, TravelSwitch
from refnav.canopen_base import CanopenBase, WheelPorts, sample
from refrobots import eposdrive
from refrobots.components.ref_hard_rh3_canopen import RefHardRh3CanopenBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class RefHardRh3Canopen(RefHardRh3CanopenBase):
    """RefHardRh3 with a drive of CiA 402 at each wheel.

    Its observables are `truth`, the pose (x, y, theta) [m, rad] by the wheels' encoders and the
    plant's geometry, and `wheels`, the speeds of the left and the right wheel [rad/s].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Place the base and offer its services."""
        switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(switch)
        self.BumpRefHard.set_servant(switch.bumper)
        self._base = CanopenBase(
            [self._wheel("left")],
            [self._wheel("right")],
            self.config,
            BaseControl(self.InTargetVelocity, self.config, switch),
        )
        self.observables["truth"] = lambda: self._base.plant.pose
        self.observables["wheels"] = lambda: self._base.wheels
        return RTC_OK

    def _wheel(self, name: str) -> WheelPorts:
        return WheelPorts(
            name,
            self.in_ports[f"{name}_status"],
            self.in_ports[f"{name}_motion"],
            self.out_ports[f"{name}_control"],
            self.out_ports[f"{name}_target"],
            eposdrive.Rpdo1,
            eposdrive.Rpdo3,
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
