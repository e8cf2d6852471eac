"""RefHardRh3: drives the wheels of the simulated base and reads their encoders."""

from __future__ import annotations

from refnav.simulated_ref_hard import SimulatedRefHard
from refrobots.components.ref_hard_rh3 import RefHardRh3Base, RefHardRh3Configuration


class RefHardRh3(SimulatedRefHard[RefHardRh3Configuration], RefHardRh3Base):
    """The simulated base."""
