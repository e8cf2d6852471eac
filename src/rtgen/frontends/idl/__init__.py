"""Front end for OMG IDL: source, preprocessor, parser, names, constants, checks, lowering."""

from rtgen.frontends.idl.pipeline import load

__all__ = ["load"]
