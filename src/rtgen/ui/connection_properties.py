"""The properties of connections that pages edit, as RT System Editor has them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.facts.connector_properties import (
    PUSH_RATE,
    Dataflow,
    EmptyPolicy,
    FullPolicy,
    PushPolicy,
    Subscription,
)
from rtgen.facts.topic_properties import TRANSPORTS
from rtgen.ui.protocol import ui


def parameters() -> list[ui.Parameter]:
    """Describe the properties of a connection of data ports that pages edit."""
    return [
        _chosen("dataport.dataflow_type", Dataflow, Dataflow.PUSH),
        _chosen("dataport.subscription_type", Subscription, Subscription.FLUSH),
        _chosen("dataport.publisher.push_policy", PushPolicy, PushPolicy.NEW),
        _number("dataport.publisher.skip_count", "0", "0<=x"),
        _number(PUSH_RATE, "", "0<x", "Hz"),
        _chosen("dataport.interface_type", ("corba_cdr", *TRANSPORTS), "corba_cdr"),
        ui.Parameter(name="dataport.data_type", type="string"),
        *_buffer("outport"),
        *_buffer("inport"),
    ]


def _buffer(end: str) -> Iterator[ui.Parameter]:
    name = f"dataport.{end}.buffer"
    yield _number(f"{name}.length", "8", "1<=x")
    yield _chosen(f"{name}.write.full_policy", FullPolicy, FullPolicy.OVERWRITE)
    yield _number(f"{name}.write.timeout", "1.0", "0<=x", "s")
    yield _chosen(f"{name}.read.empty_policy", EmptyPolicy, EmptyPolicy.READBACK)
    yield _number(f"{name}.read.timeout", "1.0", "0<=x", "s")


def _chosen(name: str, words: Iterable[str], default: str) -> ui.Parameter:
    options = ",".join(words)
    return ui.Parameter(
        name=name, type="string", default_value=str(default), constraint=f"({options})"
    )


def _number(name: str, default: str, constraint: str, unit: str = "") -> ui.Parameter:
    return ui.Parameter(
        name=name,
        type="double",
        default_value=default,
        constraint=constraint,
        unit=unit,
    )
