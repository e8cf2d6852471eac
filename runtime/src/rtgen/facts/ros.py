"""Kinds of ROS 2 interface files, and the interfaces derived from actions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

INTERFACE_KINDS: Final = {".msg": "msg", ".srv": "srv", ".action": "action"}
"""The kinds of interface by suffix, which are also the names of their folders."""
INTERFACE_SUFFIXES: Final = tuple(INTERFACE_KINDS)

GENERATED_IDL: Final = b"// generated from rosidl_adapter/"
"""The beginning of an IDL file that ROS 2 generates from an interface file."""

EVENTS_SUFFIX: Final = "_Events"
"""Suffix of the interface by which an action server sends feedback and status."""
ACTION_SERVICES: Final = {
    "send_goal": "{}_SendGoal",
    "cancel_goal": "action_msgs/srv/CancelGoal",
    "get_result": "{}_GetResult",
}
ACTION_TOPICS: Final = {
    "feedback": "{}_FeedbackMessage",
    "status": "action_msgs/msg/GoalStatusArray",
}
"""The topics and services below `NAME/_action/` with their types; `{}` is the action
(`lab/action/Go`).
"""


def interface_beside(idl: Path) -> Path | None:
    """Return where the interface file is from which ROS 2 has generated an IDL file, if it has."""
    kind = idl.parent.name
    if idl.suffix.lower() != ".idl" or kind not in INTERFACE_KINDS.values():
        return None
    return idl.with_suffix(f".{kind}")


def is_interface(name: Sequence[str]) -> bool:
    """Return whether a scoped name is that of a ROS 2 message (`std_msgs::msg::Header`)."""
    return len(name) == 3 and name[1] in INTERFACE_KINDS.values()
