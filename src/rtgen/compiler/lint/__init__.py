"""The linter: rules about valid definitions that could be improved."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.lint.linter import OF_UNITS, ON_DEMAND, lint

__all__ = ["OF_UNITS", "ON_DEMAND", "lint"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.compiler.lint.linter", __all__)
