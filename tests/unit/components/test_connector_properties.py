"""The table of connector properties says what the embedded runtime does with them."""

from __future__ import annotations

import pytest

from rtgen.runtime import connector_properties as runtime
from rtgen.runtime.errors import ConnectorPropertyError
from rtgen.typemap.connector_properties import DATA, is_foreign

TEXTS = (
    *("", "0", "1", "8", "-1", "1.5", "0.0", "nan", "inf", "many", "0x10", "YES", "no"),
    *("push", "pull", "flush", "new", "periodic", "block", "nonblock", "all", "fifo"),
    *("skip", "overwrite", "do_nothing", "readback", "cdr", "corba_cdr", "direct"),
    *("little", "little,big", "middle", "IDL:RTC/TimedLong:1.0"),
)
NEEDED = {"dataport.publisher.push_rate": {"dataport.subscription_type": "periodic"}}


def taken(key: str, text: str) -> bool:
    further = NEEDED.get(key, {})
    if text == "periodic" and not further:
        further = {"dataport.publisher.push_rate": "5"}
    try:
        runtime.parse({key: text, **further})
    except ConnectorPropertyError:
        return False
    return True


@pytest.mark.parametrize("key", DATA)
def test_both_take_the_same(key: str) -> None:
    for text in TEXTS:
        assert (DATA[key](text) is None) == taken(key, text), text


def test_duplex_is_openrtm_s_alone() -> None:
    assert DATA["dataport.dataflow_type"]("duplex") is None
    assert not taken("dataport.dataflow_type", "duplex")


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
