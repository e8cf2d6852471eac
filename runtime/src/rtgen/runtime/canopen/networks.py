"""Loads generated networks by name."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from rtgen.runtime.canopen.description import Network


class UnknownNetworkError(LookupError):
    """There is no network of that name; the message lists the known ones."""


def load_network(package: str, name: str) -> Network:
    """Load a network from a package of networks. Raises UnknownNetworkError."""
    try:
        names = sorted(module.name for module in iter_modules(_path_of(package)))
    except ModuleNotFoundError:
        names = []
    if name not in names:
        existing = f"there are {', '.join(names)}" if names else "none is generated"
        raise UnknownNetworkError(f"there is no network {name!r}; {existing}")
    network: Network = import_module(f"{package}.{name}").NETWORK
    return network


def _path_of(package: str) -> list[str]:
    return list(import_module(package).__path__) if package else []
