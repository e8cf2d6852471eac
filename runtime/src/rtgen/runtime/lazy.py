"""Lazy imports for packages that re-export names."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, modules: Mapping[str, Sequence[str]]
) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package, which caches found names as attributes.

    `modules` has the names that each module defines, by its name relative to the package: `Name`,
    `Name as Other`, or `Name.inner as Other`.
    """
    homes: dict[str, tuple[str, str]] = {}
    for module, names in modules.items():
        for text in names:
            name, _, public = text.partition(" as ")
            homes[public or name] = module, name

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, path = homes[name]
        value: Any = reduce(getattr, path.split("."), import_module(module, package))
        setattr(sys.modules[package], name, value)
        return value

    return get
