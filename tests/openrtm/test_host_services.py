"""Services between OpenRTM's service ports and the providers and consumers of a behaviour."""

from __future__ import annotations

import logging
from typing import Any

import pytest
from hosting import Relay
from openrtm_lab import Lab

from rtgen.runtime.services.servants import ObjectNotExist, UnknownException


@pytest.fixture
def asking(relay: Relay, lab: Lab) -> Relay:
    """Return a relay whose consumer is connected to the provider of `relay`."""
    other = Relay(lab.create(f"Relay?instance_name={lab.unused('Asking')}"), lab)
    code = lab.join(other.rtc._askingPort, relay.rtc._countingPort)
    assert str(code) == "RTC_OK"
    return other


def refused() -> type[Exception]:
    from hosted.hosted import Refused

    return Refused


def reference(relay: Relay, lab: Lab) -> Any:
    """Return the provider as other components see it."""
    import Hosted

    consumer = lab.rtm.CorbaConsumer(interfaceType=Hosted.Counter)
    port = lab.rtm.CorbaPort("mine")
    port.registerConsumer("Counter", "Hosted::Counter", consumer)
    assert lab.component().addPort(port)
    assert str(lab.join(port, relay.rtc._countingPort)) == "RTC_OK"
    return consumer._ptr(True)


def test_interfaces_as_openrtm_knows_them(relay: Relay) -> None:
    profiles = relay.rtc.getObjRef().get_component_profile().port_profiles
    interfaces = {
        port.name.rpartition(".")[2]: [
            (each.instance_name, each.type_name, str(each.polarity))
            for each in port.interfaces
        ]
        for port in profiles
        if port.interfaces
    }
    assert interfaces == {
        "counting": [("Counter", "Hosted::Counter", "PROVIDED")],
        "asking": [("Counter", "Hosted::Counter", "REQUIRED")],
        "bells": [("Bell", "lab::Ringer", "PROVIDED")],
    }


def test_a_provider_serves_while_it_is_active(relay: Relay, lab: Lab) -> None:
    import Hosted
    from omniORB import CORBA

    counter = reference(relay, lab)
    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        counter.add(1)
    relay.activate()
    assert counter.add(2) == 2
    counter._set_total(10)
    assert counter.add(2) == 12
    assert counter._get_total() == 12
    with pytest.raises(Hosted.Refused) as caught:
        counter.add(-1)
    assert caught.value.why == "negative"
    with pytest.raises(CORBA.UNKNOWN):
        counter.add(2000)
    lab.deactivate(relay.rtc)
    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        counter.add(1)


def test_a_servant_in_the_process_is_not_called_behind_the_state(
    relay: Relay, lab: Lab
) -> None:
    from omniORB import CORBA

    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        relay.rtc._s_counter.add(1)
    relay.activate()
    assert relay.rtc._s_counter.add(1) == 1


def test_a_consumer_without_a_provider(relay: Relay) -> None:
    other = relay.behaviour.other
    assert not other.connected
    with pytest.raises(ObjectNotExist):
        other.object.add(1)


def test_a_consumer_calls(relay: Relay, asking: Relay) -> None:
    other = asking.behaviour.other
    assert other.connected
    with pytest.raises(ObjectNotExist):
        other.object.add(1)
    relay.activate()
    assert other.object.add(3) == 3
    other.object.total = 7
    assert other.object.total == 7
    with pytest.raises(refused(), match="negative"):
        other.object.add(-1)
    with pytest.raises(UnknownException):
        other.object.add(2000)


def test_a_connection_that_leaves_a_consumer_empty_is_reported(
    relay: Relay, lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    """OpenRTM compares type names exactly, and returns RTC_OK."""
    import Hosted__POA

    port = lab.rtm.CorbaPort("mine")
    port.registerProvider("Counter", "Counter", Hosted__POA.Counter())
    assert lab.component().addPort(port)
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        assert str(lab.join(relay.rtc._askingPort, port)) == "RTC_OK"
    assert not relay.behaviour.other.connected
    name = relay.behaviour.instance_name
    assert f"{name}.asking:Counter: the connection 'wire'" in caplog.text
    assert "has no provider for it; it offers Counter.Counter" in caplog.text


def test_a_consumer_is_cut_off(relay: Relay, asking: Relay) -> None:
    relay.activate()
    stub = asking.behaviour.other.object
    assert stub.add(1) == 1
    asking.rtc._askingPort.disconnect_all()
    assert not asking.behaviour.other.connected
    with pytest.raises(ObjectNotExist):
        stub.add(1)


def test_an_interface_in_no_module(relay: Relay, lab: Lab) -> None:
    import _GlobalIDL

    consumer = lab.rtm.CorbaConsumer(interfaceType=_GlobalIDL.Bell)
    port = lab.rtm.CorbaPort("mine")
    port.registerConsumer("Bell", "lab::Ringer", consumer)
    assert lab.component().addPort(port)
    assert str(lab.join(port, relay.rtc._bellsPort)) == "RTC_OK"
    relay.activate()
    assert consumer._ptr(True).ring(_GlobalIDL.Plain("こんにちは")) == "はちにんこ"
