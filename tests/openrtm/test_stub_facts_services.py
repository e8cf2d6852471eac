"""Verified facts about service ports of OpenRTM-aist-Python 2.1."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from openrtm_lab import Lab


@pytest.fixture
def provider(lab: Lab, facts: Any) -> Callable[..., tuple[Any, Any]]:
    """Return a maker of components with a service port that provides `Echo`, and of the port."""
    import Facts__POA

    class EchoServant(Facts__POA.Echo):  # type: ignore[misc, name-defined]
        def say(self, text: str) -> str:
            if text == "refused":
                raise facts.Refused("no")
            if text == "broken":
                raise ValueError("no")
            return text * 2

    def make(instance: str = "echo", kind: str = "Facts::Echo") -> tuple[Any, Any]:
        component, port = lab.component(), lab.rtm.CorbaPort("service")
        assert port.registerProvider(instance, kind, EchoServant())
        assert component.addPort(port)
        return component, port

    return make


@pytest.fixture
def consumer(lab: Lab, facts: Any) -> Callable[..., tuple[Any, Any]]:
    """Return a maker of components with a service port that requires `Echo`: port and consumer."""

    def make(instance: str = "echo", kind: str = "Facts::Echo") -> tuple[Any, Any]:
        port = lab.rtm.CorbaPort("service")
        needed = lab.rtm.CorbaConsumer(interfaceType=facts.Echo)
        assert port.registerConsumer(instance, kind, needed)
        assert lab.component().addPort(port)
        return port, needed

    return make


def test_a_port_lists_its_interfaces(provider: Any, consumer: Any) -> None:
    import RTC

    for port, polarity in (
        (provider()[1], RTC.PROVIDED),
        (consumer()[0], RTC.REQUIRED),
    ):
        profile = port.getPortRef().get_port_profile()
        (found,) = profile.interfaces
        assert (found.instance_name, found.type_name) == ("echo", "Facts::Echo")
        assert found.polarity == polarity
        properties = {each.name: each.value.value() for each in profile.properties}
        assert properties["port.port_type"] == "CorbaPort"


def test_services_are_called_while_the_provider_is_active(
    lab: Lab, provider: Any, consumer: Any
) -> None:
    import RTC
    from omniORB import CORBA

    component, provided = provider()
    required, needed = consumer()
    assert needed._ptr() is None
    assert lab.join(required, provided) == RTC.RTC_OK
    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        needed._ptr(True).say("a")
    lab.activate(component)
    assert needed._ptr().say("a") == "aa"
    assert needed._ptr(True).say("a") == "aa"
    lab.deactivate(component)
    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        needed._ptr(True).say("a")
    lab.activate(component)
    assert needed._ptr(True).say("a") == "aa"


def test_an_exception_of_the_definition_comes_through_others_are_unknown(
    lab: Lab, facts: Any, provider: Any, consumer: Any
) -> None:
    from omniORB import CORBA

    (component, provided), (required, needed) = provider(), consumer()
    lab.join(required, provided)
    lab.activate(component)
    with pytest.raises(facts.Refused) as refused:
        needed._ptr(True).say("refused")
    assert refused.value.why == "no"
    with pytest.raises(CORBA.UNKNOWN):
        needed._ptr(True).say("broken")


@pytest.mark.parametrize(
    "differing", [{"instance": "reverb"}, {"kind": "Facts::Other"}, {"kind": "Echo"}]
)
def test_other_names_do_not_meet(
    lab: Lab, provider: Any, consumer: Any, differing: dict[str, str]
) -> None:
    import RTC

    _, provided = provider()
    required, needed = consumer(**differing)
    assert lab.join(required, provided) == RTC.RTC_OK
    assert needed._ptr() is None


def test_with_strictness_they_have_to_meet(
    lab: Lab, provider: Any, consumer: Any
) -> None:
    import RTC

    _, provided = provider()
    required, needed = consumer("reverb")
    asked = lab.rtm.Properties()
    asked.setProperty("port.connection.strictness", "strict")
    assert lab.join(required, provided, asked) == RTC.RTC_ERROR
    assert needed._ptr() is None
    assert provided.getPortRef().get_connector_profiles() == []
    required, needed = consumer()
    assert lab.join(required, provided, asked) == RTC.RTC_OK
    assert needed._ptr(True) is not None


def test_a_property_joins_differing_names(
    lab: Lab, provider: Any, consumer: Any
) -> None:
    import RTC

    component, provided = provider()
    required, needed = consumer("reverb", "Facts::Reverb")
    needing, providing = (
        port.getPortRef().get_port_profile().name.partition(".")[0]
        for port in (required, provided)
    )
    asked = lab.rtm.Properties()
    asked.setProperty(
        f"{needing}.port.service.required.Facts::Reverb.reverb",
        f"{providing}.port.service.provided.Facts::Echo.echo",
    )
    asked.setProperty("port.connection.strictness", "strict")
    assert lab.join(required, provided, asked) == RTC.RTC_OK
    lab.activate(component)
    assert needed._ptr(True).say("b") == "bb"


def test_a_disconnected_consumer_is_empty(
    lab: Lab, provider: Any, consumer: Any
) -> None:
    (_, provided), (required, needed) = provider(), consumer()
    lab.join(required, provided)
    lab.rtm.disconnect_all_by_ref(provided.getPortRef())
    assert needed._ptr() is None


def test_a_port_added_while_active_works_from_the_next_activation(
    lab: Lab, provider: Any, consumer: Any
) -> None:
    import Facts__POA
    from omniORB import CORBA

    class Doubling(Facts__POA.Echo):  # type: ignore[misc, name-defined]
        def say(self, text: str) -> str:
            return text * 2

    component = lab.component()
    lab.activate(component)
    port = lab.rtm.CorbaPort("late")
    port.registerProvider("echo", "Facts::Echo", Doubling())
    component.addPort(port)
    required, needed = consumer()
    lab.join(required, port)
    with pytest.raises(CORBA.OBJECT_NOT_EXIST):
        needed._ptr(True).say("a")
    lab.deactivate(component)
    lab.activate(component)
    assert needed._ptr(True).say("a") == "aa"
