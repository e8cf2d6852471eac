"""Interface files of ROS 2."""

from __future__ import annotations

from typing import Final

INTERFACE_KINDS: Final = {".msg": "msg", ".srv": "srv", ".action": "action"}
"""The kinds of interface by suffix; each stands in a folder of that name."""
INTERFACE_SUFFIXES: Final = tuple(INTERFACE_KINDS)
