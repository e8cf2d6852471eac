"""Interface of back ends: pure functions from a model to artifacts, built in or plug-ins."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.backends.interface import (
        Artifact,
        Backend,
        ComponentTypes,
        DeferredBackend,
        Emission,
        Options,
        Owner,
        Part,
        parts,
    )

__all__ = [
    "Artifact",
    "Backend",
    "ComponentTypes",
    "DeferredBackend",
    "Emission",
    "Options",
    "Owner",
    "Part",
    "parts",
]

# The rules of back ends are read without it.
__getattr__ = deferred("rtgen.compiler.backends.interface", __all__)
