"""Components of a system that rtgen does not run (`--foreign`, property `rtgen.foreign`)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.model import System
from rtgen.compiler.systems import conditions
from rtgen.compiler.systems.rules import FOREIGN
from rtgen.facts.openrtm_ports import FOREIGN as PROPERTY
from rtgen.facts.openrtm_ports import foreign_instances
from rtgen.runtime.errors import TransportError
from rtgen.runtime.services.transports import (
    ForeignComponent,
    ForeignTransport,
    ProcessTransport,
)
from rtgen.tools.running.transports import TransportOptions


def named(
    profile: System, listed: str | None, languages: Mapping[str, str]
) -> frozenset[str]:
    """Return the foreign instances: of the property, the option, and types in other languages."""
    place = profile.places.get(PROPERTY)
    texts = [(name, place) for name in foreign_instances(profile.properties)]
    texts += [(name.strip(), None) for name in (listed or "").split(",") if listed]
    texts += [(c.instance, c.span) for c in profile.components if c.type in languages]
    return frozenset(conditions.require_instance(n, profile, span) for n, span in texts)


def require_reachable(
    profile: System,
    outside: Collection[str],
    carrying: TransportOptions,
    languages: Mapping[str, str],
    *,
    simulated: bool,
) -> None:
    """Raise InputError unless the transport is CORBA in real time."""
    if carrying.transport == "corba" and not simulated:
        return
    names = ", ".join(sorted(outside))
    hint = "--clock real --transport corba"
    types = {c.type for c in profile.components if c.instance in outside}
    for name in sorted(types & languages.keys()):
        hint += (
            f"; the profile of {name} says {languages[name]}: if it is implemented here, "
            "name its factory in [components] of rtgen.toml"
        )
    raise InputError(
        [
            FOREIGN.at(
                profile.places.get(PROPERTY),
                f"{names}: a foreign component is reached by CORBA and in real time alone",
                hint=hint,
            )
        ]
    )


def awaited(
    profile: System, outside: Collection[str], here: Collection[str]
) -> Sequence[ForeignComponent]:
    """Return the foreign components that concern this process.

    They are those connected with its own components; a process that runs all others takes all.
    """
    joined = {
        end.instance
        for c in profile.connections
        for end in (c.source, c.target)
        if {c.source.instance, c.target.instance} & {*here}
    }
    others = {c.instance for c in profile.components} - {*outside}
    concerned = {*outside} if others == {*here} else joined & {*outside}
    return [
        ForeignComponent(
            c.instance,
            c.path_uri,
            {set_id: dict(values) for set_id, values in c.parameter_sets},
            c.active_set,
        )
        for c in profile.components
        if c.instance in concerned
    ]


@contextmanager
def expected(
    transport: ProcessTransport | None, components: Sequence[ForeignComponent]
) -> Iterator[None]:
    """Let the transport look for foreign components within the block. Raises ToolError."""
    if isinstance(transport, ForeignTransport):
        try:
            for component in components:
                transport.add_foreign(component)
        except TransportError as error:
            raise ToolError(str(error)) from error
    yield
