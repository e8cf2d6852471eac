"""Interface of front ends, which read definitions into a model: one package per input language."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.frontends.interface import (
        Dependency,
        Frontend,
        FrontendResult,
        key_of,
        together,
    )

__all__ = [
    "Dependency",
    "Frontend",
    "FrontendResult",
    "key_of",
    "together",
]

# The rules of front ends are read without it.
__getattr__ = deferred("rtgen.compiler.frontends.interface", __all__)
