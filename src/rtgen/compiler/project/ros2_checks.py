"""Checks of `[ros2]` in `rtgen.toml`; each returns what is wrong with a value, or None."""

from __future__ import annotations

from typing import Any

from rtgen.compiler.project.checks import Problem, did_you_mean, is_constants, near
from rtgen.facts import ros_names, ros_qos_words, ros_transforms
from rtgen.facts.ros_marshaling import parse as parse_marshaling


def name(value: Any) -> str | None:
    """Check the name of a node or namespace."""
    problem = (
        "" if not isinstance(value, str) else ros_names.violation(value.strip("/"))
    )
    if value == "/" or problem is None:
        return None
    return f"must be a name of ROS 2, which {problem or 'is a string'}"


def maintainer(value: Any) -> str | None:
    """Check the maintainer of packages."""
    fine = isinstance(value, str) and ros_names.MAINTAINER.fullmatch(value)
    return None if fine else "must be 'NAME <EMAIL>'"


_TOPIC_KEYS = ("topic", "qos", "marshaling_type", "set", *ros_qos_words.POLICIES)


def topics(value: Any) -> str | None:
    """Check topics by port; each is a name, or a table with QoS."""
    if not isinstance(value, dict):
        return "must be a table of INSTANCE.PORT to topics"
    problems = (_topic(port, entry) for port, entry in value.items())
    return next((each for each in problems if each is not None), None)


def _topic(port: str, entry: Any) -> Problem | None:
    if port.count(".") != 1:
        return Problem(f"holds {port!r}, which is not INSTANCE.PORT", port)
    table = {"topic": entry} if isinstance(entry, str) else entry
    if not isinstance(table, dict) or not isinstance(table.get("topic"), str):
        return Problem(
            f"holds {port!r}, which must be 'NAME' or {{ topic = 'NAME', qos = 'PROFILE' }}",
            port,
        )
    for key in table:
        if key not in _TOPIC_KEYS:
            hint = did_you_mean(key, _TOPIC_KEYS)
            return Problem(f"gives {port!r} the unknown key {key!r}", port, hint)
    if why := ros_names.violation(table["topic"]):
        return Problem(
            f"gives {port!r} the topic {table['topic']!r}; a name of ROS 2 {why}", port
        )
    marshaling = table.get("marshaling_type", "ros2:std_msgs/String")
    if not isinstance(marshaling, str) or parse_marshaling(marshaling) is None:
        return Problem(
            f"gives {port!r} the marshaling_type {marshaling!r}, "
            "which is not ros2:PACKAGE/TYPE",
            port,
        )
    if problem := _set_of(table):
        return Problem(f"gives {port!r} `set`, {problem}", port)
    return _qos(port, table)


def _qos(port: str, table: dict[str, Any]) -> Problem | None:
    """Check the QoS of a topic."""
    values: dict[str, Any] = {}
    for key in ("qos", *ros_qos_words.POLICIES):
        if key not in table:
            continue
        try:
            values[key] = ros_qos_words.value_of(key, table[key])
        except ValueError as error:
            known = ros_qos_words.words(key)
            text = table[key]
            is_text = isinstance(text, str)
            message = f"gives {port!r} the {key} {text!r}; " + (
                f"known: {', '.join(known)}" if known else f"it must be {error}"
            )
            hint = near(text, known) if is_text else None
            return Problem(message, port, hint, text if is_text else None)
    if ros_qos_words.has_idle_depth(values):
        why, what = ros_qos_words.WHY_IDLE
        return Problem(f"gives {port!r} a depth without effect: {why}", port, what)
    return None


def _set_of(table: dict[str, Any]) -> str | None:
    """Return what is wrong with the constants of a topic."""
    fixed = table.get("set", {})
    if not (isinstance(fixed, dict) and is_constants(fixed)):
        return "which must be a table of members to texts, numbers, or lists of them"
    if fixed and "marshaling_type" not in table:
        return "which goes with a marshaling_type: other data are sent as they are"
    return None


def transforms(value: Any) -> str | None:
    """Check transforms by port, and constant ones."""
    if not isinstance(value, dict):
        return "must be a table of INSTANCE.PORT to frames"
    pairs = []
    for key, entry in value.items():
        if key == ros_transforms.STATIC:
            tables = entry if isinstance(entry, list) else [entry]
            for table in tables:
                if why := ros_transforms.static_violation(table):
                    return Problem(f"holds a constant transform that {why}", key)
                pairs.append((table["parent"], table["child"]))
            continue
        if key.count(".") != 1:
            return Problem(f"holds {key!r}, which is not INSTANCE.PORT", key)
        if not isinstance(entry, dict) or not set(entry) <= {"parent", "child"}:
            form = '{ parent = "FRAME", child = "FRAME" }'
            return Problem(f"holds {key!r}, which must be {form}", key)
        for end, frame in entry.items():
            if why := ros_transforms.frame_violation(frame):
                return Problem(f"gives {key!r} the {end} {frame!r}, which {why}", key)
        pairs.append((entry.get("parent", ""), entry.get("child", "")))
    return ros_transforms.tree_violation(pairs)


def names(dots: int, form: str, what: str, value: Any) -> str | None:
    """Check services by operation, or actions by port."""
    if not isinstance(value, dict):
        return f"must be a table of {form} to {what}s"
    for key, name in value.items():
        if key.count(".") != dots:
            return Problem(f"holds {key!r}, which is not {form}", key)
        if not isinstance(name, str):
            return Problem(f"holds {key!r}, which must be 'NAME'", key)
        if why := ros_names.violation(name):
            return Problem(
                f"gives {key!r} the {what} {name!r}; a name of ROS 2 {why}", key
            )
    return None
