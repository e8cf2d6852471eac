"""What rosidl reads in interface files: run in an installation of ROS 2, without rtgen.

Each line of its input is the text of a `.msg` file in JSON. Each line of its output is null for a
text that rosidl refuses, else its constants and the defaults of its fields: rosidl_adapter converts
the text to IDL, which rosidl_parser reads.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
from ast import literal_eval
from typing import Any

from rosidl_adapter.parser import parse_message_string
from rosidl_adapter.resource import evaluate_template
from rosidl_parser.definition import AbstractNestedType, Message
from rosidl_parser.parser import parse_idl_string


def read(text: str) -> dict[str, Any]:
    """Return the constants and defaults of a message. Raises various exceptions."""
    message = parse_message_string("lab", "Drawn", text)
    data = {"pkg_name": "lab", "relative_input_file": "Drawn.msg", "msg": message}
    idl = evaluate_template("msg.idl.em", data)
    # As through a file, which is written in one encoding and read in another.
    octets = io.BytesIO(idl.encode("iso-8859-1"))
    content = parse_idl_string(io.TextIOWrapper(octets, encoding="utf-8").read())
    [found] = content.get_elements_of_type(Message)
    defaults = {}
    for member in found.structure.members:
        if member.has_annotation("default"):
            value = member.get_annotation_value("default")["value"]
            if isinstance(member.type, AbstractNestedType):
                value = literal_eval(value)
            defaults[member.name] = value
    return {
        "constants": {each.name: each.value for each in found.constants},
        "defaults": defaults,
        "fields": [member.name for member in found.structure.members],
    }


def main() -> None:
    for line in sys.stdin:
        text = json.loads(line)
        with contextlib.redirect_stderr(io.StringIO()):
            try:
                answer = read(text)
            except (Exception, SystemExit) as error:
                answer = None
                del error
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
