"""Names of topics, services and presences of a system, each in one place.

Instance and port names have any characters: octets of UTF-8 other than letters, digits and `_` are
written as `-` and two hexadecimal digits.
"""

from __future__ import annotations

import re
from typing import Any

from rtgen.runtime.distribution.medium import Topic

_OTHER = re.compile(rb"[^A-Za-z0-9_]")
_ESCAPE = re.compile(rb"-([0-9a-f]{2})")


def escaped(text: str) -> str:
    """The text as a part of a name."""
    return _OTHER.sub(lambda found: b"-%02x" % found[0][0], text.encode()).decode()


def unescaped(part: str) -> str:
    """The text of a part of a name. Raises UnicodeDecodeError for one of another program."""
    octets = part.encode()
    return _ESCAPE.sub(lambda found: bytes([int(found[1], 16)]), octets).decode()


def out_topic(instance: str, port: str, type_: type[Any]) -> Topic:
    """The topic of an OutPort."""
    return Topic(f"{escaped(instance)}/out/{escaped(port)}", type_)


def in_topic(instance: str, port: str, type_: type[Any]) -> Topic:
    """The topic that an InPort takes samples of other programs from."""
    return Topic(f"{escaped(instance)}/in/{escaped(port)}", type_)


def service_name(instance: str, port: str, interface: str) -> str:
    """The service of a provider."""
    return f"{escaped(instance)}/{escaped(port)}/{escaped(interface)}"


def control_name(instance: str) -> str:
    """The control service of an instance."""
    return f"{escaped(instance)}/control"


def presence_name(instance: str, process: str) -> str:
    """The name by which an instance of a process is announced."""
    return f"{escaped(instance)}/{process}"


def present(name: str) -> tuple[str, str] | None:
    """The instance and the process of a presence; None for that of another program."""
    part, _, process = name.rpartition("/")
    try:
        return unescaped(part), process
    except UnicodeDecodeError:
        return None
