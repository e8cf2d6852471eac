"""Front end for EDS and DCF files (CiA 306): lines, sections, objects, PDOs."""

from rtgen.compiler.frontends.eds.pipeline import load

__all__ = ["load"]
