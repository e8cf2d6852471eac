"""References to messages: `Name`, `package/Name`, `package/msg/Name`."""

from __future__ import annotations

from rtgen.compiler.model import ScopedName
from rtgen.ros2.rosidl.interfaces import PARTS
from rtgen.ros2.rosidl.syntax import MESSAGE_NAME, PACKAGE_NAME


def scoped(base: str, package: str) -> ScopedName | None:
    """Return the scoped name of a message used in a package; None if it is not a name."""
    words = base.split("/")
    if len(words) == 1:
        words = [package, *words]
    if len(words) == 2:
        words.insert(1, "msg")
    if len(words) != 3 or not PACKAGE_NAME.fullmatch(words[0]):
        return None
    name = words[2].partition("_")[0] if words[1] == "action" else words[2]
    if words[1] not in PARTS or not MESSAGE_NAME.fullmatch(name):
        return None
    return tuple(words)
