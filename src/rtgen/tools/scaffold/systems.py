"""Makes a system of components whose ports are connected by their types."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches

from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity, Span
from rtgen.compiler.model import (
    Activation,
    Component,
    Connection,
    Model,
    NamedType,
    Port,
    PortKind,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.system_links import Known, known_components
from rtgen.compiler.systems import connections
from rtgen.tools.scaffold.rules import NO_COMPONENT

_ASCENDING = (Severity.NOTE, Severity.WARNING, Severity.ERROR)
_NO_SPAN = Span("", 1, 1, 1, 1)
_Placed = tuple[str, Known]


def system_of(
    name: str, model: Model, names: Sequence[str]
) -> tuple[System, list[str]]:
    """Return a system with an instance of each component in `names`, and what is ambiguous in it.

    If `names` is empty: of each component whose behaviour requires neither bus nor board.

    Data flows in this order: an InPort is connected to the nearest preceding OutPort of its type, a
    consumer to the nearest provider of its interface. Ports that the judge of connections refuses
    stay apart; those of other scales are joined if nothing else fits. Components that play devices
    are connected by their buses alone. Raises InputError for a name that is not a component of the
    lowered model, or of its boards.
    """
    models = [model, *(package.model for package in model.packages)]
    components = known_components(models)
    if not names:
        names = [
            n
            for n, known in components.items()
            if known.model is model and not _needs_more(known.component)
        ]
    if not names:
        hint = "rtgen new component NAME makes one"
        raise InputError([NO_COMPONENT.at(None, "there are no components", hint=hint)])
    for each in names:
        if each not in components:
            close = get_close_matches(each, components, n=1)
            hint = (
                f"did you mean {close[0]}?"
                if close
                else f"there are: {', '.join(components)}"
            )
            message = f"no definition has a component {each}"
            raise InputError([NO_COMPONENT.at(None, message, hint=hint)])
    numbers: Counter[str] = Counter()
    placed: list[_Placed] = []
    for each in names:
        placed.append((f"{each}{numbers[each]}", components[each]))
        numbers[each] += 1
    ambiguous: list[str] = []
    system = System(
        name=name,
        id=f"RTSystem:rtgen:{name}:1.0.0",
        file="",
        abstract=f"The system {name}",
        components=tuple(
            SystemComponent(
                instance=instance,
                type=known.component.name[-1],
                id=known.component.profile_id,
                path_uri=f"localhost/{instance}.rtc",
                span=_NO_SPAN,
                rate=known.component.rate,
                kind=known.component.context_kind,
            )
            for instance, known in placed
        ),
        connections=tuple(_connections(placed, ambiguous)),
        activation=tuple(
            Activation(instance=instance, sequence=number)
            for number, (instance, _) in enumerate(placed, 1)
        ),
    )
    return system, ambiguous


def _needs_more(component: Component) -> bool:
    """Return whether the behaviour of a component needs a bus, or a channel to a board."""
    return bool(component.runtime_base or component.factory)


def _connections(
    placed: Sequence[_Placed], ambiguous: list[str]
) -> Iterator[Connection]:
    placed = [one for one in placed if not one[1].component.is_device]
    definitions = dict(placed)
    for number, (instance, known) in enumerate(placed):
        before, after = placed[:number][::-1], placed[number + 1 :]
        for port in known.component.ports:
            if port.kind is PortKind.INPORT:
                links = [
                    _connection(
                        end, (instance, port), _repository_id(known.model, port)
                    )
                    for end in _fitting(known.model, before, PortKind.OUTPORT, port)
                ]
            elif port.kind is PortKind.CONSUMER:
                links = [
                    _connection((instance, port), end)
                    for end in _fitting(
                        known.model, [*before, *after], PortKind.PROVIDER, port
                    )
                ]
            else:
                continue
            fitting, doubt = _judged(links, definitions)
            yield from fitting[:1]
            if doubt:
                ambiguous.append(f"{instance}.{port.name}: {doubt}")
            elif len(fitting) > 1:
                first, *others = (_other_end(link, instance) for link in fitting)
                ambiguous.append(
                    f"{instance}.{port.name} is connected to {first}, the nearest; "
                    f"{', '.join(others)} would fit, too"
                )


def _judged(
    links: Sequence[Connection], known: Mapping[str, Known]
) -> tuple[list[Connection], str]:
    """Return the connections without an error, those without a warning first.

    The text is the verdict on the best one, unless the judge has nothing against it.
    """
    judged = []
    for link in links:
        findings = sorted(connections.compared(link, known), key=_weight)
        weight = _weight(findings[-1]) if findings else 0
        verdict = f"{findings[-1].message} ({findings[-1].code})" if weight else ""
        judged.append((weight, link, verdict))
    judged.sort(key=lambda each: each[0])
    fitting = [
        link for weight, link, _ in judged if weight < _ASCENDING.index(Severity.ERROR)
    ]
    return fitting, judged[0][2] if judged else ""


def _weight(finding: Diagnostic) -> int:
    return _ASCENDING.index(finding.severity)


def _other_end(link: Connection, instance: str) -> str:
    return str(link.source if link.target.instance == instance else link.target)


def _fitting(
    model: Model, others: Sequence[_Placed], kind: PortKind, port: Port
) -> list[tuple[str, Port]]:
    """Return the ports of a kind and of the type of `port`, with their instances."""
    type_ = model.unalias(port.type)
    return [
        (instance, other)
        for instance, known in others
        for other in known.component.ports
        if other.kind is kind and known.model.unalias(other.type) == type_
    ]


def _repository_id(model: Model, port: Port) -> str:
    type_ = model.unalias(port.type)
    assert isinstance(type_, NamedType), "checked when the definition was read"
    return model.find(type_.name).repository_id


def _connection(
    source: tuple[str, Port], target: tuple[str, Port], data_type: str = ""
) -> Connection:
    """Return a connection of data ports, or of service ports if there is no data type."""
    ends = [
        PortReference(instance=instance, port=port.name if data_type else port.port)
        for instance, port in (source, target)
    ]
    return Connection(
        name="_".join(map(str, ends)),
        source=ends[0],
        target=ends[1],
        service=not data_type,
        span=_NO_SPAN,
        properties=(("dataport.data_type", data_type),) if data_type else (),
    )
