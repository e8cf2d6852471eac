"""OMG IDL to the model: source, preprocessor, parser, names, constants, checks, lowering."""

from rtgen.frontends.idl.pipeline import load

__all__ = ["load"]
