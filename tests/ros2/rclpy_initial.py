"""Prints a line of JSON for each class of messages in an installation of ROS 2: name, new object.

Run in the installation, without rtgen. Arguments are packages.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import sys
from collections.abc import Iterator
from typing import Any

from rclpy_peer import plain


def classes(package: str) -> Iterator[tuple[str, Any]]:
    """Yield the classes of messages, requests, goals ... of a package, by ROS 2's names."""
    for kind in ("msg", "srv", "action"):
        try:
            folder = importlib.import_module(f"{package}.{kind}")
        except ModuleNotFoundError:
            continue
        for found in pkgutil.iter_modules(folder.__path__):
            module = importlib.import_module(f"{package}.{kind}.{found.name}")
            for name, value in vars(module).items():
                own = getattr(value, "__module__", "") == module.__name__
                if own and hasattr(value, "get_fields_and_field_types"):
                    yield f"{package}/{kind}/{name}", value


for package in sys.argv[1:]:
    for name, class_ in classes(package):
        print(json.dumps([name, plain(class_())]))
