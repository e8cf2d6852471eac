"""What rosidl makes of packages of interface files: run in an installation of ROS 2, without rtgen.

    rosidl_hashes.py FOLDER PACKAGE...

The packages are below FOLDER, each after those that it needs; others are those of the installation.
The output is JSON: by the name of each type its hash, and of messages the constants and defaults.
"""

from __future__ import annotations

import contextlib
import json
import sys
from ast import literal_eval
from pathlib import Path
from typing import Any

from rosidl_adapter import convert_to_idl
from rosidl_generator_type_description import generate_type_hash
from rosidl_parser.definition import (
    AbstractNestedType,
    Action,
    IdlLocator,
    Message,
    Service,
)
from rosidl_parser.parser import parse_idl_file

KINDS = ("msg", "srv", "action")


def values(message: Message) -> dict[str, Any]:
    """Return the constants and defaults of a message."""
    defaults = {}
    for member in message.structure.members:
        if member.has_annotation("default"):
            value = member.get_annotation_value("default")["value"]
            if isinstance(member.type, AbstractNestedType):
                value = literal_eval(value)
            defaults[member.name] = value
    return {
        "constants": {each.name: each.value for each in message.constants},
        "defaults": defaults,
    }


def messages(element: Any) -> list[Message]:
    """Return the messages of an interface file."""
    if isinstance(element, Message):
        return [element]
    if isinstance(element, Service):
        return [element.request_message, element.response_message]
    if isinstance(element, Action):
        return [element.goal, element.result, element.feedback]
    return []


def main(folder: Path, packages: list[str]) -> None:
    share = Path(sys.prefix) / "share"
    includes = {path.name: path for path in share.iterdir() if (path / "msg").is_dir()}
    found: dict[str, Any] = {"hashes": {}, "values": {}}
    for package in packages:
        source, made = folder / package, folder / "made" / package
        locators = []
        for kind in KINDS:
            for path in sorted((source / kind).glob(f"*.{kind}")):
                (made / kind).mkdir(parents=True, exist_ok=True)
                relative = path.relative_to(source)
                with contextlib.redirect_stdout(sys.stderr):
                    idl = convert_to_idl(source, package, relative, made / kind)
                locators.append((made, idl.relative_to(made)))
        arguments = folder / "made" / f"{package}.json"
        arguments.write_text(
            json.dumps(
                {
                    "package_name": package,
                    "output_dir": str(made),
                    "idl_tuples": [":".join(map(str, each)) for each in locators],
                    "include_paths": [f"{k}:{v}" for k, v in includes.items()],
                }
            )
        )
        includes[package] = made
        for path in generate_type_hash(str(arguments)):
            for entry in json.loads(Path(path).read_text())["type_hashes"]:
                found["hashes"][entry["type_name"]] = entry["hash_string"]
        for locator in locators:
            for element in parse_idl_file(IdlLocator(*locator)).content.elements:
                for message in messages(element):
                    name = "/".join(message.structure.namespaced_type.namespaced_name())
                    found["values"][name] = values(message)
    print(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
