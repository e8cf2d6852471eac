"""The linter: rules about valid definitions that could be improved."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from typing import Any, TypeAlias

from rtgen.compiler.diagnostics import Diagnostic, in_order
from rtgen.compiler.kit import plugins
from rtgen.compiler.lint import (
    data,
    devices,
    portability,
    python,
    style,
    tecs,
    units,
    usage,
)
from rtgen.compiler.lint.context import Context
from rtgen.compiler.lint.rules import ON_DEMAND
from rtgen.compiler.model import Model

__all__ = ["OF_UNITS", "ON_DEMAND", "lint"]

_Check: TypeAlias = Callable[[Context], Iterable[Diagnostic]]

OF_UNITS: tuple[_Check, ...] = (units.texts, units.factors)
_CHECKS: tuple[_Check, ...] = (
    usage.includes,
    usage.typedefs,
    usage.types,
    portability.constructs,
    style.anonymous_types,
    style.naming,
    style.documentation,
    style.prefixes,
    data.any_in_ports,
    data.times_of_ports,
    data.unbounded,
    data.unbounded_on_boards,
    data.missing_enumerators,
    python.names,
    python.files,
    devices.heartbeats,
    devices.identities,
    devices.names,
    devices.unreachable,
    tecs.signatures,
    *OF_UNITS,
)


def _by_plugin(name: str, check: _Check, context: Context) -> tuple[Diagnostic, ...]:
    """Return the findings of a plug-in's check. Raises ToolError."""
    with plugins.running(plugins.Group.LINT, name):
        return plugins.require_each(Diagnostic, check(context))


def lint(
    model: Model,
    sources: Mapping[str, str],
    *,
    select: Collection[str] = (),
    options: Mapping[str, Mapping[str, Any]] | None = None,
    target: str = "",
    checks: Iterable[_Check] = _CHECKS,
) -> list[Diagnostic]:
    """Return the diagnostics of `checks` and of plug-ins' checks for the given files, in order.

    `sources` maps displayed paths to texts; `options` has the table `[plugin.NAME]` of rtgen.toml
    for each name, `target` is the platform of components. Rules of ON_DEMAND only run if `select`
    has their codes.
    """
    context = Context(model, sources, options or {}, target)
    own: Iterable[_Check] = (
        partial(_by_plugin, name, check)
        for name, check in plugins.loaded(plugins.Group.LINT)
    )
    left_out = {rule.code for rule in ON_DEMAND} - set(select)
    return in_order(
        finding
        for check in (*checks, *own)
        for finding in check(context)
        if finding.code not in left_out
    )
