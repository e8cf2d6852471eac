"""IDL files that are printed when they are included: those of devices and buses, and of wings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Final, Protocol, cast

from msgspec.structs import replace

from rtgen.compiler.backends import stage as backends
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl.rules.lexical import INCLUDE_NOT_FOUND
from rtgen.compiler.frontends.idl.text.source import Interfaces
from rtgen.compiler.frontends.stage import Settings
from rtgen.compiler.model import Model


class IncludedIdl(Protocol):
    """What a wing registers whose definitions can be included as IDL."""

    def texts(self, model: Model) -> dict[str, Callable[[], str]]:
        """Return the texts of its IDL files by name."""

    def interfaces(self, settings: Settings, sources: Sequence[Path]) -> Interfaces:
        """Return the function that reads definitions in place of an included file."""

    def merged(self, of_idl: FrontendResult, others: FrontendResult) -> FrontendResult:
        """Merge all definitions."""


_WING: Final = "rtgen.ros2.included_idl"
"""The module that is one, imported at first use."""


def _wing() -> IncludedIdl:
    return cast(IncludedIdl, import_module(_WING))


def printed_idl(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of IDL files that can be included but are on no disk, by name."""
    return {**_wing().texts(model), **backends.printed_idl(model)}


def interfaces(settings: Settings, sources: Sequence[Path] = ()) -> Interfaces:
    """Return the function for included IDL files that are read from other definitions."""
    return _wing().interfaces(settings, sources)


def merged(of_idl: FrontendResult, others: FrontendResult) -> FrontendResult:
    """Merge all definitions.

    Included files that are missing since other definitions have errors are not reported.
    """
    if has_errors(others.diagnostics):
        diagnostics = tuple(
            d for d in of_idl.diagnostics if d.code != INCLUDE_NOT_FOUND.code
        )
        of_idl = replace(of_idl, diagnostics=diagnostics)
    return _wing().merged(of_idl, others)
