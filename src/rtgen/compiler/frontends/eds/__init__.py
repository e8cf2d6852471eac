"""Front end for EDS and DCF files (CiA 306): lines, sections, objects, PDOs."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.frontends.eds.pipeline import load

__all__ = ["load"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.compiler.frontends.eds.pipeline", __all__)
