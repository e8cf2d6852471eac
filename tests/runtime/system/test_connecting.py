"""Possible and impossible connections, and the messages of refusals."""

from __future__ import annotations

import pytest
from runtime_samples import (
    Actor,
    OtherTimedLong,
    TimedList,
    activated,
    drained,
    joined,
    long,
)

from rtgen.runtime import (
    ConnectError,
    ConnectionLimitError,
    ConnectorPropertyError,
    DataConnector,
    DuplicateConnectionError,
    PolarityError,
    PortTypeError,
    System,
    UnknownComponentError,
    UnknownConnectionError,
    UnknownPortError,
)


@pytest.fixture
def system() -> System:
    both = Actor("both", inputs=("status",), outputs=("status",))
    writer, reader = Actor("writer", outputs=("out",)), Actor("reader", inputs=("in",))
    return activated(System(), both, writer, reader)


def test_ports_of_one_name_are_distinguished_by_direction(system: System) -> None:
    system.connect(("writer", "out"), ("both", "status"), name="to")
    system.connect(("both", "status"), ("reader", "in"), name="from")
    system.component("writer").out_ports["out"].write(long(1))
    system.component("both").out_ports["status"].write(long(2))
    assert drained(system.component("both").in_ports["status"]) == [1]
    assert drained(system.component("reader").in_ports["in"]) == [2]


def test_either_order_and_the_name(system: System) -> None:
    connector = system.connect(("reader", "in"), ("writer", "out"))
    assert isinstance(connector, DataConnector)
    assert connector.name == "reader.in_writer.out"
    assert str(connector.source) == "writer.out"
    assert str(connector.target) == "reader.in"
    assert system.connectors == (connector,)
    assert system.connector(connector.name) is connector


def test_unknown_ends(system: System) -> None:
    with pytest.raises(
        UnknownComponentError, match="no component 'ghost'; known: both, writer"
    ):
        system.connect(("ghost", "out"), ("reader", "in"))
    with pytest.raises(UnknownPortError, match="writer has no port 'oot'; known: out"):
        system.connect(("writer", "oot"), ("reader", "in"))
    with pytest.raises(UnknownPortError, match="reader has no port 'im'; known: in"):
        system.connect(("writer", "out"), ("reader", "im"))


def test_polarity(system: System) -> None:
    activated(system, Actor("another", outputs=("out",)))
    with pytest.raises(PolarityError, match="they are OutPort and OutPort"):
        system.connect(("writer", "out"), ("another", "out"))


@pytest.mark.parametrize("type_", [TimedList, OtherTimedLong])
def test_types_are_compared_by_id_and_structure(system: System, type_: type) -> None:
    activated(system, Actor("other", inputs=("in",), type_=type_))
    with pytest.raises(PortTypeError) as caught:
        system.connect(("writer", "out"), ("other", "in"))
    message = str(caught.value)
    assert "writer.out and other.in have different types" in message
    assert "IDL:RTC/TimedLong:1.0" in message
    assert type_._descriptor_.repository_id in message
    assert isinstance(caught.value, ConnectError)
    assert system.connectors == ()


def test_a_connection_cannot_be_made_twice(system: System) -> None:
    system.connect(("writer", "out"), ("reader", "in"), name="c")
    with pytest.raises(DuplicateConnectionError, match="connected already, by 'c'"):
        system.connect(("writer", "out"), ("reader", "in"), name="d")
    with pytest.raises(DuplicateConnectionError, match="a connection 'c' already"):
        system.connect(("writer", "out"), ("both", "status"), name="c")
    twice = {"dataport.allow_dup_connection": "YES"}
    system.connect(("writer", "out"), ("reader", "in"), twice, "d")
    system.component("writer").out_ports["out"].write(long(1))
    assert drained(system.component("reader").in_ports["in"]) == [1, 1]


def test_limits(system: System) -> None:
    system.connect(("writer", "out"), ("reader", "in"))
    with pytest.raises(
        ConnectionLimitError, match=r"writer.out has 1 .* dataport.fan_out allows 1"
    ):
        system.connect(("writer", "out"), ("both", "status"), {"dataport.fan_out": "1"})
    with pytest.raises(
        ConnectionLimitError, match=r"reader.in has 1 .* dataport.fan_in allows 1"
    ):
        system.connect(("both", "status"), ("reader", "in"), {"dataport.fan_in": "1"})


def test_cutting_by_name_and_by_object(system: System) -> None:
    first = system.connect(("writer", "out"), ("reader", "in"), name="c")
    system.disconnect("c")
    assert not first.connected
    with pytest.raises(UnknownConnectionError, match="no connection 'c'"):
        system.disconnect(first)
    second = system.connect(("writer", "out"), ("reader", "in"), name="c")
    with pytest.raises(UnknownConnectionError, match="is cut already"):
        system.disconnect(first)
    assert second.connected
    system.disconnect(second)
    assert system.connectors == ()


def test_removing_a_component_cuts_its_connections(system: System) -> None:
    system.connect(("writer", "out"), ("reader", "in"))
    system.connect(("both", "status"), ("reader", "in"), name="stays")
    system.remove("writer")
    assert system.instances == ("both", "reader")
    assert [connector.name for connector in system.connectors] == ["stays"]


@pytest.mark.parametrize(
    ("key", "text", "reason"),
    [
        ("dataport.bufer.length", "8", "did you mean 'dataport.buffer.length'"),
        ("colour", "red", "unknown connector property 'colour'"),
        ("dataport.buffer.length", "0", "an integer, at least 1"),
        ("dataport.buffer.length", "eight", "an integer, at least 1"),
        ("dataport.buffer.length", "-1", "an integer, at least 1"),
        (
            "dataport.inport.buffer.write.full_policy",
            "explode",
            "overwrite or do_nothing or block",
        ),
        (
            "dataport.outport.buffer.read.empty_policy",
            "",
            "readback or do_nothing or block",
        ),
        ("dataport.buffer.read.timeout", "-1", "a time in seconds"),
        ("dataport.buffer.write.timeout", "nan", "a time in seconds"),
        ("dataport.subscription_type", "sometimes", "flush or new or periodic"),
        (
            "dataport.io_mode",
            "sometimes",
            "flush or new or periodic or block or nonblock",
        ),
        ("dataport.dataflow_type", "duplex", "push or pull"),
        ("dataport.interface_type", "pigeon", "corba_cdr or direct"),
        ("dataport.marshaling_type", "json", "must be cdr"),
        ("dataport.serializer.cdr.endian", "middle", "little or big"),
        ("dataport.publisher.push_policy", "random", "all or fifo or skip or new"),
        ("dataport.publisher.skip_count", "-1", "an integer, at least 0"),
        ("dataport.fan_in", "0", "an integer, at least 1"),
        ("dataport.allow_dup_connection", "perhaps", "YES or NO"),
    ],
)
def test_bad_properties(key: str, text: str, reason: str) -> None:
    with pytest.raises(ConnectorPropertyError) as caught:
        joined({key: text})
    assert reason in str(caught.value)
    assert repr(key) in str(caught.value)


@pytest.mark.parametrize("rate", [None, "0", "-5", "inf", "fast"])
def test_periodic_needs_a_rate(rate: str | None) -> None:
    properties = {"dataport.subscription_type": "periodic"}
    if rate is not None:
        properties["dataport.publisher.push_rate"] = rate
    with pytest.raises(ConnectorPropertyError, match=r"dataport\.publisher\.push_rate"):
        joined(properties)


def test_contradicting_words_for_the_subscription() -> None:
    old, new = "dataport.subscription_type", "dataport.io_mode"
    with pytest.raises(ConnectorPropertyError, match="contradict each other"):
        joined({old: "flush", new: "nonblock"})
    joined({old: "new", new: "nonblock"})
    joined({old: "flush", new: "block"})
    joined({new: "new"})


def test_properties_that_do_not_matter_here() -> None:
    system, out, port = joined(
        {
            "dataport.interface_type": "shared_memory",
            "dataport.data_type": "IDL:RTC/TimedLong:1.0",
            "dataport.serializer.cdr.endian": "big, little",
            "dataport.inport.marshaling_type": "cdr",
            "dataport.corba_cdr.inport_ior": "IOR:0100",
        }
    )
    out.write(long(1))
    assert drained(port) == [1]
    assert (
        system.connector("c").properties["dataport.interface_type"] == "shared_memory"
    )


def test_connections_are_cut_and_remade_by_callbacks_while_active() -> None:
    got: list[int] = []
    system, out, port = joined()
    writer, reader = system.component("writer"), system.component("reader")
    assert isinstance(writer, Actor)
    assert isinstance(reader, Actor)
    ticks = iter(range(100))

    def write() -> None:
        tick = next(ticks)
        if tick == 2:
            system.disconnect("c")
        if tick == 4:
            system.connect(("writer", "out"), ("reader", "in"), name="c")
        out.write(long(tick))

    writer.execute = write
    reader.execute = lambda: got.extend(drained(port))
    system.run(until_ns=6_000_000)
    assert got == [0, 1, 4, 5]
    assert out.unsent == 2
