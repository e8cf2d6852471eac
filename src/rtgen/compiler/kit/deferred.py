"""Names of a package that one of its modules defines, imported when they are first used."""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib import import_module
from typing import Any


def deferred(module: str, names: Collection[str]) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package: the names are those of a module."""

    def attribute(name: str) -> Any:
        if name in names:
            return getattr(import_module(module), name)
        package = module.rpartition(".")[0]
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return attribute
