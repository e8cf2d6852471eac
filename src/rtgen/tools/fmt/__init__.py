"""Formatter of IDL and CDL: changes indentation, spaces and line ends, never tokens or comments."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.tools.fmt.formatting import (
        DEFAULT,
        Edit,
        Language,
        LexicalError,
        Options,
        changed_text,
        edits,
        format_text,
    )

__all__ = [
    "DEFAULT",
    "Edit",
    "Language",
    "LexicalError",
    "Options",
    "changed_text",
    "edits",
    "format_text",
]

# Its rules do not need it.
__getattr__ = deferred("rtgen.tools.fmt.formatting", __all__)
