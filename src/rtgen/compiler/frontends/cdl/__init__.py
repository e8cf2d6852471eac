"""Front end for CDL, the component description language of TECS."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rtgen.compiler.frontends.cdl.pipeline import load, read_text

__all__ = ["load", "read_text"]


def __getattr__(name: str) -> Any:
    """Import the front end when it is first used: its rules do not need it."""
    if name in __all__:
        from rtgen.compiler.frontends.cdl import pipeline

        return getattr(pipeline, name)
    raise AttributeError(name)
