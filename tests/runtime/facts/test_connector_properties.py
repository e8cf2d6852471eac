"""The same connector properties in the check of systems and the embedded runtime."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Connection, PortReference, System
from rtgen.compiler.systems.checks import check_properties
from rtgen.facts.connector_properties import SERVICE, is_foreign, stated_data
from rtgen.runtime.errors import ConnectorPropertyError
from rtgen.runtime.ports import connector_properties as runtime
from rtgen.runtime.services.connectors import read_properties

TEXTS = (
    *("", "0", "1", "8", "-1", "1.5", "0.0", "nan", "inf", "many", "0x10", "YES", "no"),
    *("push", "pull", "flush", "new", "periodic", "block", "nonblock", "all", "fifo"),
    *("skip", "overwrite", "do_nothing", "readback", "cdr", "corba_cdr", "direct"),
    *("little", "little,big", "middle", "IDL:RTC/TimedLong:1.0", " 8 ", "9" * 30, "٣"),
    *("strict", "best_effort", " strict", "1_0", "+1"),
)
SPAN = Span("map.xml", 1, 1, 1, 2)
END = PortReference(instance="A0", port="out")
CONNECTION = Connection(name="c", source=END, target=END, service=False, span=SPAN)


def checked(properties: Mapping[str, str], *, service: bool) -> bool:
    """Return whether the check of a system accepts the properties."""
    connection = replace(
        CONNECTION, service=service, properties=tuple(properties.items())
    )
    system = System(
        name="s",
        id="",
        file="map.xml",
        abstract="",
        components=(),
        connections=(connection,),
    )
    return not [*check_properties(system)]


def connected(properties: Mapping[str, str], *, service: bool) -> bool:
    """Return whether the runtime accepts them."""
    read = read_properties if service else runtime.parse
    try:
        read(properties)
    except ConnectorPropertyError:
        return False
    return True


@pytest.mark.sampled(60)
@pytest.mark.parametrize("key", [*stated_data(), *SERVICE])
def test_both_take_the_same(key: str) -> None:
    for text in TEXTS:
        properties = {key: text}
        service = key in SERVICE
        assert checked(properties, service=service) is connected(
            properties, service=service
        ), text


@pytest.mark.parametrize("rate", [{}, {"dataport.publisher.push_rate": "5"}])
@pytest.mark.parametrize("mode", ["block", "nonblock", "flush", "new", "periodic", "x"])
@pytest.mark.parametrize("subscription", ["flush", "new", " periodic ", "x"])
def test_both_take_the_same_subscriptions(
    rate: dict[str, str], mode: str, subscription: str
) -> None:
    properties = {
        "dataport.io_mode": mode,
        "dataport.subscription_type": subscription,
        **rate,
    }
    assert checked(properties, service=False) is connected(properties, service=False)


def test_duplex_is_openrtm_s_alone() -> None:
    properties = {"dataport.dataflow_type": "duplex"}
    assert checked(properties, service=False)
    assert not connected(properties, service=False)


@pytest.mark.parametrize(
    ("key", "foreign"),
    [
        ("POSITION", True),
        ("rtgen.openrtm.dataport.subscription_type", True),
        ("dataport.corba_cdr.inport_ior", True),
        ("dataport.bufer.length", False),
        ("port.connection.strictness", False),
        ("B0.port.s.required.M::S.one", False),
    ],
)
def test_which_are_none_of_openrtm_s(key: str, foreign: bool) -> None:
    assert is_foreign(key) is foreign
