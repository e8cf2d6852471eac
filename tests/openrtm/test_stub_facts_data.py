"""Verified facts about data ports of OpenRTM-aist-Python 2.1."""

from __future__ import annotations

import struct
import time
from typing import Any

import pytest
from openrtm_lab import Lab
from patience import until


def long(value: int) -> Any:
    import RTC

    return RTC.TimedLong(RTC.Time(1, 2), value)


def pair(lab: Lab) -> tuple[Any, Any]:
    return lab.out_port(long(0)), lab.in_port(long(0))


def read_all(port: Any) -> list[int]:
    found = []
    while port.isNew():
        found.append(port.read().data)
    return found


def test_a_used_port_name_is_refused(lab: Lab) -> None:
    component = lab.component()
    assert component.addInPort("x", lab.rtm.InPort("x", long(0)))
    assert component.addOutPort("x", lab.rtm.OutPort("x", long(0))) is False
    assert len(component.getObjRef().get_ports()) == 1


def test_a_port_says_what_it_is(lab: Lab) -> None:
    out, inp = pair(lab)
    for port, kind in ((out, "DataOutPort"), (inp, "DataInPort")):
        profile = port.getPortRef().get_port_profile()
        assert profile.name.endswith(".data")
        assert profile.name.partition(".")[0] == (
            profile.owner.get_component_profile().instance_name
        )
        properties = {each.name: each.value.value() for each in profile.properties}
        assert properties["port.port_type"] == kind
        assert properties["dataport.data_type"] == "IDL:RTC/TimedLong:1.0"
        assert "corba_cdr" in properties["dataport.interface_type"]
        assert {"push", "pull"} <= {
            each.strip() for each in properties["dataport.dataflow_type"].split(",")
        }
        assert "cdr" in properties["dataport.marshaling_types"]
        assert "dataport.subscription_type" in properties


def test_what_is_pushed_is_read_in_order_and_again(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    assert out.write(long(1)) is False
    assert lab.connect(out, inp) == RTC.RTC_OK
    assert inp.isEmpty()
    assert not inp.isNew()
    for number in (1, 2):
        assert out.write(long(number))
    first, second = inp.read(), inp.read()
    assert (first.data, second.data) == (1, 2)
    assert first is not second
    assert not inp.isNew()
    assert inp.read().data == 2


def test_ten_writes_leave_eight(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp)
    for number in range(10):
        assert out.write(long(number))
    assert read_all(inp) == list(range(2, 10))


def test_the_bound_value_is_sent_by_default(lab: Lab) -> None:
    value = long(0)
    out, inp = lab.out_port(value), lab.in_port(long(0))
    lab.connect(out, inp)
    value.data = 5
    assert out.write()
    assert inp.read().data == 5


def test_the_connectors_of_an_in_port_share_a_buffer(lab: Lab) -> None:
    """It is emptied by each new connection, whose length and policies it adopts."""
    (first, inp), second = pair(lab), lab.out_port(long(0))
    lab.connect(first, inp)
    assert first.write(long(0))
    lab.connect(second, inp, buffer__length="3")
    assert not inp.isNew()
    assert second.write(long(2))
    assert inp.isNew()
    names: list[str] = []
    assert inp.isNew(names)
    assert names == ["wire", "wire"]
    for number in range(3, 6):
        assert first.write(long(number))
    assert read_all(inp) == [3, 4, 5]


def test_a_refused_write_is_false(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, buffer__write__full_policy="do_nothing", buffer__length="2")
    assert [out.write(long(number)) for number in range(3)] == [True, True, False]
    assert read_all(inp) == [0, 1]


def test_policies_of_a_connection_leak_into_the_next(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, buffer__write__full_policy="do_nothing", buffer__length="2")
    lab.rtm.disconnect_all_by_ref(out.getPortRef())
    lab.connect(out, inp)
    written = [out.write(long(number)) for number in range(9)]
    assert False in written


def test_pulled_values_are_not_new(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, dataflow_type="pull")
    assert out.write(long(7))
    assert not inp.isNew()
    assert inp.read().data == 7


@pytest.mark.sampled(1)
@pytest.mark.parametrize("word", ["new", "nonblock"])
def test_a_publisher_sends_the_newest(lab: Lab, word: str) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, subscription_type=word)
    assert out.write(long(7))
    until(inp.isNew)
    assert inp.read().data == 7


def test_a_publisher_sends_all(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, subscription_type="new", publisher__push_policy="all")
    found: list[int] = []
    for number in range(8):
        assert out.write(long(number))
    until(lambda: (found.extend(read_all(inp)), len(found) == 8)[1])
    assert found == list(range(8))


def test_a_publisher_skips(lab: Lab) -> None:
    """Each third value is sent."""
    out, inp = pair(lab)
    lab.connect(
        out,
        inp,
        subscription_type="new",
        publisher__push_policy="skip",
        publisher__skip_count="2",
        buffer__length="32",
    )
    found: list[int] = []
    for number in range(12):
        assert out.write(long(number))
    until(lambda: (found.extend(read_all(inp)), len(found) == 4)[1])
    assert found == [found[0] + 3 * place for place in range(4)]


def test_a_publisher_keeps_what_a_full_receiver_refuses(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(
        out,
        inp,
        subscription_type="new",
        publisher__push_policy="all",
        buffer__length="4",
        inport__buffer__length="1",
        inport__buffer__write__full_policy="do_nothing",
    )
    assert out.write(long(0))
    until(inp.isNew)
    out.write(long(1))
    until(lambda: not out.write(long(2)))
    assert inp.read().data == 0
    out.write(long(3))
    until(inp.isNew)
    assert inp.read().data == 1


def test_what_cannot_be_marshalled_is_not_sent(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp)
    assert out.write(long("text")) is False  # type: ignore[arg-type]
    assert out.write(long(1))
    assert read_all(inp) == [1]


def test_ends_of_a_connection_have_their_own_buffers(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, buffer__length="2", inport__buffer__length="3")
    for number in range(5):
        out.write(long(number))
    assert read_all(inp) == [2, 3, 4]


def test_a_publisher_with_a_rate(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(
        out,
        inp,
        subscription_type="periodic",
        push_rate="50",
        publisher__push_rate="50",
        publisher__push_policy="fifo",
    )
    found: list[int] = []
    for number in range(3):
        out.write(long(number))
    until(lambda: (found.extend(read_all(inp)), len(found) == 3)[1])
    assert found == [0, 1, 2]


def test_flush_is_the_default(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp)
    out.write(long(1))
    assert inp.isNew()


def test_an_unread_buffer_that_blocks_times_out(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(
        out,
        inp,
        buffer__length="1",
        buffer__write__full_policy="block",
        buffer__write__timeout="0.05",
    )
    assert out.write(long(1))
    begun = time.monotonic()
    assert out.write(long(2)) is False
    assert time.monotonic() - begun >= 0.05
    assert read_all(inp) == [1]


def test_an_empty_buffer_that_does_nothing_gives_the_last_value(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    assert lab.connect(out, inp, buffer__read__empty_policy="do_nothing") == RTC.RTC_OK
    out.write(long(3))
    assert [inp.read().data, inp.read().data] == [3, 3]
    assert inp.connectors()[0].read(long(0))[0] == lab.rtm.DataPortStatus.BUFFER_EMPTY


def test_structs_without_a_time_are_port_types(lab: Lab, facts: Any) -> None:
    import RTC

    out, inp = (
        lab.out_port(facts.Plain(0, "")),
        lab.in_port(facts.Plain(0, "")),
    )
    assert lab.connect(out, inp) == RTC.RTC_OK
    assert out.write(facts.Plain(4, "four"))
    assert (inp.read().number, inp.read().text) == (4, "four")


def test_ports_of_other_types_are_connected(lab: Lab) -> None:
    import RTC

    out = lab.out_port(RTC.TimedDouble(RTC.Time(0, 0), 0.0))
    assert lab.connect(out, lab.in_port(long(0))) == RTC.RTC_OK


def test_an_unknown_interface_type_is_a_bad_parameter(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    assert lab.connect(out, inp, interface_type="pigeon") == RTC.BAD_PARAMETER
    assert out.getPortRef().get_connector_profiles() == []


def test_a_second_connection_of_the_same_ports_is_refused(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    assert lab.connect(out, inp) == RTC.RTC_OK
    assert lab.connect(out, inp) == RTC.PRECONDITION_NOT_MET
    assert lab.connect(out, inp, allow_dup_connection="YES") == RTC.RTC_OK
    assert out.write(long(1))
    assert len(inp.connectors()) == 2


def test_a_connection_says_what_it_was_made_with(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp)
    (profile,) = inp.getPortRef().get_connector_profiles()
    properties = {each.name: each.value.value() for each in profile.properties}
    assert profile.name == "wire"
    assert properties["dataport.interface_type"] == "corba_cdr"
    assert properties["dataport.dataflow_type"] == "push"
    assert properties["dataport.serializer.cdr.endian"].replace(" ", "") == "little,big"


@pytest.mark.parametrize("endian", ["little,big", "big,little"])
def test_octets_are_plain_cdr(lab: Lab, endian: str) -> None:
    import RTC

    value = RTC.TimedOctetSeq(RTC.Time(1, 2), b"ab")
    out, inp = (
        lab.out_port(value),
        lab.in_port(RTC.TimedOctetSeq(RTC.Time(0, 0), b"")),
    )
    lab.connect(out, inp, serializer__cdr__endian=endian)
    assert out.write()
    _, octets = inp.connectors()[0].readBuff()
    order = endian.partition(",")[0]
    assert len(octets) == 14
    numbers = struct.pack("<3L" if order == "little" else ">3L", 1, 2, 2)
    assert octets == numbers + b"ab"
    assert inp.read().data == b"ab"


def test_direct_ports_share_the_value(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    assert lab.connect(out, inp, interface_type="direct") == RTC.RTC_OK
    value = long(1)
    assert out.write(value)
    assert inp.isNew()
    assert inp.read() is value


def test_a_disconnected_port_is_unconnected(lab: Lab) -> None:
    import RTC

    out, inp = pair(lab)
    lab.connect(out, inp)
    assert lab.rtm.disconnect_all_by_ref(inp.getPortRef()) == RTC.RTC_OK
    assert out.write(long(1)) is False
    assert out.connectors() == inp.connectors() == []


def test_a_lost_peer_ends_the_connection(lab: Lab) -> None:
    out, inp = pair(lab)
    lab.connect(out, inp, subscription_type="flush")
    inp.connectors()[0].disconnect()
    assert out.write(long(1)) is False
    assert out.connectors() == []


@pytest.mark.parametrize(
    "name",
    [
        *("TimedOctetSeq", "TimedCharSeq", "TimedChar", "TimedWChar"),
        *("CameraImage", "GripperState"),
    ],
)
def test_some_default_values_cannot_be_marshalled(rtm: Any, name: str) -> None:
    import RTC
    from omniORB import CORBA, cdrMarshal

    kind = getattr(RTC, name)
    value = rtm.instantiateDataType(kind)
    with pytest.raises(CORBA.BAD_PARAM):
        cdrMarshal(CORBA.TypeCode(CORBA.id(kind)), value, True)


@pytest.mark.parametrize("name", ["TimedLong", "TimedPose3D", "RangeData", "Path2D"])
def test_other_default_values_can(rtm: Any, name: str) -> None:
    import RTC
    from omniORB import CORBA, cdrMarshal

    kind = getattr(RTC, name)
    value = rtm.instantiateDataType(kind)
    assert cdrMarshal(CORBA.TypeCode(CORBA.id(kind)), value, True)


def test_a_time_stamp_is_the_wall_clock(rtm: Any) -> None:
    value = long(0)
    before = int(time.time())
    rtm.setTimestamp(value)
    assert before <= value.tm.sec <= int(time.time())
    assert 0 <= value.tm.nsec < 1_000_000_000


def test_a_component_s_properties_have_defaults_of_ports(lab: Lab) -> None:
    component = lab.component("port.inport.data.buffer.length", "2")
    out, inp = lab.out_port(long(0)), lab.rtm.InPort("data", long(0))
    component.addInPort("data", inp)
    lab.connect(out, inp)
    for number in range(4):
        out.write(long(number))
    assert read_all(inp) == [2, 3]
