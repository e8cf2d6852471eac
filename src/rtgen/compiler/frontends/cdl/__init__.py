"""Front end for CDL, the component description language of TECS."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.frontends.cdl.pipeline import load, read_text

__all__ = ["load", "read_text"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.compiler.frontends.cdl.pipeline", __all__)
