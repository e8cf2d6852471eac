"""One of the two compared versions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.layouts.cdr_types import CdrTypes
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    Declaration,
    Model,
    NamedType,
    ScopedName,
    Struct,
    Union,
)
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import DEVICE_SUFFIXES

_SHIPPED = ("Canopen.idl", "CanopenManager.idl")
_DERIVED = (*DEVICE_SUFFIXES, *CDL_SUFFIXES, ".toml")


def _unchanged(span: Span) -> Span:
    return span


@dataclass(frozen=True)
class Version:
    """A version of definitions: the lowered model with its systems, texts and settings.

    `settings` is the content of rtgen.toml (empty without one), `places` the spans of its keys by
    (section, key). `sources` maps displayed paths to texts; `relabel` converts a place of the model
    to the displayed one, with the revision.
    """

    model: Model
    sources: Mapping[str, str] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    xcdr2: bool = False
    extensibility: str = "final"
    settings: Mapping[str, Any] = field(default_factory=dict)
    places: Mapping[tuple[str, str], Span] = field(default_factory=dict)
    relabel: Callable[[Span], Span] = _unchanged

    @cached_property
    def representations(self) -> Representations:
        """The extensibility and representation of types."""
        return Representations(self.model, self.xcdr2, self.extensibility)

    @cached_property
    def cdr(self) -> CdrTypes:
        """The types' properties in the encodings."""
        return CdrTypes(self.model, self.representations)

    @cached_property
    def written(self) -> dict[ScopedName, Declaration]:
        """The declarations of definition files, without rtgen's own and those made by lowerings."""
        return {
            d.name: d
            for d in self.model.declarations
            if not d.span.file.lower().endswith(_DERIVED)
            and d.span.file not in _SHIPPED
        }

    def has_headers(self, name: ScopedName) -> bool:
        """Return whether classic CDR cannot represent the type, so that `to_cdr` writes XCDR1."""
        return self.cdr.has_headers(NamedType(name))

    def has_xcdr(self, name: ScopedName) -> bool:
        """Return whether XCDR can represent the type."""
        return self.representations.missing(NamedType(name)) is None

    def is_xcdr2(self, declaration: Struct | Union) -> bool:
        """Return whether `to_cdr` writes XCDR2."""
        return self.representations.is_xcdr2(declaration)
