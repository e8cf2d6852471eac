"""Compares systems (RtsProfile): instances, configuration, connections, start order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtgen.compiler.matching import matching
from rtgen.compiler.model import Connection, System, SystemComponent
from rtgen.tools.diff.changes import Change, change
from rtgen.tools.diff.items import (
    Fact,
    Group,
    by_name,
    differing,
    fact_changes,
    item_changes,
    start_of,
)
from rtgen.tools.diff.kinds import systems as kinds
from rtgen.tools.diff.versions import Version

_PROPERTY_KINDS = {
    "dataport.subscription_type": kinds.CONNECTION_SUBSCRIPTION,
    "dataport.interface_type": kinds.CONNECTION_INTERFACE,
    "dataport.data_type": kinds.CONNECTION_DATA_TYPE,
}


_INSTANCES = Group(
    "instance", kinds.INSTANCE_ADDED, kinds.INSTANCE_REMOVED, kinds.INSTANCE_RENAMED
)
_SYSTEMS = Group("system", kinds.SYSTEM_ADDED, kinds.SYSTEM_REMOVED)
_CONNECTIONS = Group("connection", kinds.CONNECTION_ADDED, kinds.CONNECTION_REMOVED)
_FACTS = (
    Fact(kinds.INSTANCE_TYPE, "component", lambda c: c.type),
    Fact(kinds.INSTANCE_RATE, "rate", lambda c: c.rate),
    Fact(kinds.INSTANCE_REQUIRED, "mark required:", lambda c: c.required),
    Fact(kinds.INSTANCE_SET, "active set", lambda c: c.active_set),
    Fact(kinds.INSTANCE_PLACE, "path", lambda c: c.path_uri),
    Fact(kinds.INSTANCE_PLACE, "location", lambda c: c.location),
)


def compare_systems(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of systems, matched by name."""
    found = matching(by_name(old.model.systems), by_name(new.model.systems))
    yield from item_changes(_SYSTEMS, found, lambda s: s.name, place=start_of)
    for one, other in found.pairs:
        yield from _Systems(one, other).compare()


class _Systems:
    def __init__(self, old: System, new: System) -> None:
        self._old, self._new = old, new
        self._spans = (start_of(old), start_of(new))

    def compare(self) -> Iterator[Change]:
        old, new, name = self._old, self._new, self._new.name
        if old.id != new.id:
            text = f"system {name} has the id {new.id}, had {old.id}"
            yield change(kinds.SYSTEM_ID, name, text, *self._spans)
        for key, was, now in sorted(
            differing(dict(old.properties), dict(new.properties))
        ):
            text = f"system {name} has {key} {now}, had {was}"
            spans = (
                old.places.get(key, self._spans[0]),
                new.places.get(key, self._spans[1]),
            )
            yield change(kinds.SYSTEM_PROPERTY, name, text, *spans)
        instances = matching(
            {c.instance: c for c in old.components},
            {c.instance: c for c in new.components},
            lambda c: (c.type, c.configuration, c.rate),
        )
        yield from item_changes(
            _INSTANCES,
            instances,
            self._sub,
            self._spans,
            label=lambda c: c.instance,
        )
        for one, other in instances.pairs:
            yield from self._instance(one, other)
        names = {a.instance: b.instance for a, b in instances.renamed}
        yield from self._connections(names)
        yield from self._activation(names)

    def _instance(self, old: SystemComponent, new: SystemComponent) -> Iterator[Change]:
        name, spans = self._sub(new), (old.span, new.span)
        yield from fact_changes(_FACTS, old, new, name, spans, "instance")
        if old.id != new.id and old.type == new.type:
            text = f"instance {name} has the id {new.id}, had {old.id}"
            yield change(kinds.INSTANCE_ID, name, text, *spans)
        yield from self._configuration(old, new)

    def _configuration(
        self, old: SystemComponent, new: SystemComponent
    ) -> Iterator[Change]:
        before, after = dict(old.parameter_sets), dict(new.parameter_sets)
        name = self._sub(new)
        for key in before:
            if key not in after:
                text = f"configuration set {key} of {name} is removed"
                yield change(kinds.SET_REMOVED, name, text, old.span, new.span)
        for key, pairs in after.items():
            if key not in before:
                text = f"configuration set {key} of {name} is added"
                yield change(kinds.SET_ADDED, name, text, old.span, new.span)
                continue
            was, now = dict(before[key]), dict(pairs)
            for parameter, first, second in differing(was, now):
                item = f"{name}.{parameter}"
                spans = (
                    old.places.get((key, parameter), old.span),
                    new.places.get((key, parameter), new.span),
                )
                if first is None:
                    kind, text = kinds.VALUE_ADDED, f"{item} is {second} in set {key}"
                elif second is None:
                    kind = kinds.VALUE_REMOVED
                    text = f"{item} is no longer {first} in set {key}"
                else:
                    kind = kinds.VALUE_CHANGED
                    text = f"{item} is {second} in set {key}, was {first}"
                yield change(kind, item, text, *spans)

    def _connections(self, names: Mapping[str, str]) -> Iterator[Change]:
        found = matching(
            {_ends(c, names): c for c in self._old.connections},
            {_ends(c, {}): c for c in self._new.connections},
        )
        yield from item_changes(_CONNECTIONS, found, self._connection, self._spans)
        for one, other in found.pairs:
            yield from self._properties(one, other, self._connection(other))

    def _properties(
        self, old: Connection, new: Connection, name: str
    ) -> Iterator[Change]:
        if old.name != new.name:
            text = f"connection {name} is called {new.name}, was {old.name}"
            yield change(kinds.CONNECTION_NAME, name, text, old.span, new.span)
        for key, was, now in sorted(
            differing(dict(old.properties), dict(new.properties))
        ):
            kind = _PROPERTY_KINDS.get(key, kinds.CONNECTION_PROPERTY)
            text = f"connection {name} has {key} {now}, had {was}"
            spans = old.places.get(key, old.span), new.places.get(key, new.span)
            yield change(kind, name, text, *spans)

    def _activation(self, names: Mapping[str, str]) -> Iterator[Change]:
        before = [
            (
                names.get(a.instance, a.instance),
                a.wait_ms,
                tuple(names.get(n, n) for n in a.after),
            )
            for a in self._old.activation
        ]
        after = [(a.instance, a.wait_ms, a.after) for a in self._new.activation]
        common = {a[0] for a in before} & {a[0] for a in after}
        if [a for a in before if a[0] in common] != [
            a for a in after if a[0] in common
        ]:
            text = f"system {self._new.name} starts its components in another order"
            yield change(kinds.ACTIVATION, self._new.name, text, *self._spans)

    def _sub(self, c: SystemComponent) -> str:
        return f"{self._new.name}:{c.instance}"

    def _connection(self, connection: Connection) -> str:
        return f"{self._new.name}:{connection.source}-{connection.target}"


def _ends(connection: Connection, names: Mapping[str, str]) -> tuple[str, ...]:
    ends = (connection.source, connection.target)
    return tuple(f"{names.get(e.instance, e.instance)}.{e.port}" for e in ends)
