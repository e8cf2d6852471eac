"""Front end for CDL, the component description language of TECS."""

from rtgen.compiler.frontends.cdl.pipeline import load, read_text

__all__ = ["load", "read_text"]
