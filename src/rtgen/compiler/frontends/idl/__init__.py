"""Front end for OMG IDL: source, preprocessor, parser, names, constants, checks, lowering."""

from rtgen.compiler.frontends.idl.pipeline import load

__all__ = ["load"]
