"""What properties of connectors and of topics have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

TRANSPORTS: Final = (
    *("ros2", "fast-rtps", "opensplice", "cyclone-dds", "rti-connext-dds"),
    *("rti-connext-dds-micro", "iceoryx"),
)
"""Names of OpenRTM-aist's transports that publish topics, in `dataport.interface_type`."""

Check: TypeAlias = Callable[[str], str | None]
"""Function that returns the expected form of an invalid property text; None for a valid one."""
