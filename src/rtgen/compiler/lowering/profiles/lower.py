"""Lowers the RtcProfiles of a model to components."""

from __future__ import annotations

from msgspec.structs import replace

from rtgen.compiler.lowering.profiles.components import components
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import Model


def lower(model: Model, settings: Settings) -> Lowered:
    """Return the model with a component for each profile, and placeholders for unknown types.

    The component of a profile replaces the one of its name in an IDL file.
    """
    declarations, diagnostics = components(model.profiles, model, settings.definitions)
    names = {declaration.name for declaration in declarations}
    rest = (each for each in model.declarations if each.name not in names)
    return Lowered(replace(model, declarations=(*rest, *declarations)), diagnostics)
