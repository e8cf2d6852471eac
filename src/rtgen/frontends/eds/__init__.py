"""EDS and DCF files (CiA 306) to the model: lines, sections, objects, PDOs."""

from rtgen.frontends.eds.pipeline import load

__all__ = ["load"]
