"""Lazy imports for packages that re-export names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, modules: Mapping[str, Sequence[str]]
) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package.

    `modules` has the names that each module defines, by its name relative to the package: `Name`,
    or `Name as Other`.
    """
    homes: dict[str, tuple[str, str]] = {}
    for module, names in modules.items():
        for text in names:
            name, _, public = text.partition(" as ")
            homes[public or name] = module, name

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, local = homes[name]
        return getattr(import_module(module, package), local)

    return get
