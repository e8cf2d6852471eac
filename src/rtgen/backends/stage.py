"""The back ends: the built-in ones, then those of plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import TYPE_CHECKING, Final, cast

from rtgen import plugins
from rtgen.backends import Backend

if TYPE_CHECKING:
    from rtgen.model import Model

BUILT_IN: Final = (
    "rtgen.backends.types",
    "rtgen.backends.components",
    "rtgen.backends.rtc_profile",
    "rtgen.backends.tecs",
    "rtgen.backends.canopen",
    "rtgen.backends.adapters",
    "rtgen.backends.openrtm",
    "rtgen.backends.small",
)
"""The modules of the built-in back ends, in the order of their artifacts; each has `BACKEND`."""


def backends() -> Iterator[Backend]:
    """All back ends. Raises ToolError for a plug-in that cannot be imported."""
    for module in BUILT_IN:
        yield cast("Backend", import_module(module).BACKEND)
    for _, backend in plugins.loaded(plugins.Group.BACKENDS):
        yield cast("Backend", backend)


def printed_idl(model: Model) -> dict[str, Callable[[], str]]:
    """The IDL files that back ends print and definitions may include: their texts by name."""
    if not model.devices and not model.buses:
        return {}
    from rtgen.backends.canopen.idl_file import idl_files

    return idl_files(model)
