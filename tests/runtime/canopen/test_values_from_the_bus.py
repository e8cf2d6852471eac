"""Values of all data types that stations on the bus may send: a port can have them, or refuses.

A refused one is counted and reported, and no component leaves ACTIVE. Fields have the length of
their type or a longer one; ports are those of PDOs, or of objects with factors.
"""

from __future__ import annotations

import logging
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from random import Random

import pytest
from seeds import cases
from stations import Recorder
from table_4 import BY_NAME, KINDS, Kind, Source, configured

from rtgen.runtime import (
    ACTIVE_STATE,
    RTC_OK,
    SECOND,
    ReturnCode_t,
    SampleRecord,
    System,
)
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.port_samples import unread
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.library.canopen import SdoAbort

PACKAGE = "values_from_the_bus"
Field = tuple[Kind, int]
_FIXED = ("BOOLEAN", "VISIBLE_CHAR", "REAL32", "REAL64")
"""Types that no codec has in another length than theirs."""
_TEXTS = ("VISIBLE_STRING", "UNICODE_STRING", "OCTET_STRING")
PDOS: list[tuple[Field, ...]] = [
    *(((kind, kind.bits),) for kind in KINDS if kind.bits),
    *(((kind, 64),) for kind in KINDS if 0 < kind.bits < 64 and kind.name not in _FIXED),
    *(((kind, 24),) for kind in KINDS if kind.name in _TEXTS),
    ((BY_NAME["UNSIGNED8"], 8), (BY_NAME["TIME_DIFFERENCE"], 48)),
    ((BY_NAME["UNSIGNED8"], 16), (BY_NAME["INTEGER8"], 12), (BY_NAME["UNSIGNED16"], 20)),
]  # fmt: skip
"""The fields of each PDO, the first one as TPDO 1 and RPDO 1."""
RPDO, TPDO = 0x310, 0x390
RECEIVED, SENT = 0x2000, 0x3000
SCALED = [
    *("INTEGER8", "INTEGER16", "INTEGER24", "INTEGER32", "INTEGER40", "INTEGER48"),
    *(
        "UNSIGNED8",
        "UNSIGNED16",
        "UNSIGNED24",
        "UNSIGNED32",
        "UNSIGNED40",
        "UNSIGNED48",
    ),
    *("REAL32", "REAL64"),
]
"""Types with a factor; a `double` does not have all numbers of more than 53 bits."""


def objects(number: int, first: int) -> list[int]:
    """Return the indices of the objects of a PDO."""
    return [first + 4 * number + place for place in range(len(PDOS[number - 1]))]


def variable(section: str, type_: int, default: str, access: str = "rw") -> str:
    return (
        f"[{section}]\nParameterName=O{section}\nObjectType=7\nDataType={type_}\n"
        f"AccessType={access}\nDefaultValue={default}\nPDOMapping=1\n"
    )


def eds() -> str:
    parts = [
        "[FileInfo]\nFileName=v.eds\nEDSVersion=4.0\n[DeviceInfo]\nVendorName=v\n"
        "VendorNumber=1\nProductName=p\nProductNumber=2\nBaudRate_500=1\nGranularity=1\n"
        f"NrOfRXPDO={len(PDOS)}\nNrOfTXPDO={len(PDOS)}\n",
        variable("1000", 7, "0", "ro"), variable("1001", 5, "0", "ro"),
        "[1018]\nParameterName=I\nObjectType=9\nSubNumber=2\n",
        variable("1018sub0", 5, "1", "const"), variable("1018sub1", 7, "1", "ro"),
        variable("1017", 6, "100"),
    ]  # fmt: skip
    for number, fields in enumerate(PDOS, 1):
        for base, cob_id, first in ((0x1400, RPDO, RECEIVED), (0x1800, TPDO, SENT)):
            index = base + number - 1
            parts += [
                f"[{index:04X}]\nParameterName=P\nObjectType=9\nSubNumber=3\n",
                variable(f"{index:04X}sub0", 5, "2", "const"),
                variable(f"{index:04X}sub1", 7, str(cob_id + number)),
                variable(f"{index:04X}sub2", 5, "255"),
                f"[{index + 0x200:04X}]\nParameterName=M\nObjectType=9\n",
                f"SubNumber={len(fields) + 1}\n",
                variable(f"{index + 0x200:04X}sub0", 5, str(len(fields))),
            ]
            access = "rw" if first == RECEIVED else "ro"
            places = zip(objects(number, first), fields, strict=True)
            for place, (thing, (kind, bits)) in enumerate(places, 1):
                entry = f"{index + 0x200:04X}sub{place:X}"
                parts.append(variable(entry, 7, f"0x{thing << 16 | bits:X}"))
                parts.append(variable(f"{thing:04X}", kind.code, "", access))
    return "".join(parts)


def bus(name: str, settings: str) -> str:
    return (
        f"[bus]\nbit_rate = 500\n[device.d]\neds = 'v.eds'\nname = '{name}'\n{settings}\n"
        "[node.only]\ndevice = 'd'\nid = 5\n"
    )


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp(PACKAGE)
    (folder / "v.eds").write_text(eds(), encoding="ascii")
    operations = [
        f'"{index:04X}"'
        for number in range(1, len(PDOS) + 1)
        for index in objects(number, RECEIVED)
    ]
    (folder / "plain.toml").write_text(
        bus("Plain", f"operations = [{', '.join(operations)}]")
    )
    factors = [
        f'"{thing:04X}" = 0.5'
        for number, fields in enumerate(PDOS, 1)
        for first in (RECEIVED, SENT)
        for thing, (kind, _) in zip(objects(number, first), fields, strict=True)
        if kind.name in SCALED
    ]
    text = "ports = 'object'\n[device.d.factors]\n" + "\n".join(factors)
    (folder / "single.toml").write_text(bus("Single", text))
    project = f'[sources]\npaths = ["."]\n[output]\npackage = "{PACKAGE}"\n'
    (folder / "rtgen.toml").write_text(project)
    command = [sys.executable, "-m", "rtgen", "generate", "--quiet"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    sys.path.insert(0, str(folder / "generated"))
    yield folder
    sys.path.remove(str(folder / "generated"))


def data_of(number: int, chance: Random) -> list[bytes]:
    """Return data of a PDO: extreme ones, texts with zeros and half characters, random ones."""
    size = (sum(bits for _, bits in PDOS[number - 1]) + 7) // 8
    patterns = (
        b"\0", b"\xff", b"\xaa", b"\x80", b"\1", b"a\0b", b"\0a", b"\xc3\xa9", b"\xe9",
        b"\x00\xd8", b"a\0\0\0\0\xd8", b"\xff\xff\xff\x0f\0\0", b"\0\0\0\0\xff\xff",
        b"\xff\xff\xff\xff\x35\xae", b"\0\0\0\0\x36\xae",
    )  # fmt: skip
    found = [(pattern * 8)[:size] for pattern in patterns]
    found += [b"\xff" * k + bytes(size - k) for k in range(1, size)]
    found += [bytes(k) + b"\xff" * (size - k) for k in range(1, size)]
    return [*found, *(chance.randbytes(size) for _ in range(4))]


def may_be_refused(number: int) -> bool:
    """Return whether a PDO has values that no port can have."""
    return any(
        bits > kind.bits or kind.name == "UNICODE_STRING" or "TIME" in kind.name
        for kind, bits in PDOS[number - 1]
    )


class Run:
    """A proxy and a device that sends back what it receives; all values are checked."""

    def __init__(self, name: str) -> None:
        self.system = System(check_values="always")
        modules = f"{PACKAGE}.components.{name.lower()}"
        proxies = import_module(f"{modules}_proxy")
        bases = import_module(f"{modules}_device")
        self.proxy = configured(
            getattr(proxies, f"{name}Proxy")("Proxy0"), {"node_id": 5, "master": True}
        )

        class Echo(getattr(bases, f"{name}DeviceBase")):  # type: ignore[misc]
            def on_execute(self, ec_id: int) -> ReturnCode_t:
                for name, port in self.in_ports.items():
                    out = self.out_ports[_answering(name)]
                    for sample in unread(port):
                        members = [
                            getattr(sample, m) for m in type(sample).__match_args__
                        ]
                        out.write(out.type(*members))
                return RTC_OK

        self.device = configured(Echo("Device0"), {"node_id": 5})
        self.system.add(self.proxy, 1000.0)
        self.system.add(self.device, 1000.0)
        assert self.system.clock.network is not None
        self.link = simulated_bus(self.system.clock.network, "can0")
        self.station = Recorder()
        self.arrived: dict[tuple[str, str], int] = {}
        self.system.add_listener(self._note)
        self.system.activate("Proxy0")
        limit = self.system.time + 20 * SECOND
        self.system.run(limit, until=lambda s: s.state("Proxy0") is ACTIVE_STATE)
        self.link.attach(self.station)

    def _note(self, record: object) -> None:
        if isinstance(record, SampleRecord):
            key = record.instance, record.port
            self.arrived[key] = self.arrived.get(key, 0) + 1

    def send(self, cob_id: int, data: bytes) -> None:
        self.link.send([Frame(cob_id, data)], self.station)
        self.system.run(self.system.time + 3_000_000)

    def refused(self) -> tuple[float, float]:
        """Return the numbers of values that proxy and device have refused."""
        found = (each.observables["refused"]() for each in (self.proxy, self.device))
        return tuple(sum(each) for each in found)  # type: ignore[return-value]

    def check(self) -> None:
        assert self.system.state("Proxy0") is ACTIVE_STATE, self.proxy.reason
        assert self.system.state("Device0") is ACTIVE_STATE, self.device.reason


def _answering(name: str) -> str:
    """Return the OutPort for an InPort: `tpdo1` for `rpdo1`, `O3004` for `O2004`."""
    if name.startswith("rpdo"):
        return name.replace("rpdo", "tpdo")
    return re.sub("^O2", "O3", name)


@pytest.mark.sampled(0)
@pytest.mark.random
@pytest.mark.parametrize("name", ["Plain", "Single"])
def test_pdos_of_any_octets(
    generated: Path, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "rtgen.runtime")
    run = Run(name)
    chance = Random(cases(1)[0])
    delivered = refused = 0
    for number in range(1, len(PDOS) + 1):
        own = objects(number, SENT)
        port = f"tpdo{number}" if name == "Plain" else f"O{own[-1]:04X}"
        assert port in run.proxy.out_ports
        for data in data_of(number, chance):
            before, count = run.arrived.get(("Proxy0", port), 0), run.refused()[0]
            caplog.clear()
            run.send(TPDO + number, data)
            run.check()
            arrived = run.arrived.get(("Proxy0", port), 0) - before
            dropped = run.refused()[0] - count
            assert arrived + dropped == 1, (PDOS[number - 1], data)
            assert not dropped or may_be_refused(number), (PDOS[number - 1], data)
            delivered, refused = delivered + arrived, refused + dropped
            run.send(RPDO + number, data)
            run.check()
    assert delivered > refused > 0
    assert run.refused()[1] > 0
    assert run.system.statistics("Device0").lost == 0


def test_a_refused_value_is_reported_until_a_good_one(
    generated: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "rtgen.runtime")
    [number] = [
        n for n, f in enumerate(PDOS, 1) if f == ((BY_NAME["TIME_OF_DAY"], 48),)
    ]
    run = Run("Plain")
    late, good = b"\0\0\0\0\xff\xff", b"\0\0\0\0\0\0"
    for data, reports in ((late, 1), (late, 0), (good, 0), (late, 1)):
        for cob_id, who in (
            (TPDO, f"Proxy0: tpdo{number}: O{objects(number, SENT)[0]:04X}"),
            (RPDO, f"Device0: rpdo{number}: O{objects(number, RECEIVED)[0]:04X}"),
        ):
            caplog.clear()
            run.send(cob_id + number, data)
            range_ = "RTC::Time has 0 to 4294967295 s"
            wanted = f"{who} is 6103987200 s; {range_}: it is ignored"
            assert [
                r.getMessage() for r in caplog.records if r.getMessage().startswith(who)
            ] == [wanted] * reports
    assert run.refused() == (3, 3)
    run.check()


@pytest.mark.random
def test_objects_of_any_octets(generated: Path) -> None:
    run = Run("Plain")
    source = Source(run.proxy)
    run.system.add(source)
    interface = import_module(f"{PACKAGE}.plain").ObjectAccess
    consumer = source.add_consumer("sdo", "sdo", interface)
    run.system.connect(("Source0", "sdo"), ("Proxy0", "sdo"))
    chance = Random(cases(1)[0])
    answered = 0
    for number, fields in enumerate(PDOS, 1):
        for index, (kind, _) in zip(objects(number, RECEIVED), fields, strict=True):
            for data in data_of(number, chance):
                octets = (data * 8)[: (kind.bits + 7) // 8]
                run.device.node.dictionary.put((index, 0), octets)
                for call in (
                    getattr(consumer.object, f"get_O{index:04X}"),
                    lambda: consumer.object.get(index, 0),  # noqa: B023
                ):
                    try:
                        call()
                        answered += 1
                    except SdoAbort:
                        assert "TIME" in kind.name or kind.name == "UNICODE_STRING"
    assert answered > 1000
    run.check()
