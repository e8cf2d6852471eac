"""A node that calls services of a board: run in an installation of ROS 2, without rtgen.

Each line of the input names the service, its class and the fields of a request, those of structs
as objects: `["/room/lamp/dim", "lit_lamp.srv.LampDim", {"percent": 5}]`. The fields of the response
are a line of the output.
"""

from __future__ import annotations

import importlib
import json
import sys
from typing import Any

import rclpy


def fill(message: Any, values: dict[str, Any]) -> None:
    """Set fields of a message."""
    for name, value in values.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)


def fields(value: Any) -> Any:
    """Return the fields of a message, and values of fields as they are in JSON."""
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        return {name: fields(getattr(value, name)) for name in names}
    if hasattr(value, "tolist"):
        return value.tolist()
    return (
        value if isinstance(value, bool | int | float | str) else [*map(fields, value)]
    )


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("board_client")
    clients: dict[str, Any] = {}
    for line in sys.stdin:
        service, class_name, values = json.loads(line)
        module, _, name = class_name.rpartition(".")
        class_ = getattr(importlib.import_module(module), name)
        if service not in clients:
            clients[service] = node.create_client(class_, service)
        while not clients[service].wait_for_service(1.0):
            pass
        request = class_.Request()
        fill(request, values)
        future = clients[service].call_async(request)
        rclpy.spin_until_future_complete(node, future)
        print(json.dumps(fields(future.result())), flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
