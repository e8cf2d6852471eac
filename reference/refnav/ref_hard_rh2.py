"""RefHardRh2: the base of RH2, with another gear than that of RH3."""

from __future__ import annotations

from refnav.simulated_ref_hard import SimulatedRefHard
from refrobots.components.ref_hard_rh2 import RefHardRh2Base, RefHardRh2Configuration


class RefHardRh2(SimulatedRefHard[RefHardRh2Configuration], RefHardRh2Base):
    """The simulated base."""
