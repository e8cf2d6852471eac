"""RefHardRh2: the base RH2, which simulated sensors may ask where it is."""

from __future__ import annotations

from refnav.messages import pose_message
from refnav.simulated_ref_hard import SimulatedRefHard
from refrobots import iis
from refrobots.components.ref_hard_rh2 import RefHardRh2Base, RefHardRh2Configuration
from rtgen.runtime import ReturnCode_t


class RefHardRh2(SimulatedRefHard[RefHardRh2Configuration], RefHardRh2Base):
    """The simulated base."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Drive on, and send where the base truly is."""
        code = super().on_execute(ec_id)
        sample = iis.TimedPose2D(data=pose_message(self._base.pose))
        self.stamp(sample)
        self.PlantPose.write(sample)
        return code
