"""Settings of lowerings in rtgen.toml."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.diagnostics import Span


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterEntry:
    """`[adapter.NAME]`: scoped names of structs, and which member of `source` fills which."""

    name: str
    source: str
    target: str
    mapping: tuple[tuple[str, str], ...]
    span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """The settings of all lowerings."""

    adapters: tuple[AdapterEntry, ...] = ()
