"""Samples between OpenRTM's data ports and those of a behaviour."""

from __future__ import annotations

import logging
import threading
import time
from typing import Any

import pytest
from hosting import Relay
from msgspec.structs import replace
from openrtm_lab import Lab

from rtgen.runtime import PORT_OK, PortStatus, SampleTypeError

LAST = {"buffer__read__empty_policy": "do_nothing"}
PULL = {"dataflow_type": "pull"}
DIRECT = {"interface_type": "direct"}


def types() -> Any:
    import hosted.hosted

    return hosted.hosted


def wire(number: int) -> Any:
    """Return a sample as another author's component writes it."""
    import Hosted
    import RTC

    return Hosted.Sample(
        RTC.Time(1, 2), number, "t", "c", bytes([number % 256]), Hosted.FAST
    )


def sample(number: int) -> Any:
    """Return the same sample in the behaviour."""
    import hosted.rtc

    return types().Sample(
        hosted.rtc.Time(1, 2), number, "t", "c", bytes([number % 256]), types().FAST
    )


def source(relay: Relay, **properties: str) -> Any:
    """Return an OutPort that is connected to the relay's InPort."""
    port = relay.lab.out_port(wire(0))
    assert str(relay.lab.connect(port, relay.rtc._dataIn, **properties)) == "RTC_OK"
    return port


def sink(relay: Relay, **properties: str) -> Any:
    """Return an InPort that is connected to the relay's OutPort."""
    port = relay.lab.in_port(wire(0))
    assert (
        str(relay.lab.connect(relay.rtc._data_outOut, port, **properties)) == "RTC_OK"
    )
    return port


def numbers(port: Any) -> list[int]:
    """Return the numbers of the unread samples in an InPort of the behaviour."""
    found = []
    while port.is_new():
        found.append(port.read().number)
    return found


def test_ports_as_openrtm_knows_them(relay: Relay) -> None:
    profile = relay.rtc.getObjRef().get_component_profile()
    name = relay.behaviour.instance_name
    assert [port.name for port in profile.port_profiles] == [
        f"{name}.{port}"
        for port in (
            *("data", "wheel", "data_out", "positon", "plain"),
            *("counting", "asking", "bells"),
        )
    ]


def test_samples_come_in_order(relay: Relay) -> None:
    port = relay.behaviour.data
    assert not port.is_new()
    assert port.read() is None
    out = source(relay)
    assert not port.is_new()
    for number in range(3):
        assert out.write(wire(number))
    assert port.is_new()
    assert port.read() == sample(0)
    assert numbers(port) == [1, 2]
    # The object of the last read again.
    assert port.read() == sample(2)
    assert port.read() is port.read()
    assert port.read_newest() is None


def test_what_is_unread_waits_in_openrtms_buffer(relay: Relay) -> None:
    out = source(relay)
    for number in range(10):
        out.write(wire(number))
    assert numbers(relay.behaviour.data) == list(range(2, 10))
    for number in range(10):
        out.write(wire(number))
    assert relay.behaviour.data.read_newest() == sample(9)
    assert not relay.behaviour.data.is_new()


def test_a_sample_that_is_fetched_does_not_arrive(relay: Relay) -> None:
    """A behaviour that acts on arrivals, as adapters do, finds the samples at its own tick."""
    port = relay.behaviour.data
    arrivals: list[int] = []
    port.call_on_arrival(lambda: arrivals.append(1))
    one, two = source(relay), source(relay)
    for number in range(3):
        one.write(wire(number))
    two.write(wire(3))
    assert sorted(numbers(port)) == [0, 1, 2, 3]
    assert not arrivals


def test_an_event_driven_behaviour_is_executed_when_a_sample_waits(
    relay: Relay, monkeypatch: pytest.MonkeyPatch
) -> None:
    component = type(relay.behaviour)
    profile = replace(component.profile, activity="EVENTDRIVEN", triggers=("data",))
    monkeypatch.setattr(component, "profile", profile)
    out = source(relay)
    relay.activate()
    relay.behaviour.calls.clear()
    assert relay.tick() == []
    out.write(wire(1))
    assert relay.tick() == ["on_execute", "on_state_update"]
    relay.behaviour.data.read()
    relay.behaviour.calls.clear()
    assert relay.tick() == []


def test_a_writer_is_refused_when_the_buffer_is_full(relay: Relay) -> None:
    out = source(relay, buffer__length="2", buffer__write__full_policy="do_nothing")
    assert [out.write(wire(n)) for n in range(3)] == [True, True, False]
    assert relay.behaviour.data.read() == sample(0)
    assert out.write(wire(3))
    assert numbers(relay.behaviour.data) == [1, 3]


def test_all_connections_are_read(relay: Relay) -> None:
    one, two = source(relay), source(relay)
    two.write(wire(2))
    assert numbers(relay.behaviour.data) == [2]
    one.write(wire(1))
    two.write(wire(2))
    assert sorted(numbers(relay.behaviour.data)) == [1, 2]
    relay.rtc._dataIn.disconnect_all()
    assert not relay.behaviour.data.is_new()
    assert relay.behaviour.data.read() is not None


def test_nothing_unread_with_another_policy(relay: Relay) -> None:
    out = source(relay, **LAST)
    out.write(wire(1))
    port = relay.behaviour.data
    assert port.read() == sample(1)
    assert port.read() is None


def test_a_reader_waits(relay: Relay) -> None:
    policy = {"buffer__read__empty_policy": "block", "buffer__read__timeout": "5.0"}
    out = source(relay, **policy)
    timer = threading.Timer(0.05, out.write, [wire(7)])
    timer.start()
    assert relay.behaviour.data.read() == sample(7)
    timer.join()


def test_a_reader_does_not_wait_for_ever(relay: Relay) -> None:
    policy = {"buffer__read__empty_policy": "block", "buffer__read__timeout": "0.01"}
    source(relay, **policy)
    begun = time.monotonic()
    assert relay.behaviour.data.read() is None
    assert time.monotonic() >= begun + 0.01


def test_pulled_samples_are_new_once(relay: Relay) -> None:
    port = relay.behaviour.data
    out = source(relay, **PULL)
    out.write(wire(1))
    out.write(wire(2))
    assert numbers(port) == [1, 2]
    # OpenRTM returns the last value again.
    assert not port.is_new()
    assert port.read() == sample(2)
    out.write(wire(3))
    assert numbers(port) == [3]


def test_a_value_handed_over_in_the_process(relay: Relay) -> None:
    out = source(relay, **DIRECT)
    out.write(wire(4))
    assert numbers(relay.behaviour.data) == [4]
    assert not relay.behaviour.data.is_new()


def test_a_connection_that_ends_while_it_is_read(
    relay: Relay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OpenRTM removes its buffer first, and lists the connector a little longer."""
    port = source(relay)
    port.write(wire(1))
    (connection,) = relay.rtc._dataIn.connectors()
    data = relay.behaviour.in_ports["data"]
    monkeypatch.setattr(connection, "_buffer", None)
    assert not data.is_new()
    monkeypatch.undo()

    def ending(_: Any) -> Any:
        raise AttributeError("'NoneType' object has no attribute 'read'")

    monkeypatch.setattr(connection, "read", ending)
    assert not data.is_new()
    monkeypatch.undo()
    assert numbers(data) == [1]


def test_a_sample_that_cannot_be_taken_is_reported(
    relay: Relay, caplog: pytest.LogCaptureFixture
) -> None:
    out = source(relay, **DIRECT)
    broken = wire(4)
    broken.speed = None
    out.write(broken)
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        assert not relay.behaviour.data.is_new()
    assert f"{relay.behaviour.instance_name}.data: a sample cannot be taken" in (
        caplog.text
    )


def test_a_sample_goes_out(relay: Relay) -> None:
    port = relay.behaviour.data_out
    assert port.write(sample(1)) is PortStatus.PRECONDITION_NOT_MET
    assert port.unsent == 1
    one, two = sink(relay), sink(relay)
    value = sample(1)
    assert port.write(value) is PORT_OK
    value.number = 2
    assert port.write(value) is PORT_OK
    for target in (one, two):
        got = [target.read(), target.read()]
        assert [each.number for each in got] == [1, 2]
        assert got[0].text == "t"
        assert got[0].raw == b"\x01"
        assert str(got[0].speed) == "FAST"
    with pytest.raises(SampleTypeError):
        port.write(types().Refused("what is this?"))


def test_one_object_is_kept_for_all_samples(
    relay: Relay, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = []
    target = sink(relay)
    out = relay.rtc._data_outOut
    write = out.write
    monkeypatch.setattr(out, "write", lambda w: written.append(w) or write(w))
    for number in range(3):
        relay.behaviour.data_out.write(sample(number))
    assert all(each is relay.rtc._d_data_out for each in written)
    assert [target.read().number for _ in range(3)] == [0, 1, 2]


def test_a_receiver_in_the_process_keeps_its_sample(relay: Relay) -> None:
    target = sink(relay, **DIRECT)
    relay.behaviour.data_out.write(sample(1))
    first = target.read()
    relay.behaviour.data_out.write(sample(2))
    assert first.number == 1
    assert target.read().number == 2


@pytest.mark.parametrize(
    ("policy", "status"),
    [("do_nothing", PortStatus.BUFFER_FULL), ("block", PortStatus.BUFFER_TIMEOUT)],
)
def test_a_refused_write_is_reported(
    relay: Relay, policy: str, status: PortStatus
) -> None:
    target = sink(
        relay,
        buffer__length="1",
        buffer__write__full_policy=policy,
        buffer__write__timeout="0.01",
    )
    port = relay.behaviour.data_out
    assert port.write(sample(1)) is PORT_OK
    assert port.write(sample(2)) is status
    assert target.read().number == 1
    assert port.write(sample(3)) is PORT_OK


def test_a_connection_that_is_gone(relay: Relay, lab: Lab) -> None:
    target = sink(relay)
    lab.made[-1].exit()
    lab.made.pop()
    assert relay.behaviour.data_out.write(sample(1)) in (
        PortStatus.CONNECTION_LOST,
        PortStatus.PRECONDITION_NOT_MET,
    )
    assert not target.isNew()


def test_a_connection_that_ends_during_a_write(
    relay: Relay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OpenRTM removes the publisher first, and lists the connector a little longer."""
    target = sink(relay)
    port = relay.behaviour.data_out
    (connection,) = relay.rtc._data_outOut.connectors()
    monkeypatch.setattr(connection, "_publisher", None)
    assert port.write(sample(1)) is PortStatus.CONNECTION_LOST
    monkeypatch.undo()
    assert port.write(sample(2)) is PORT_OK
    assert target.read().number == 2


def test_a_port_with_a_bus_behind_it_is_never_unconnected(relay: Relay) -> None:
    from rtgen.runtime.ports.data_ports import DataConnector, InPort

    port = relay.behaviour.data_out
    bus = InPort("bus", types().Sample)
    bus._protect(relay.behaviour._clock.guard())
    DataConnector("x", port, bus, {}, relay.behaviour._clock.guard).attach()
    assert port.write(sample(1)) is PORT_OK
    assert bus.read() == sample(1)


def test_samples_of_a_bus_and_of_openrtm_meet_in_an_in_port(relay: Relay) -> None:
    from rtgen.runtime.ports.data_ports import DataConnector, OutPort

    bus = OutPort("bus", types().Sample)
    port, guard = relay.behaviour.data, relay.behaviour._clock.guard
    DataConnector("x", bus, port, {}, guard).attach()
    out = source(relay)
    bus.write(sample(1))
    out.write(wire(2))
    assert sorted(numbers(port)) == [1, 2]


def test_a_type_in_openrtms_own_module(relay: Relay) -> None:
    import RTC

    value = RTC.TimedWheel(RTC.Time(1, 2), [0.5, -0.5])
    port = relay.lab.out_port(value)
    assert str(relay.lab.connect(port, relay.rtc._wheelIn)) == "RTC_OK"
    assert port.write()
    read = relay.behaviour.wheel.read()
    assert (read.tm.nsec, read.angles) == (2, [0.5, -0.5])


def test_a_type_in_no_module(relay: Relay) -> None:
    import _GlobalIDL
    from hosted import Plain

    port = relay.lab.in_port(_GlobalIDL.Plain(""))
    assert str(relay.lab.connect(relay.rtc._plainOut, port)) == "RTC_OK"
    assert relay.behaviour.plain.write(Plain("こんにちは, Привет")) is PORT_OK
    assert port.read().text == "こんにちは, Привет"


def test_stamps_are_utc(relay: Relay) -> None:
    value = sample(1)
    relay.behaviour.stamp(value)
    assert abs(value.tm.sec - time.time()) < 60
