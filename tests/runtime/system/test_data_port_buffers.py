"""Reading, writing and the policies of full and empty buffers, in one thread."""

from __future__ import annotations

import runpy
import sys
from types import SimpleNamespace

import pytest
from runtime_samples import (
    Actor,
    TimedList,
    TimedLong,
    TwinOfTimedLong,
    activated,
    drained,
    joined,
    long,
)

from rtgen.runtime import PORT_OK, DataConnector, PortStatus, SampleTypeError, System
from rtgen.runtime.marshalling import reference_counts
from rtgen.runtime.ports import data_ports

FULL = "dataport.buffer.write.full_policy"
EMPTY = "dataport.buffer.read.empty_policy"
LENGTH = "dataport.buffer.length"


def test_a_sample_goes_from_writer_to_reader() -> None:
    _, out, port = joined()
    assert not port.is_new()
    assert out.write(long(1)) is PORT_OK
    assert out.write(long(2)) is PORT_OK
    assert port.is_new()
    assert drained(port) == [1, 2]
    assert port.lost == 0


def test_write_takes_a_snapshot() -> None:
    _, out, port = joined()
    sample = long(1)
    out.write(sample)
    sample.data = 2
    sample.tm.sec = 9
    assert port.read() == TimedLong(data=1)


def test_a_sample_that_is_given_away_is_not_copied() -> None:
    _, out, port = joined()
    sample = long(1)
    number = id(sample)
    assert out.write(sample, move=True) is PORT_OK
    del sample
    assert id(port.read()) == number


def test_a_sample_that_another_variable_has_is_copied_all_the_same() -> None:
    _, out, port = joined()
    sample = kept = long(1)
    out.write(sample, move=True)
    kept.data = 2
    assert port.read() == TimedLong(data=1)


def test_a_sample_is_copied_if_references_are_not_counted_exactly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 14, 0))
    counts = runpy.run_path(str(reference_counts.__file__))
    assert not counts["COUNTS_VARIABLES"]
    monkeypatch.setattr(sys, "implementation", SimpleNamespace(name="pypy"))
    assert not runpy.run_path(str(reference_counts.__file__))["EXACT"]
    monkeypatch.setattr(reference_counts, "COUNTS_VARIABLES", False)
    name = data_ports.__name__
    write = runpy.run_path(str(data_ports.__file__), run_name=name)["OutPort"].write
    monkeypatch.delattr(sys, "getrefcount")  # PyPy does not have it
    _, out, port = joined()
    sample = long(1)
    assert write(out, sample, move=True) is PORT_OK
    found = port.read()
    assert found == sample
    assert found is not sample


def test_a_sample_that_is_given_away_twice_is_copied_the_second_time() -> None:
    _, out, port = joined()
    sample = long(1)
    out.write(sample, move=True)
    out.write(sample, move=True)
    first, second = port.read(), port.read()
    assert first is sample
    assert second is not first
    assert second == first


def test_one_of_several_readers_gets_the_sample_that_is_given_away() -> None:
    system, out, port = joined()
    other = Actor("other", inputs=("in",))
    activated(system, other)
    system.connect(("writer", "out"), ("other", "in"))
    sample = long(1)
    assert out.write(sample, move=True) is PORT_OK
    found = [port.read(), other.inputs["in"].read()]
    assert found == [long(1), long(1)]
    assert [each is sample for each in found] == [False, True]


def test_what_is_given_away_is_checked_like_anything_else() -> None:
    _, out, port = joined()
    with pytest.raises(SampleTypeError):
        out.write("text", move=True)  # type: ignore[arg-type]
    assert not port.is_new()


def test_without_connection_the_status_says_so() -> None:
    writer = Actor("writer", outputs=("out",))
    activated(System(), writer)
    assert writer.outputs["out"].write(long(1)) is PortStatus.PRECONDITION_NOT_MET
    assert writer.outputs["out"].unsent == 1


def test_default_buffer_keeps_the_last_eight_and_counts_the_rest() -> None:
    system, out, port = joined()
    assert [out.write(long(n)) for n in range(10)] == [PORT_OK] * 10
    connector = system.connector("c")
    assert isinstance(connector, DataConnector)
    assert (connector.overwritten, connector.lost, port.lost) == (2, 2, 2)
    assert system.statistics("reader").lost == 2
    assert drained(port) == list(range(2, 10))


def test_do_nothing_refuses_and_counts() -> None:
    system, out, port = joined({FULL: "do_nothing", LENGTH: "2"})
    statuses = [out.write(long(n)) for n in range(3)]
    assert statuses == [PORT_OK, PORT_OK, PortStatus.BUFFER_FULL]
    assert drained(port) == [0, 1]
    assert out.write(long(3)) is PORT_OK
    connector = system.connector("c")
    assert isinstance(connector, DataConnector)
    assert (connector.refused, connector.overwritten, port.lost) == (1, 0, 1)


def test_block_does_not_wait_where_nobody_else_runs() -> None:
    _, out, port = joined({FULL: "block", EMPTY: "block", LENGTH: "1"})
    assert port.read() is None
    assert out.write(long(1)) is PORT_OK
    assert out.write(long(2)) is PortStatus.BUFFER_TIMEOUT
    assert drained(port) == [1]
    assert port.lost == 1


def test_readback_gives_the_last_value_again() -> None:
    _, out, port = joined({EMPTY: "readback"})
    assert port.read() is None
    out.write(long(1))
    first = port.read()
    assert first is not None
    assert first.data == 1
    assert port.read() is first
    assert not port.is_new()


def test_do_nothing_gives_none_when_empty() -> None:
    _, out, port = joined({EMPTY: "do_nothing"})
    out.write(long(1))
    assert drained(port) == [1]
    assert port.read() is None


def test_read_newest_drains() -> None:
    _, out, port = joined()
    assert port.read_newest() is None
    for n in range(3):
        out.write(long(n))
    newest = port.read_newest()
    assert newest is not None
    assert newest.data == 2
    assert not port.is_new()
    assert port.read_newest() is None
    assert port.read() is newest
    assert port.lost == 0


def test_settings_of_one_end_alone() -> None:
    length = {
        "dataport.inport.buffer.length": "3",
        "dataport.outport.buffer.length": "1",
    }
    _, out, port = joined({LENGTH: "2", **length})
    for n in range(5):
        out.write(long(n))
    assert drained(port) == [2, 3, 4]


def test_pull_reads_from_the_buffer_of_the_writer() -> None:
    length = {
        "dataport.inport.buffer.length": "3",
        "dataport.outport.buffer.length": "2",
    }
    _, out, port = joined({"dataport.dataflow_type": "pull", **length})
    for n in range(4):
        assert out.write(long(n)) is PORT_OK
    assert port.is_new()
    assert drained(port) == [2, 3]
    assert port.lost == 2


def test_one_to_many_gives_each_reader_its_own_object() -> None:
    system, out, port = joined()
    other = Actor("other", inputs=("in",))
    activated(system, other)
    system.connect(
        ("writer", "out"), ("other", "in"), {FULL: "do_nothing", LENGTH: "1"}
    )
    assert out.write(long(1)) is PORT_OK
    assert out.write(long(2)) is PortStatus.BUFFER_FULL
    first, second = port.read(), other.inputs["in"].read()
    assert first == second
    assert first is not second
    assert drained(port) == [2]
    assert (port.lost, other.inputs["in"].lost) == (0, 1)


def two_writers(
    properties: dict[str, str] | None = None,
) -> tuple[System, Actor, Actor]:
    system, _, _ = joined(properties)
    second, reader = Actor("second", outputs=("out",)), system.component("reader")
    activated(system, second)
    system.connect(("second", "out"), ("reader", "in"), properties, "c2")
    assert isinstance(reader, Actor)
    return system, second, reader


def test_many_to_one_comes_in_order_of_arrival() -> None:
    system, second, reader = two_writers()
    first, port = system.component("writer").out_ports["out"], reader.inputs["in"]
    for n in range(3):
        first.write(long(n))
        second.outputs["out"].write(long(10 + n))
    assert drained(port) == [0, 10, 1, 11, 2, 12]


def test_many_to_one_overwrites_in_the_connection_that_is_full() -> None:
    system, second, reader = two_writers({LENGTH: "2"})
    first, port = system.component("writer").out_ports["out"], reader.inputs["in"]
    second.outputs["out"].write(long(10))
    for n in range(4):
        first.write(long(n))
    assert drained(port) == [10, 2, 3]
    assert port.lost == 2
    first.write(long(4))
    second.outputs["out"].write(long(11))
    newest = port.read_newest()
    assert newest is not None
    assert newest.data == 11
    assert not port.is_new()


def test_a_second_connection_keeps_the_order_of_what_waits_and_its_cut_too() -> None:
    system, out, port = joined()
    out.write(long(1))
    second = Actor("second", outputs=("out",))
    activated(system, second)
    system.connect(("second", "out"), ("reader", "in"), None, "c2")
    second.outputs["out"].write(long(2))
    out.write(long(3))
    system.disconnect("c2")
    assert port.lost == 1
    out.write(long(4))
    assert drained(port) == [1, 3, 4]


def test_a_cut_connection_counts_what_was_unread_and_carries_nothing_over() -> None:
    system, out, port = joined()
    connector = system.connector("c")
    assert isinstance(connector, DataConnector)
    for n in range(3):
        out.write(long(n))
    assert port.read() == long(0)
    system.disconnect(connector)
    assert (connector.cut, port.lost, system.statistics("reader").lost) == (2, 2, 2)
    assert not port.is_new()
    assert port.read() == long(0)
    assert out.write(long(3)) is PortStatus.PRECONDITION_NOT_MET
    system.connect(("writer", "out"), ("reader", "in"))
    assert not port.is_new()
    out.write(long(4))
    assert drained(port) == [4]
    assert port.lost == 2


def test_data_waits_for_a_component_that_is_not_active_yet() -> None:
    system = System()
    writer, reader = Actor("writer", outputs=("out",)), Actor("reader", inputs=("in",))
    seen: list[int] = []
    reader.execute = lambda: seen.extend(drained(reader.inputs["in"]))
    activated(system, writer)
    system.add(reader)
    system.connect(("writer", "out"), ("reader", "in"))
    writer.outputs["out"].write(long(1))
    system.run(until_ns=5_000_000)
    assert seen == []
    system.activate("reader")
    system.run(until_ns=10_000_000)
    assert seen == [1]


def test_a_foreign_sample_is_refused_on_every_path() -> None:
    system, out, _ = joined()
    with pytest.raises(
        SampleTypeError, match=r"writer.out sends TimedLong, not TimedList"
    ):
        out.write(TimedList())
    system.add_listener(lambda record: None)
    with pytest.raises(SampleTypeError):
        out.write(TimedList())


def test_a_type_of_another_package_arrives_as_the_readers_own() -> None:
    system = System()
    writer = Actor("writer", outputs=("out",))
    reader = Actor("reader", inputs=("in",), type_=TwinOfTimedLong)
    activated(system, writer, reader)
    system.connect(("writer", "out"), ("reader", "in"))
    writer.outputs["out"].write(long(7))
    received = reader.inputs["in"].read()
    assert type(received) is TwinOfTimedLong
    assert received.data == 7
