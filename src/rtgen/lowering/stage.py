"""The lowering stage: the signature of a lowering, and the list of all lowerings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Final, TypeAlias

from rtgen.diagnostics import Diagnostic
from rtgen.lowering.settings import Settings
from rtgen.model import Model


@dataclass(frozen=True, slots=True)
class Lowered:
    """The lowered model and the diagnostics."""

    model: Model
    diagnostics: tuple[Diagnostic, ...] = ()


Lower: TypeAlias = Callable[[Model, Settings], Lowered]
"""The signature of a lowering, a pure function."""


@dataclass(frozen=True, slots=True)
class Lowering:
    """A lowering: its module has `lower`, and is imported only if the model needs it."""

    module: str
    needed: Callable[[Model, Settings], bool]

    def __call__(self, model: Model, settings: Settings) -> Lowered:
        """The lowered model; the model itself if it has nothing to lower."""
        if not self.needed(model, settings):
            return Lowered(model)
        lower: Lower = import_module(self.module).lower
        return lower(model, settings)


DEFINITIONS: Final = (
    Lowering("rtgen.lowering.adapters", lambda _, settings: bool(settings.adapters)),
)
"""The lowerings whose results count as definitions of the project: `inspect` shows them."""

LOWERINGS: Final = (
    *DEFINITIONS,
    Lowering("rtgen.lowering.tecs.boards", lambda model, _: bool(model.tecs)),
)
"""All lowerings, in order."""


def lowered(
    model: Model, settings: Settings, lowerings: Sequence[Lowering] = LOWERINGS
) -> Lowered:
    """The model after these lowerings, each applied to the result of the previous one."""
    found: list[Diagnostic] = []
    for lower in lowerings:
        made = lower(model, settings)
        model = made.model
        found += made.diagnostics
    return Lowered(model, tuple(found))
