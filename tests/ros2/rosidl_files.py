"""Interface files and the IDL beside them, as rosidl reads both: run in an installation of ROS 2.

The arguments are folders of packages. A line for each IDL file: its name, and whether its messages
have the members of the `.msg` or `.srv` file beside it, which rosidl_adapter converts to IDL.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
from pathlib import Path

from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl
from rosidl_parser.definition import IdlContent, Message, Service
from rosidl_parser.parser import parse_idl_string


def structures(content: IdlContent) -> list[tuple[str, list[tuple[str, object]]]]:
    """Return the structs with their members' names and types."""
    messages = content.get_elements_of_type(Message)
    for service in content.get_elements_of_type(Service):
        messages += [service.request_message, service.response_message]
    return [
        (
            "::".join(message.structure.namespaced_type.namespaced_name()),
            [(member.name, member.type) for member in message.structure.members],
        )
        for message in messages
    ]


def main() -> None:
    for folder in (Path(each).absolute() for each in sys.argv[1:]):
        for idl in sorted(folder.glob("*/*.idl")):
            kind = idl.parent.name
            convert = {"msg": convert_msg_to_idl, "srv": convert_srv_to_idl}[kind]
            own = parse_idl_string(idl.read_text())
            with (
                tempfile.TemporaryDirectory() as out,
                contextlib.redirect_stdout(io.StringIO()),
            ):
                source = idl.relative_to(folder).with_suffix(f".{kind}")
                convert(folder, folder.name, source, Path(out))
                other = parse_idl_string((Path(out) / idl.name).read_text())
            is_same = structures(own) == structures(other)
            print(f"{folder.name}/{kind}/{idl.stem}", is_same)


if __name__ == "__main__":
    main()
