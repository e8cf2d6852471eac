"""Settings of lowerings in rtgen.toml."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.facts.adapter_constants import AdapterConstant
from rtgen.facts.numeric import Numeric


class AdapterEntry(msgspec.Struct, frozen=True, kw_only=True):
    """`[adapter.NAME]`: scoped names of structs, and the member of `source` for each of the target.

    `constants` are target members with values, `units` converted ones, with the units of source and
    target.
    """

    name: str
    source: str
    target: str
    mapping: tuple[tuple[str, str], ...]
    span: Span
    constants: tuple[tuple[str, AdapterConstant], ...] = ()
    units: Mapping[str, tuple[str, str]] = msgspec.field(default_factory=dict)


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """The settings of all lowerings.

    `definitions` are the displayed paths of the IDL files that the user named. `numeric` is the
    form of numeric sequences and arrays in Python, `extensibility` that of structs without an
    annotation, `representation` the format of `to_cdr`. `plugins` has the table `[plugin.NAME]` of
    rtgen.toml for each name.
    """

    adapters: tuple[AdapterEntry, ...] = ()
    definitions: frozenset[str] = frozenset()
    numeric: Numeric = "list"
    extensibility: str = "final"
    representation: str = "cdr"
    plugins: Mapping[str, Mapping[str, Any]] = msgspec.field(default_factory=dict)
