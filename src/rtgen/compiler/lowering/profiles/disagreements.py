"""Compares the component of an RtcProfile with the IDL component of the same name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.model import Component
from rtgen.compiler.typemap.profiles import rules

_Entries = Mapping[str, tuple[str, Span]]


def disagreements(profile: Component, definition: Component) -> Iterator[Diagnostic]:
    """Yield differences between profile and definition: ports, parameters, their types."""
    for what, ours, theirs in (
        ("port", _ports(profile), _ports(definition)),
        ("parameter", _parameters(profile), _parameters(definition)),
    ):
        yield from _differences(what, profile, definition, ours, theirs)


def _ports(component: Component) -> _Entries:
    return {p.name: (f"{p.kind.value} {p.type}", p.span) for p in component.ports}


def _parameters(component: Component) -> _Entries:
    return {p.name: (str(p.type), p.span) for p in component.configuration}


def _differences(
    what: str,
    profile: Component,
    definition: Component,
    ours: _Entries,
    theirs: _Entries,
) -> Iterator[Diagnostic]:
    for name, (text, span) in ours.items():
        other = theirs.get(name)
        if other is None:
            message = f"the {what} {name} is not in the IDL of {definition.scoped}"
            related = [Related(definition.span, "the definition")]
            yield rules.DISAGREES.at(span, message, related=related)
        elif other[0] != text:
            message = f"the {what} {name} is {text} here, {other[0]} in the IDL"
            related = [Related(other[1], "the definition")]
            yield rules.DISAGREES.at(span, message, related=related)
    for name, (_, span) in theirs.items():
        if name not in ours:
            message = f"the {what} {name} of the IDL is missing in the profile"
            related = [Related(span, "the definition")]
            yield rules.DISAGREES.at(profile.span, message, related=related)
