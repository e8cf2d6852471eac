"""Front end for OMG IDL: source, preprocessor, parser, names, constants, checks, lowering."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rtgen.compiler.frontends.idl.pipeline import load

__all__ = ["load"]


def __getattr__(name: str) -> Any:
    """Import the front end when it is first used: its rules do not need it."""
    if name in __all__:
        from rtgen.compiler.frontends.idl import pipeline

        return getattr(pipeline, name)
    raise AttributeError(name)
