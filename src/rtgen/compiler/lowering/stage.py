"""The lowering stage: the signature of a lowering, and the list of all lowerings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from typing import Final, TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.kit import plugins, stages
from rtgen.compiler.kit.resources import IDL_FILES, idl_key
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.model import Model


class Lowered(msgspec.Struct, frozen=True):
    """A lowered model with the diagnostics."""

    model: Model
    diagnostics: tuple[Diagnostic, ...] = ()


Lower: TypeAlias = Callable[[Model, Settings], Lowered]
"""Signature of a lowering, a pure function."""


def _no_idl(_: Model) -> list[str]:
    return []


class Lowering(msgspec.Struct, frozen=True):
    """A lowering of rtgen: its module defines `lower`, and is imported only if the model needs it.

    `idl` returns the names of rtgen's IDL files whose types the lowering uses. `definitions`: the
    result counts as definitions of the project, which `inspect` shows.
    """

    module: str
    needed: Callable[[Model, Settings], bool]
    idl: Callable[[Model], list[str]] = _no_idl
    definitions: bool = False

    @property
    def name(self) -> str:
        """The name of its module or package."""
        return self.module.removeprefix("rtgen.compiler.lowering.").partition(".")[0]

    def __call__(self, model: Model, settings: Settings) -> Lowered:
        """Return the lowered model; the model itself if it has nothing to lower."""
        if not self.needed(model, settings):
            return Lowered(model)
        lower: Lower = import_module(self.module).lower
        return lower(model, settings)


def _idl_of_devices(model: Model) -> list[str]:
    if not model.devices and not model.buses:
        return []
    return [
        *("BasicDataType.idl", "Canopen.idl"),
        *(["CanopenManager.idl"] if model.buses else []),
    ]


def _idl_of_profiles(model: Model) -> list[str]:
    if not model.profiles:
        return []
    from rtgen.compiler.lowering.openrtm_idl import needed_idl

    return needed_idl(model.profiles)


LOWERINGS: Final = (
    Lowering(
        "rtgen.compiler.lowering.canopen.lower",
        lambda model, _: bool(model.devices or model.buses),
        _idl_of_devices,
    ),
    Lowering(
        "rtgen.compiler.lowering.profiles.lower",
        lambda model, _: bool(model.profiles),
        _idl_of_profiles,
        definitions=True,
    ),
    Lowering(
        "rtgen.compiler.lowering.adapters",
        lambda _, settings: bool(settings.adapters),
        definitions=True,
    ),
    Lowering("rtgen.compiler.lowering.tecs.boards", lambda model, _: bool(model.tecs)),
    Lowering("rtgen.compiler.lowering.numeric", lambda *_: True),
)
"""The lowerings of rtgen, in order; those of plug-ins follow."""

_SHIPPED: Final = frozenset(map(idl_key, IDL_FILES))

LAST: Final = Lowering(
    "rtgen.compiler.lowering.library",
    lambda model, _: any(file.key in _SHIPPED for file in model.files),
)
"""The lowering that runs after all others."""


def lowerings(*, complete: bool) -> tuple[Lowering, ...]:
    """Return the lowerings; unless `complete`, only those whose results are definitions."""
    return tuple(each for each in LOWERINGS if complete or each.definitions)


def needed_idl(model: Model, *, complete: bool) -> list[str]:
    """Return the names of rtgen's IDL files whose types the lowerings use."""
    names = (name for each in lowerings(complete=complete) for name in each.idl(model))
    return list(dict.fromkeys(names))


def lowered(model: Model, settings: Settings, *, complete: bool = True) -> Lowered:
    """Return the model after all lowerings, each applied to the result of the previous one."""
    diagnostics: list[Diagnostic] = []
    steps: list[tuple[str, Lower]] = [
        (lowering.name, lowering) for lowering in lowerings(complete=complete)
    ]
    if complete:
        steps += [*_of_plugins(), (LAST.name, LAST)]
    for name, lower in steps:
        with stages.stage(f"lowering {name}"):
            result = lower(model, settings)
        model = result.model
        diagnostics += result.diagnostics
    return Lowered(model, tuple(diagnostics))


def _of_plugins() -> Iterator[tuple[str, Lower]]:
    for name, lower in plugins.loaded(plugins.Group.LOWERINGS):
        yield name, partial(_by_plugin, name, lower)


def _by_plugin(name: str, lower: Lower, model: Model, settings: Settings) -> Lowered:
    """Return the checked result of a plug-in's lowering. Raises ToolError."""
    with plugins.running(plugins.Group.LOWERINGS, name):
        result = plugins.require(Lowered, lower(model, settings))
        lowered_model = plugins.require(Model, result.model)
        diagnostics = plugins.require_each(Diagnostic, result.diagnostics)
        return Lowered(lowered_model, diagnostics)
