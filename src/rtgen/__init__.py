"""rtgen: an interface compiler for robot software (IDL, CDL, EDS to Python).

`compile`, `read` and `emit` are the compiler for scripts and tests (docs/api.md). They are imported
lazily, since generated code imports this package for its runtime.
"""

from rtgen.facts.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rtgen.api import compile, emit, read  # noqa: A004

__all__ = ["__version__", "compile", "emit", "read"]


def __getattr__(name: str) -> object:
    if name in ("compile", "emit", "read"):
        from importlib import import_module

        return getattr(import_module("rtgen.api"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
