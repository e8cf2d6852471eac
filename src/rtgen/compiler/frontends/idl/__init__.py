"""Front end for OMG IDL: source, preprocessor, parser, names, constants, checks, lowering."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.frontends.idl.pipeline import load

__all__ = ["load"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.compiler.frontends.idl.pipeline", __all__)
