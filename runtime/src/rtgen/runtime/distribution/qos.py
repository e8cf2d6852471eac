"""Quality of service of connections: maps connector properties to `Qos`.

Properties of OpenRTM have a meaning between processes; those of DDS have priority. Buffers and push
policies of a connection are at its receiving end, as within a process.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtgen.facts.connector_properties import (
    DATA_ON_LOSS,
    ON_LOSS,
    Dataflow,
    FullPolicy,
)
from rtgen.runtime.distribution.medium import Qos
from rtgen.runtime.ports.connector_properties import parse

MIN_DEPTH = 64
"""Minimum number of samples stored in transfer, for a burst of writes."""

DEFAULT = Qos(depth=MIN_DEPTH)
"""The QoS of a port without connections."""

WATCHING = Qos(reliable=False, depth=MIN_DEPTH)
"""The QoS of those who only watch: no writer waits for them."""


def qos_of(properties: Mapping[str, str]) -> Qos:
    """Return the QoS of a connection. Raises ConnectorPropertyError.

    `dataport.qos.*` use the words of DDS; defaults: `reliability`: `reliable`; `durability`:
    `transient_local` for `dataport.dataflow_type = pull`, else `volatile`; `history`: `keep_all`
    for `buffer.write.full_policy = block`, else `keep_last`; `depth`: `buffer.length`, but at least
    64; `deadline` and `lease` [s]: none. `patience` is `buffer.write.timeout`.
    """
    settings = parse(properties)
    texts = {key: str(value).strip() for key, value in properties.items()}

    def word(key: str, default: str) -> str:
        return texts.get(f"dataport.qos.{key}", default)

    def seconds(key: str) -> float | None:
        text = word(key, "")
        return float(text) if text else None

    pull = settings.dataflow is Dataflow.PULL
    blocks = settings.inport_buffer.full_policy is FullPolicy.BLOCK
    durability = word("durability", "transient_local" if pull else "volatile")
    history = word("history", "keep_all" if blocks else "keep_last")
    length = max(settings.inport_buffer.length, settings.outport_buffer.length)
    depth = int(word("depth", str(max(length, MIN_DEPTH))))
    return Qos(
        reliable=word("reliability", "reliable") == "reliable",
        depth=None if history == "keep_all" else depth,
        patience=settings.inport_buffer.write_timeout,
        durable=durability == "transient_local",
        deadline=seconds("deadline"),
        lease=seconds("lease"),
    )


def shortest_lease(connections: Iterable[Mapping[str, str]]) -> float | None:
    """Return the shortest lease of connections with these properties [s].

    Raises ConnectorPropertyError.
    """
    leases = [qos_of(properties).lease for properties in connections]
    return min((each for each in leases if each is not None), default=None)


def fails_on_loss(properties: Mapping[str, str]) -> bool:
    """Return whether the loss of the other process puts the component in ERROR.

    By default it continues: `write` returns CONNECTION_LOST, calls raise ObjectNotExist.
    """
    stated = (properties.get(key, "") for key in (DATA_ON_LOSS, ON_LOSS))
    return "error" in [str(text).strip() for text in stated]


def strongest(one: Qos, other: Qos) -> Qos:
    """Return the QoS with which a publisher serves both."""
    return Qos(
        reliable=one.reliable or other.reliable,
        depth=(
            None if None in (one.depth, other.depth) else _most(one.depth, other.depth)
        ),
        patience=max(one.patience, other.patience),
        durable=one.durable or other.durable,
        deadline=_least(one.deadline, other.deadline),
        lease=_least(one.lease, other.lease),
    )


def _most(one: int | None, other: int | None) -> int:
    return max(one or 1, other or 1)


def _least(one: float | None, other: float | None) -> float | None:
    limits = [each for each in (one, other) if each is not None]
    return min(limits, default=None)
