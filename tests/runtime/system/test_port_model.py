"""Data ports compared with their simplest model: any sequence of writes, reads and cuts."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime_samples import Actor, activated, long

from rtgen.runtime import PORT_OK, DataConnector, PortStatus, System

WRITERS = 3


@dataclass
class Connection:
    """The model of a connection."""

    length: int
    overwrites: bool


@dataclass
class Model:
    """The model of an InPort: all unread samples with their writers, in order of arrival."""

    unread: list[tuple[int, int]] = field(default_factory=list)
    connections: dict[int, Connection] = field(default_factory=dict)
    lost: int = 0

    def write(self, writer: int, value: int) -> PortStatus:
        connection = self.connections.get(writer)
        if connection is None:
            return PortStatus.PRECONDITION_NOT_MET
        mine = [entry for entry in self.unread if entry[0] == writer]
        if len(mine) == connection.length:
            self.lost += 1
            if not connection.overwrites:
                return PortStatus.BUFFER_FULL
            self.unread.remove(mine[0])
        self.unread.append((writer, value))
        return PORT_OK

    def read(self) -> int | None:
        return self.unread.pop(0)[1] if self.unread else None

    def read_newest(self) -> int | None:
        newest = self.unread[-1][1] if self.unread else None
        self.unread.clear()
        return newest

    def cut(self, writer: int) -> None:
        del self.connections[writer]
        self.lost += sum(entry[0] == writer for entry in self.unread)
        self.unread = [entry for entry in self.unread if entry[0] != writer]


writers = st.integers(0, WRITERS - 1)
steps = st.one_of(
    st.tuples(st.just("write"), writers),
    st.tuples(st.just("write"), writers),
    st.tuples(st.just("read")),
    st.tuples(st.just("read_newest")),
    st.tuples(st.just("cut"), writers),
    st.tuples(st.just("connect"), writers, st.integers(1, 3), st.booleans()),
    st.tuples(st.just("connect"), writers, st.integers(1, 3), st.booleans()),
)


@pytest.mark.sampled(0)
@settings(max_examples=300, deadline=None)
@given(st.lists(steps, max_size=40))
def test_ports_do_as_the_model(course: list[tuple[str, int, int, bool]]) -> None:
    system, model = System(), Model()
    port = Actor("reader", inputs=("in",))
    outs = [Actor(f"w{n}", outputs=("out",)) for n in range(WRITERS)]
    activated(system, port, *outs)
    in_port = port.inputs["in"]
    cut_connectors: list[DataConnector[object]] = []
    for number, (name, *arguments) in enumerate(course):
        match name, *arguments:
            case "write", writer:
                status = outs[writer].outputs["out"].write(long(number))
                assert status is model.write(writer, number)
            case "read" | "read_newest", *_:
                expected = getattr(model, name)()
                if name == "read_newest" or expected is not None:
                    sample = getattr(in_port, name)()
                    assert (None if sample is None else sample.data) == expected
            case "cut", writer if writer in model.connections:
                connector = system.connector(f"c{writer}")
                system.disconnect(connector)
                cut_connectors.append(connector)  # type: ignore[arg-type]
                model.cut(writer)
            case "connect", writer, length, overwrites if (
                writer not in model.connections
            ):
                policy = "overwrite" if overwrites else "do_nothing"
                properties = {
                    "dataport.buffer.length": str(length),
                    "dataport.buffer.write.full_policy": policy,
                }
                system.connect(
                    (f"w{writer}", "out"), ("reader", "in"), properties, f"c{writer}"
                )
                model.connections[writer] = Connection(length, overwrites)
        assert in_port.is_new() == bool(model.unread)
        assert in_port.lost == model.lost
    assert (
        sum(connector.lost for connector in [*in_port.connectors, *cut_connectors])
        == model.lost
    )
