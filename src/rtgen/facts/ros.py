"""Interface files of ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

INTERFACE_KINDS: Final = {".msg": "msg", ".srv": "srv", ".action": "action"}
"""The kinds of interface by suffix; each stands in a folder of that name."""
INTERFACE_SUFFIXES: Final = tuple(INTERFACE_KINDS)

EVENTS_SUFFIX: Final = "_Events"
"""Of the interface by which the server of an action sends feedback and status."""
ACTION_SERVICES: Final = {
    "send_goal": "{}_SendGoal",
    "cancel_goal": "action_msgs/srv/CancelGoal",
    "get_result": "{}_GetResult",
}
ACTION_TOPICS: Final = {
    "feedback": "{}_FeedbackMessage",
    "status": "action_msgs/msg/GoalStatusArray",
}
"""What `NAME/_action/` holds, by name, with its types; `{}` is the action (`lab/action/Go`)."""


def is_interface(name: Sequence[str]) -> bool:
    """Whether a scoped name is that of a message of ROS 2 (`std_msgs::msg::Header`)."""
    return len(name) == 3 and name[1] in INTERFACE_KINDS.values()
