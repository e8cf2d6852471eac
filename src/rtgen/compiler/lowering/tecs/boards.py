"""Lowers CDL files with joins through `RTCPlugin` to packages of interfaces and components.

RTM-TECS, 5.1 and Table 1: a marshaller RTC and a client RTC for each signature that is joined.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.layouts.tdr import SignatureLayout, TransferError
from rtgen.compiler.layouts.tdr_messages import layout_of, problems, read_too_early
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.lowering.tecs.communication import communication_model
from rtgen.compiler.lowering.tecs.idl_model import IdlSide, idl_side
from rtgen.compiler.lowering.tecs.plan import FOLDER, TecsPackage, packages
from rtgen.compiler.lowering.tecs.rtc_components import CLIENT, MARSHALLER
from rtgen.compiler.lowering.tecs.rules import (
    NOT_TRANSFERRED,
    SAME_COMPONENT,
    SIZE_TOO_EARLY,
)
from rtgen.compiler.model import Component, Model, Package


class BoardPackage(Package, frozen=True, kw_only=True):
    """The package of a CDL file: its plan, and its signatures in IDL and on the wire."""

    plan: TecsPackage
    side: IdlSide
    layouts: tuple[SignatureLayout, ...]


def lower(model: Model, settings: Settings) -> Lowered:
    """The model with a package shared by all boards, and one for each CDL file with a join."""
    planned, findings = packages(model)
    if not planned:
        return Lowered(model, tuple(findings))
    sources = tuple(dict.fromkeys(s for p in planned for s in p.sources))
    communication = communication_model(sources)
    result = [Package(name=FOLDER, model=communication, sources=sources)]
    for plan in planned:
        side, diagnostics = idl_side(plan, communication)
        layouts, untransferable = _layouts(plan, side)
        findings += [*diagnostics, *untransferable]
        result.append(
            BoardPackage(
                name=plan.name,
                model=side.model,
                sources=plan.sources,
                any_values=any(s.options.array == "any" for s in plan.services),
                profiles=_profiles(plan),
                plan=plan,
                side=side,
                layouts=tuple(layouts),
            )
        )
    findings += _declared_elsewhere(model, result)
    return Lowered(replace(model, packages=tuple(result)), tuple(findings))


def boards(model: Model) -> Iterator[BoardPackage]:
    """The packages of CDL files."""
    for package in model.packages:
        if isinstance(package, BoardPackage):
            yield package


def _declared_elsewhere(
    model: Model, packages: Iterable[Package]
) -> Iterator[Diagnostic]:
    """Report components of definitions with the name of one that is made for a board."""
    others = {d.name: d for d in model.declarations if isinstance(d, Component)}
    for package in packages:
        for component in package.model.declarations:
            other = others.get(component.name)
            if other is not None and isinstance(component, Component):
                yield SAME_COMPONENT.at(
                    other.span,
                    f"{other.scoped} is a component type of {package.sources[0].name}, too",
                    hint="rename it, or name the one that is meant in [components] of rtgen.toml",
                )


def _profiles(plan: TecsPackage) -> dict[str, str]:
    """The first client's profile is the package's `RTC.xml`."""
    first, *others = (service.name for service in plan.services)
    return {
        f"{first}{CLIENT}": "RTC.xml",
        **{f"{name}{CLIENT}": f"{name}.RTC.xml" for name in others},
        **{
            f"{service.name}{MARSHALLER}": f"{service.name}{MARSHALLER}.RTC.xml"
            for service in plan.services
        },
    }


def _layouts(
    package: TecsPackage, side: IdlSide
) -> tuple[list[SignatureLayout], list[Diagnostic]]:
    """The layouts of all signatures, and diagnostics for what OpaqueRPC cannot carry."""
    layouts = []
    diagnostics = []
    for service in package.services:
        signature = service.signature
        try:
            layout = layout_of(package.unit, signature)
        except TransferError:
            functions = [f for f in signature.functions if f.span not in side.refused]
            sound = replace(signature, functions=tuple(functions))
            for p in problems(package.unit, sound):
                diagnostics.append(NOT_TRANSFERRED.at(p.span, p.reason, hint=p.hint))
            continue
        layouts.append(layout)
        for item, size in read_too_early(layout):
            message = f"boards of tecsgen read {size!r} before the call, to allocate {item.name!r}"
            hint = f"make {size!r} inout; callers give the size of their buffer"
            diagnostics.append(SIZE_TOO_EARLY.at(item.span, message, hint=hint))
    return layouts, diagnostics
