"""Definitions of types for `~/get_type_description`: files of the project, then those of rtgen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.kit.resources import ros_file
from rtgen.facts.files import UnreadableError, read_file
from rtgen.ros2.rosidl import rules
from rtgen.ros2.rosidl.syntax import parts_of
from rtgen.runtime.ros2.descriptions import Definition

_PARTS = {
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
"""The types that are the parts of a file, by its kind."""
_DERIVED = (
    *("_SendGoal_Request", "_SendGoal_Response", "_SendGoal_Event", "_SendGoal"),
    *("_GetResult_Request", "_GetResult_Response", "_GetResult_Event", "_GetResult"),
    *("_FeedbackMessage", "_Event"),
)
"""Ends of the names of further types that ROS 2 derives from a file."""


def definitions(folders: Sequence[Path]) -> Callable[[str], Definition | None]:
    """Return a function for the definitions of types below folders of packages."""

    @cache
    def definition(name: str) -> Definition | None:
        package, kind, last = name.split("/")
        for end in ("", *_PARTS.get(kind, ()), *_DERIVED):
            if not last.endswith(end) or (kind == "msg" and end):
                continue
            stem = last[: len(last) - len(end)]
            text = _text(f"{package}/{kind}/{stem}.{kind}", folders)
            if text is None:
                continue
            if not end:
                return Definition(
                    kind, text, _defaults(text, 0) if kind == "msg" else {}
                )
            parts = _PARTS.get(kind, ())
            number = parts.index(end) if end in parts else -1
            return Definition("implicit", "", _defaults(text, number))
        return None

    return definition


def _text(file: str, folders: Sequence[Path]) -> str | None:
    try:
        found = [path for folder in folders if (path := folder / file).is_file()]
        path = found[0] if found else ros_file(file)
        # rosidl keeps the lines, too, without the end of the last one.
        return "\n".join(read_file(path).decode("utf-8", "replace").splitlines())
    except (UnreadableError, OSError):
        return None


def _defaults(text: str, number: int) -> dict[str, str]:
    """Return the defaults of the fields of a part of a file, as rosidl writes them."""
    if number < 0:
        return {}
    parts = parts_of(text, "", Findings(rules.TOO_MANY))
    fields = parts[number].fields if number < len(parts) else ()
    return {
        field.name: str(field.value)
        for field in fields
        if field.value is not None and not field.constant
    }
