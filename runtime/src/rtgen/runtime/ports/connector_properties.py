"""Connector properties by OpenRTM's names, parsed when the connection is established."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rtgen.facts.connector_properties import (
    IGNORED,
    MARSHALING,
    PLAIN_DATA,
    PUSH_RATE,
    Dataflow,
    EmptyPolicy,
    FullPolicy,
    PushPolicy,
    Subscription,
    embedded_data,
    is_contradictory,
    lacks_push_rate,
    subscriptions,
    violation,
)
from rtgen.facts.topic_properties import Check
from rtgen.runtime.errors import ConnectorPropertyError
from rtgen.runtime.ports.buffers import BufferSettings


class ConnectorSettings(msgspec.Struct, frozen=True, gc=False):
    """Settings of a data connection; `push_rate` in Hz, 0.0 if not periodic."""

    inport_buffer: BufferSettings
    outport_buffer: BufferSettings
    dataflow: Dataflow
    subscription: Subscription
    push_policy: PushPolicy
    skip_count: int
    push_rate: float
    fan_in: int | None
    fan_out: int | None
    allow_duplicate: bool


def parse(properties: Mapping[str, str]) -> ConnectorSettings:
    """Parse the properties of a data connection.

    Interface, byte order and marshalling are validated without effect, since both ends are in one
    process; `dataport.data_type` is informative; addresses (`dataport.corba_cdr.*`), which system
    editors save, and properties of other targets (`rtgen.*`) are ignored. Raises
    ConnectorPropertyError.
    """
    texts = {key: str(value).strip() for key, value in properties.items()}
    is_plain = MARSHALING not in texts and texts.keys() <= PLAIN_DATA.keys()
    check(texts, PLAIN_DATA if is_plain else embedded_data())
    meant = subscriptions(texts)
    if is_contradictory(texts):
        stated = " and ".join(f"{key} = {texts[key]}" for key in meant)
        raise ConnectorPropertyError(
            f"connector properties contradict each other: {stated}"
        )
    if lacks_push_rate(texts):
        raise ConnectorPropertyError(
            f"subscription 'periodic' needs the property {PUSH_RATE!r}"
        )
    if not is_plain:
        from rtgen.facts.ros_qos_words import problems

        for _, problem, hint in problems(texts):
            raise ConnectorPropertyError(f"connector properties: {problem}; {hint}")
    subscription = next(iter(meant.values()), Subscription.FLUSH)
    periodic = subscription is Subscription.PERIODIC
    push_policy = texts.get("dataport.publisher.push_policy", PushPolicy.NEW)
    return ConnectorSettings(
        dataflow=Dataflow(texts.get("dataport.dataflow_type", Dataflow.PUSH)),
        subscription=subscription,
        push_policy=PushPolicy(push_policy),
        skip_count=int(texts.get("dataport.publisher.skip_count", 0)),
        push_rate=float(texts[PUSH_RATE]) if periodic else 0.0,
        inport_buffer=_buffer(texts, "inport"),
        outport_buffer=_buffer(texts, "outport"),
        fan_in=_limit(texts, "dataport.fan_in"),
        fan_out=_limit(texts, "dataport.fan_out"),
        allow_duplicate=texts.get("dataport.allow_dup_connection", "NO").upper()
        == "YES",
    )


def check(properties: Mapping[str, str], table: Mapping[str, Check]) -> None:
    """Check properties against a table; those of other readers (`IGNORED`) are skipped."""
    for key, text in properties.items():
        if key.startswith(IGNORED):
            continue
        if key not in table:
            from difflib import get_close_matches

            near = get_close_matches(key, table, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ConnectorPropertyError(f"unknown connector property {key!r}{hint}")
        why = violation(table, key, text)
        if why is not None:
            raise ConnectorPropertyError(
                f"connector property {key!r} is {text!r}; it must be {why}"
            )


def _buffer(texts: Mapping[str, str], end: str) -> BufferSettings:
    def text(key: str, default: str) -> str:
        own = texts.get(f"dataport.{end}.buffer.{key}")
        return texts.get(f"dataport.buffer.{key}", default) if own is None else own

    return BufferSettings(
        length=int(text("length", "8")),
        full_policy=FullPolicy(text("write.full_policy", FullPolicy.OVERWRITE)),
        write_timeout=float(text("write.timeout", "1.0")),
        empty_policy=EmptyPolicy(text("read.empty_policy", EmptyPolicy.READBACK)),
        read_timeout=float(text("read.timeout", "1.0")),
    )


def _limit(texts: Mapping[str, str], key: str) -> int | None:
    return int(texts[key]) if key in texts else None
