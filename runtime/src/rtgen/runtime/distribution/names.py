"""Names of topics, services and presences of a system.

Instance and port names have any characters: octets of UTF-8 other than letters, digits and `_` are
written as `-` and two hexadecimal digits.
"""

from __future__ import annotations

import re
from typing import Any

from rtgen.runtime.distribution.medium import Topic

ENDING = "-ends"
"""The end of the process in a name that announces its end."""
_OTHER = re.compile(rb"[^A-Za-z0-9_]")
_ESCAPE = re.compile(rb"-([0-9a-f]{2})")


def escaped(text: str) -> str:
    """Return the text as a part of a name."""
    return _OTHER.sub(lambda match: b"-%02x" % match[0][0], text.encode()).decode()


def unescaped(part: str) -> str:
    """Return the text of a part of a name; other programs' raise UnicodeDecodeError."""
    octets = part.encode()
    return _ESCAPE.sub(lambda match: bytes([int(match[1], 16)]), octets).decode()


def out_topic(instance: str, port: str, type_: type[Any]) -> Topic:
    """Return the topic of an OutPort."""
    return Topic(f"{escaped(instance)}/out/{escaped(port)}", type_)


def in_topic(instance: str, port: str, type_: type[Any]) -> Topic:
    """Return the topic from which an InPort reads samples of other programs."""
    return Topic(f"{escaped(instance)}/in/{escaped(port)}", type_)


def service_name(instance: str, port: str, interface: str) -> str:
    """Return the service of a provider."""
    return f"{escaped(instance)}/{escaped(port)}/{escaped(interface)}"


def control_name(instance: str) -> str:
    """Return the control service of an instance."""
    return f"{escaped(instance)}/control"


def presence_name(instance: str, process: str) -> str:
    """Return the name that announces an instance of a process."""
    return f"{escaped(instance)}/{process}"


def ending_name(instance: str, process: str) -> str:
    """Return the name that announces that a process with an instance is about to end."""
    return presence_name(instance, f"{process}{ENDING}")


def present(name: str) -> tuple[str, str] | None:
    """Return instance and process of a presence; None for one of another program."""
    part, _, process = name.rpartition("/")
    try:
        return unescaped(part), process
    except UnicodeDecodeError:
        return None
