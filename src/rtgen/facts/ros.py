"""Interface files of ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

INTERFACE_KINDS: Final = {".msg": "msg", ".srv": "srv", ".action": "action"}
"""The kinds of interface by suffix; each stands in a folder of that name."""
INTERFACE_SUFFIXES: Final = tuple(INTERFACE_KINDS)


def is_interface(name: Sequence[str]) -> bool:
    """Whether a scoped name is that of a message of ROS 2 (`std_msgs::msg::Header`)."""
    return len(name) == 3 and name[1] in INTERFACE_KINDS.values()
