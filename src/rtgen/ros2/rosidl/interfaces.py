"""Messages of an interface file: those of its parts, and those that ROS 2 derives from them.

A service has a request and a response; an action a goal, a result and feedback, and the services
and the message that transport them (ROS 2 design, "Actions", section "Introspection tools").
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import ScopedName
from rtgen.ros2.rosidl.syntax import Field, FieldType, Part

PARTS: Final = {
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
"""Suffixes of the messages of each part, by the kind of file."""

_UUID: Final = "unique_identifier_msgs/UUID"
_TIME: Final = "builtin_interfaces/Time"
DERIVED: Final = {
    "_SendGoal_Request": (("goal_id", _UUID), ("goal", "_Goal")),
    "_SendGoal_Response": (("accepted", "bool"), ("stamp", _TIME)),
    "_GetResult_Request": (("goal_id", _UUID),),
    "_GetResult_Response": (("status", "int8"), ("result", "_Result")),
    "_FeedbackMessage": (("goal_id", _UUID), ("feedback", "_Feedback")),
}
"""Messages of an action besides its parts: fields with their types or suffixes."""


class Message(msgspec.Struct, frozen=True):
    """A message with its scoped name (`package`, `msg`, `Name`)."""

    name: ScopedName
    part: Part
    span: Span


def messages_of(
    package: str, kind: str, name: str, parts: Sequence[Part], span: Span
) -> Iterator[Message]:
    """Yield the messages of a file, contained ones first."""
    for suffix, part in zip(PARTS[kind], parts, strict=True):
        yield Message((package, kind, name + suffix), part, span)
    if kind == "action":
        for suffix, members in DERIVED.items():
            fields = tuple(
                Field(
                    field,
                    FieldType(
                        f"{package}/action/{name}{base}" if base[0] == "_" else base,
                        span,
                    ),
                    span,
                    "",
                )
                for field, base in members
            )
            yield Message((package, kind, name + suffix), Part(fields, (), ""), span)
