"""Generated proxies, devices, manager and network, all on one simulated bus.

The device is that of the golden case: it has fields of every kind, once with a port for each PDO
and once with a port for each object.
"""

from __future__ import annotations

import importlib
import math
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    Component,
    ComponentProfile,
    System,
)
from rtgen.runtime.canopen.objects import over_service
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.runtime.library import canopen, rtc

CASE = Path(__file__).parents[2] / "golden/cases/canopen_devices/input"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Make the generated packages `lab` and `mylab` importable."""
    work = tmp_path_factory.mktemp("lab")
    shutil.copytree(CASE, work, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(work)
        assert run(["generate", "--no-cache", "--quiet"]) == 0
        patch.syspath_prepend(str(work / "generated"))
        patch.syspath_prepend(str(work / "src"))
        yield
    for name in list(sys.modules):
        if name.partition(".")[0] in ("lab", "mylab"):
            del sys.modules[name]


class Probe(Component):
    """A component that records samples of ports, and writes to others."""

    profile = ComponentProfile("Probe", rate=100.0)


def of(module: str, name: str) -> Any:
    return getattr(importlib.import_module(module), name)


class Bench:
    """The network `bench`: `first` with PDO ports, `second` with object ports."""

    def __init__(self) -> None:
        self.system = System()
        self.manager = of("lab.canopen.manager", "CanopenManager")("manager")
        self.first = of("mylab.sampler_device", "SamplerDevice")("first")
        self.second = of("mylab.sampler_pieces_device", "SamplerPiecesDevice")("second")
        self.proxy = of("lab.components.sampler_proxy", "SamplerProxy")("proxy")
        self.pieces = of("lab.components.sampler_pieces_proxy", "SamplerPiecesProxy")(
            "pieces"
        )
        self.probe = Probe("probe")
        for component, node in (
            (self.first, 3),
            (self.second, 4),
            (self.proxy, 3),
            (self.pieces, 4),
        ):
            component.configuration_sets.set("node_id", str(node))
        members = (self.manager, self.first, self.second, self.proxy, self.pieces)
        for component in (*members, self.probe):
            self.system.add(component, 100.0)
        for component in (self.proxy, self.pieces):
            self._wire(component)
        for name in ("manager", "probe", "proxy", "pieces"):
            self.system.activate(name)
        self.run(3.0)
        for component in members:
            name = component.instance_name
            assert self.system.state(name) == ACTIVE_STATE, component.reason

    def _wire(self, component: Any) -> None:
        owner = component.instance_name
        for port in list(component.out_ports.values()):
            self.probe.add_in_port(f"{owner}.{port.name}", port.type)
            self.system.connect(
                (owner, port.name),
                ("probe", f"{owner}.{port.name}"),
                {"dataport.buffer.length": "1000"},
            )
        for port in list(component.in_ports.values()):
            self.probe.add_out_port(f"to {owner}.{port.name}", port.type)
            self.system.connect(
                ("probe", f"to {owner}.{port.name}"), (owner, port.name)
            )

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def got(self, port: str) -> Any:
        """Return the newest sample of a port: `proxy.tpdo1`."""
        return self.probe.in_ports[port].read_newest()

    def send(self, port: str, sample: Any) -> None:
        """Write a sample to a port."""
        self.probe.out_ports[f"to {port}"].write(sample)

    def call(self, operation: str, *arguments: object) -> Any:
        """Call the SDO service of the first device's proxy."""
        return self.proxy.sdo.call(operation, arguments)


@pytest.fixture(scope="module")
def bench(lab: None) -> Iterator[Bench]:
    made = Bench()
    yield made
    made.system.close()


def fields(sample: Any) -> tuple[Any, ...]:
    """Return the members after the time stamp."""
    names = [m.name for m in type(sample)._descriptor_.members]
    return tuple(getattr(sample, name) for name in names[1:])


def test_the_network_is_configured(bench: Bench) -> None:
    first, second = bench.first.objects, bench.second.objects
    assert first.Producer_heartbeat_time == 50
    assert first.Consumer_heartbeat_time_1 == 0x007F0258
    assert second.Producer_heartbeat_time == 0
    assert bench.second.get_object((0x1401, 1)) == 0x283


@pytest.mark.parametrize("way", ["least", "greatest"])
def test_what_the_device_sends_comes_out_of_the_proxy(bench: Bench, way: str) -> None:
    sampler = importlib.import_module("lab.sampler")
    time = rtc.Time
    least = way == "least"
    samples = {
        1: (least, -4 if least else 3, 0 if least else 4095)
        + ((-(1 << 15), -0.5) if least else ((1 << 15) - 1, math.inf)),
        2: (0, -(1 << 23), -(1 << 29)) if least else (255, (1 << 23) - 1, 0.25),
        3: (-(1 << 47), "a") if least else ((1 << 47) - 1, "\u00e9z"),
    }
    for number, values in samples.items():
        made = getattr(sampler, f"Tpdo{number}")(time(), *values)
        getattr(bench.first, f"tpdo{number}").write(made)
    bench.run(0.1)
    for number, values in samples.items():
        came = bench.got(f"proxy.tpdo{number}")
        assert fields(came) == values
        at = came.tm.sec * SECOND + came.tm.nsec
        assert 0 < bench.system.time - at < 0.1 * SECOND


def test_a_link_needs_no_master(bench: Bench) -> None:
    tpdo = of("lab.sampler", "Tpdo2")
    for port in bench.second.in_ports.values():
        port.read_newest()
    bench.first.tpdo2.write(tpdo(Counter=1, Offset=-77, Distance=12.25))
    bench.run(0.1)
    assert bench.second.Offset_in.read_newest().data == -77
    assert bench.second.Distance_in.read_newest().data == 12.25


@pytest.mark.parametrize(
    "values", [(True, -4, 0, 0), (False, 3, 15, (1 << 56) - 1)], ids=["least", "most"]
)
def test_what_the_proxy_gets_comes_to_the_device(
    bench: Bench, values: tuple[Any, ...]
) -> None:
    rpdo = of("lab.sampler", "Rpdo1")
    bench.send("proxy.rpdo1", rpdo(rtc.Time(), *values))
    bench.run(0.1)
    assert fields(bench.first.rpdo1.read_newest()) == values
    assert bench.first.objects.Ticks_56 == values[-1]


def test_no_sample_is_lost_on_the_way(bench: Bench) -> None:
    rpdo = of("lab.sampler", "Rpdo1")
    while bench.first.rpdo1.is_new():
        bench.first.rpdo1.read()
    for count in range(8):
        bench.send("proxy.rpdo1", rpdo(Gear=0, Ticks_56=count))
    bench.run(0.1)
    came = []
    while bench.first.rpdo1.is_new():
        came.append(bench.first.rpdo1.read().Ticks_56)
    assert came == list(range(8))


def test_objects_from_the_device(bench: Bench) -> None:
    own = importlib.import_module("lab.samplerpieces")
    sent = {
        "Switch_2001_00_out": rtc.TimedBoolean(data=True),
        "Gear_out": rtc.TimedShort(data=-3),
        "Level_out": rtc.TimedUShort(data=4094),
        "Raw_value": rtc.TimedShort(data=-12345),
        "Scale_factor": rtc.TimedFloat(data=-0.25),
        "Position_48": own.TimedLongLong(data=-(1 << 40)),
        "Tag": rtc.TimedString(data="ok"),
        "Counter": rtc.TimedOctet(data=200),
    }
    for name, sample in sent.items():
        getattr(bench.second, name).write(sample)
    bench.run(0.1)
    for name, sample in sent.items():
        assert bench.got(f"pieces.{name}").data == sample.data, name


def test_objects_to_the_device(bench: Bench) -> None:
    own = importlib.import_module("lab.samplerpieces")
    bench.send("pieces.Level_in", rtc.TimedUShort(data=9))
    bench.send("pieces.Ticks_56", own.TimedULongLong(data=1 << 55))
    bench.run(0.1)
    assert bench.second.objects.Ticks_56 == 1 << 55
    assert bench.second.objects.Level == 9
    # The others have their defaults, or their previous values.
    assert bench.second.objects.Gear == -1
    bench.send("pieces.Gear_in", rtc.TimedShort(data=2))
    bench.run(0.1)
    assert bench.second.objects.Gear == 2
    assert bench.second.objects.Ticks_56 == 1 << 55


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("Switch_2001_00", (True, False)),
        ("Gear", (-4, 3)),
        ("Level", (0, 65535)),
        ("Ticks_56", (0, (1 << 56) - 1)),
        ("Offset", (-(1 << 23), (1 << 23) - 1)),
        ("Distance", (-(1 << 29), 0.25 * ((1 << 31) - 1))),
        ("Speed", (0.0, 100.0)),
        ("Scale_factor", (-1.5, math.inf)),
        ("Double_2040_00", (-1e300, 5e-324)),
        ("Label", ("", "a label that takes several segments", "\u5de6")),
        ("Title_wide_", ("", "\u5de6 \U0001f916")),
        ("Key", (b"\0", bytes(range(256)))),
        ("Program", (b"\1", bytes(5000))),
        ("class_2034_00", ("\0", "\u00ff")),
        ("Counter", (0, 255)),
    ],
)
def test_objects_by_sdo(bench: Bench, name: str, values: tuple[Any, ...]) -> None:
    for value in values:
        bench.call(f"set_{name}", value)
        assert bench.call(f"get_{name}") == value


def test_objects_by_name(bench: Bench) -> None:
    """Values as transferred: of the proxy itself, and by its service port."""
    table = of("lab.sampler", "SamplerObjects")
    consumer = bench.probe.add_consumer("objects", "objects", canopen.ObjectDictionary)
    bench.system.connect(("probe", "objects"), ("proxy", "sdo"))
    remote = over_service(table, consumer)
    for objects in (bench.proxy.objects, remote):
        for name, value in (
            ("Switch_2001_00", True),
            ("Gear", -4),
            ("Ticks_56", (1 << 56) - 1),
            ("Speed", 12_345),
            ("Scale_factor", -1.5),
            ("Title_wide_", "\u5de6 \U0001f916"),
            ("Key", bytes(range(256))),
            ("Time_of_day", 441_763_200_000_000_000),
        ):
            objects[name] = value
            assert objects[name] == value == getattr(objects, name)
        assert objects["Vendor_ID"] == bench.proxy.description.vendor_id
        with pytest.raises(KeyError, match="Sampler has no object 'Gears'"):
            objects["Gears"] = 1
        with pytest.raises(ValueError, match="u16"):
            objects.Level = "high"
        assert list(objects) == [o.name for o in bench.proxy.description.objects]
    assert bench.first.objects.Speed == 12_345
    remote.Gear = 3
    assert (bench.first.objects.Gear, bench.proxy.objects.Gear) == (3, 3)


@pytest.mark.parametrize(
    ("number", "kind", "member", "value"),
    [
        ((0x2001, 0), "BOOLEAN", "truth", True),
        ((0x2002, 0), "INTEGER", "number", -4),
        ((0x2012, 0), "UNSIGNED", "count", (1 << 56) - 1),
        ((0x2010, 2), "REAL", "real", -1.5),
        ((0x2031, 0), "TEXT", "text", "\u5de6 \U0001f916"),
        ((0x2032, 0), "OCTETS", "data", bytes(range(256))),
        ((0x2042, 0), "INTEGER", "number", 441_763_200_000_000_000),
    ],
)
def test_typed_values_by_number(
    bench: Bench, number: tuple[int, int], kind: str, member: str, value: object
) -> None:
    made = canopen.ObjectValue(canopen.ValueKind[f"VALUE_{kind}"], value)
    bench.call("set", *number, made)
    got = bench.call("get", *number)
    assert got == made
    assert getattr(got, member) == value


def test_typed_values_that_an_object_cannot_have(bench: Bench) -> None:
    value, kinds = canopen.ObjectValue, canopen.ValueKind
    aborted = canopen.SdoAbort
    with pytest.raises(aborted) as caught:
        bench.call("set", 0x2002, 0, value(kinds.VALUE_TEXT, "3"))
    assert caught.value.code == 0x06090030
    with pytest.raises(aborted) as caught:
        bench.call("set", 0x2002, 0, value(kinds.VALUE_UNSIGNED, 1 << 40))
    assert caught.value.code == 0x06090031


@pytest.mark.usefixtures("lab")
def test_the_service_answers_in_inactive_and_error() -> None:
    bench = Bench()
    name = bench.proxy.instance_name
    bench.system.deactivate(name)
    bench.run(1.0)
    assert bench.system.state(name) == INACTIVE_STATE
    vendor = bench.call("get_Vendor_ID")
    assert vendor == bench.proxy.description.vendor_id
    bench.system.context(name).fail_component(bench.proxy, "on purpose")
    bench.run(1.0)
    assert bench.system.state(name) == ERROR_STATE
    aborted = canopen.SdoAbort
    with pytest.raises(aborted) as refused:
        bench.call("get_Vendor_ID")
    assert refused.value.code == 0x08000022
    bench.system.close()


def test_times_by_sdo_and_pdo(bench: Bench) -> None:
    time = rtc.Time
    for sec, milliseconds in ((441_763_200, 0), (2**32 - 1, 999)):
        sent = time(sec, milliseconds * 1_000_000)
        bench.call("set_Time_of_day", sent)
        assert bench.call("get_Time_of_day") == sent
    receive = bench.proxy._receivers()[4]
    octets = bytes.fromhex("e8030000 0100 07")
    receive(octets, 5 * SECOND)
    assert fields(bench.got("proxy.tpdo4")) == (time(441_763_200 + 86_400 + 1, 0), 7)


@pytest.mark.parametrize(
    ("operation", "arguments", "code"),
    [
        ("set_Gear", (4,), 0x06090031),
        ("set_Gear", (-200,), 0x06090032),
        ("set_Speed", (100.001,), 0x06090031),
        ("set_Speed", (math.nan,), 0x06090030),
        ("read", (0x5FFF, 0), 0x06020000),
        ("read", (0x1018, 9), 0x06090011),
        ("write", (0x1018, 1, b"\0\0\0\0"), 0x06010002),
        ("write", (0x2020, 0, b"\0"), 0x06070013),
    ],
)
def test_what_cannot_be_is_an_abort(
    bench: Bench, operation: str, arguments: tuple[object, ...], code: int
) -> None:
    aborted = canopen.SdoAbort
    with pytest.raises(aborted) as caught:
        bench.call(operation, *arguments)
    assert f"{caught.value.code:08X}" == f"{code:08X}", caught.value.text


def test_any_object_by_its_octets(bench: Bench) -> None:
    bench.call("write", 0x2020, 0, bytes.fromhex("39300000"))
    assert bench.call("read", 0x2020, 0) == bytes.fromhex("39300000")
    assert bench.call("get_Speed") == 12.345
    assert bench.call("read", 0x1018, 1) == bytes.fromhex("01ffff00")


def test_parameters_are_written(bench: Bench) -> None:
    bench.proxy.configuration_sets.set("Speed", "2.5")
    bench.proxy.configuration_sets.set("Label", "a parameter")
    bench.run(0.2)
    assert bench.first.objects.Speed == 2500
    assert bench.first.objects.Label == "a parameter"


def test_values_that_no_field_has(bench: Bench) -> None:
    senders = bench.proxy._senders()
    sampler = importlib.import_module("lab.sampler")
    for number, sample in (
        (1, sampler.Rpdo1(Gear=4)),
        (1, sampler.Rpdo1(Level=16)),
        (2, sampler.Rpdo2(Distance=math.nan)),
        (2, sampler.Rpdo2(Distance=1e30)),
        (2, sampler.Rpdo2(Offset=1 << 23)),
    ):
        bench.send(f"proxy.rpdo{number}", sample)
        bench.send(f"proxy.rpdo{number}", type(sample)())
        with pytest.raises(PdoError):
            list(senders[number]())
        assert len(list(senders[number]())) == 1


def test_data_that_are_too_short(bench: Bench) -> None:
    for proxy in (bench.proxy, bench.pieces):
        for number, receive in proxy._receivers().items():
            with pytest.raises(PdoError, match=f"TPDO {number} has 1 octets"):
                receive(b"\0", 0)


@pytest.mark.usefixtures("lab")
def test_a_normal_end_is_quiet(caplog: pytest.LogCaptureFixture) -> None:
    """The manager, which was added first, ends before its proxies."""
    bench = Bench()
    caplog.clear()
    bench.system.close()
    assert caplog.messages == []


@pytest.mark.usefixtures("lab")
def test_a_tpdo_that_nobody_can_ask_for_is_named(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = of("mylab.sampler_device", "SamplerDevice")
    pdos = tuple(
        (
            replace(pdo, transmission_type=253, cob_id=0x40000180)
            if (pdo.direction, pdo.number) == ("tpdo", 1)
            else pdo
        )
        for pdo in device.description.pdos
    )
    described = replace(device.description, pdos=pdos)
    monkeypatch.setattr(device, "description", described)
    system = System()
    system.add(device("requested"))
    assert caplog.messages == [
        "requested: samples written to tpdo1 are never sent: its transmission type 253 waits "
        "for a remote frame, and its COB-ID allows none"
    ]
    system.close()
