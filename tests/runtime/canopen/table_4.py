"""An EDS with an object of every data type, for SDO and in PDOs both ways, and its components."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from rtgen.runtime import (
    ACTIVE_STATE,
    RTC_OK,
    SECOND,
    Clock,
    Component,
    RealClock,
    ReturnCode_t,
    SampleRecord,
    System,
)
from rtgen.runtime.canopen.port_samples import unread
from rtgen.runtime.library.rtc import Time

PACKAGE = "every_type"
Values = tuple[Any, ...]


def _signed(bits: int) -> Values:
    return (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1, -1, 0, 1)


def _unsigned(bits: int) -> Values:
    return (0, 2**bits - 1, 1, 2 ** (bits - 1))


@dataclass(frozen=True)
class Kind:
    """A data type: its code, its bits in a PDO, and its extreme values."""

    name: str
    code: int
    bits: int
    values: Values


_DAYS_1984 = 5113
_LARGEST_32 = (2 - 2**-23) * 2.0**127
KINDS = (
    Kind("BOOLEAN", 0x01, 1, (False, True)),
    Kind("UNSIGNED8", 0x05, 8, _unsigned(8)),
    Kind("VISIBLE_CHAR", 0xA0, 8, ("\0", "\xff", "A")),
    Kind("INTEGER16", 0x03, 16, _signed(16)),
    Kind("UNSIGNED16", 0x06, 16, _unsigned(16)),
    Kind("INTEGER32", 0x04, 32, _signed(32)),
    Kind("UNSIGNED32", 0x07, 32, _unsigned(32)),
    Kind(
        "REAL32",
        0x08,
        32,
        (0.0, -0.0, 1.5, _LARGEST_32, -_LARGEST_32, 2.0**-149, math.inf),
    ),
    Kind("INTEGER8", 0x02, 8, _signed(8)),
    Kind("INTEGER24", 0x10, 24, _signed(24)),
    Kind("REAL64", 0x11, 64, (0.0, -1.5, 1.7976931348623157e308, 5e-324, -math.inf)),
    Kind("UNSIGNED64", 0x1B, 64, _unsigned(64)),
    Kind("INTEGER64", 0x15, 64, _signed(64)),
    Kind("INTEGER40", 0x12, 40, _signed(40)),
    Kind("UNSIGNED24", 0x16, 24, _unsigned(24)),
    Kind("INTEGER48", 0x13, 48, _signed(48)),
    Kind("INTEGER56", 0x14, 56, _signed(56)),
    Kind("UNSIGNED40", 0x18, 40, _unsigned(40)),
    Kind("UNSIGNED48", 0x19, 48, _unsigned(48)),
    Kind("UNSIGNED56", 0x1A, 56, _unsigned(56)),
    Kind("VISIBLE_STRING", 0x09, 64, ("", "12345678", "gr\xfc\xdf")),
    Kind("UNICODE_STRING", 0x0B, 64, ("", "\u20ac\xfcab", "\U0001f916")),
    Kind("OCTET_STRING", 0x0A, 64, (bytes(8), bytes(range(248, 256)))),
    Kind("TIME_OF_DAY", 0x0C, 48, ()),
    Kind("TIME_DIFFERENCE", 0x0D, 48, ()),
    Kind("DOMAIN", 0x0F, 0, (b"", b"\0", bytes(range(256)) * 20)),
)
"""Table 4 with extensions. Times are checked by their members."""
GROUPS = (
    ("BOOLEAN", "UNSIGNED8", "VISIBLE_CHAR", "INTEGER16", "UNSIGNED16"),
    ("INTEGER32", "UNSIGNED32"),
    ("REAL32", "INTEGER8", "INTEGER24"),
    ("REAL64",),
    ("UNSIGNED64",),
    ("INTEGER64",),
    ("INTEGER40", "UNSIGNED24"),
    ("INTEGER48",),
    ("INTEGER56",),
    ("UNSIGNED40",),
    ("UNSIGNED48",),
    ("UNSIGNED56",),
    ("VISIBLE_STRING",),
    ("UNICODE_STRING",),
    ("OCTET_STRING",),
    ("TIME_OF_DAY",),
    ("TIME_DIFFERENCE",),
)
"""The content of each PDO, the first one as TPDO 1 and RPDO 1."""
BY_NAME = {kind.name: kind for kind in KINDS}
_TIMES = {
    # Seconds since 1970; the first possible day is in 1984. RTC::Time ends before the types do.
    "TIME_OF_DAY": ((_DAYS_1984 * 86400, 0), (2**32 - 1, 999000000)),
    "TIME_DIFFERENCE": ((0, 0), (2**32 - 1, 999000000)),
}  # fmt: skip


def eds() -> str:
    """Return the file. Objects 2000h.. are for RPDOs, 2100h.. for TPDOs, 2200h.. for SDO."""
    objects: dict[int, list[str]] = {
        0x1000: _variable("Device type", 7, "ro", "0x00000000"),
        0x1001: _variable("Error register", 5, "ro", "0"),
        0x1014: _variable("COB-ID EMCY", 7, "ro", "$NODEID+0x80"),
        0x1017: _variable("Producer heartbeat time", 6, "rw", "100"),
        0x1018: ["ParameterName=Identity", "ObjectType=0x9", "SubNumber=3"],
    }
    subs: dict[tuple[int, int], list[str]] = {
        (0x1018, 0): _variable("Number of entries", 5, "ro", "2"),
        (0x1018, 1): _variable("Vendor", 7, "ro", "0x12345"),
        (0x1018, 2): _variable("Product", 7, "ro", "4"),
    }
    for place, kind in enumerate(KINDS):
        mapped = bool(kind.bits)
        objects[0x2000 + place] = _variable(
            f"{kind.name} in", kind.code, "rw", "", mapped
        )
        objects[0x2100 + place] = _variable(
            f"{kind.name} out", kind.code, "ro", "", mapped
        )
        objects[0x2200 + place] = _variable(f"{kind.name} sdo", kind.code, "rw", "")
    for number, group in enumerate(GROUPS, 1):
        for base, variables, cob_id in (
            (0x1400, 0x2000, 0x310), (0x1800, 0x2100, 0x390),
        ):  # fmt: skip
            _pdo(objects, subs, base + number - 1, variables, cob_id + number, group)
    mandatory = [0x1000, 0x1001, 0x1018]
    manufacturer = [index for index in objects if index >= 0x2000]
    optional = [i for i in objects if i < 0x2000 and i not in mandatory]
    text = [
        "[FileInfo]", "FileName=table_4.eds", "FileVersion=1", "FileRevision=1",
        "EDSVersion=4.0", "", "[DeviceInfo]", "VendorName=rtgen", "VendorNumber=0x12345",
        "ProductName=Every data type", "ProductNumber=4", "RevisionNumber=1",
        "OrderCode=", "BaudRate_500=1", "SimpleBootUpSlave=1", "Granularity=1",
        f"NrOfRXPDO={len(GROUPS)}", f"NrOfTXPDO={len(GROUPS)}", "LSS_Supported=0", "",
    ]  # fmt: skip
    for section, indices in (
        ("MandatoryObjects", mandatory), ("OptionalObjects", sorted(optional)),
        ("ManufacturerObjects", manufacturer),
    ):  # fmt: skip
        text += [f"[{section}]", f"SupportedObjects={len(indices)}"]
        text += [f"{n}=0x{index:04X}" for n, index in enumerate(indices, 1)] + [""]
    for index in sorted(objects):
        text += [f"[{index:04X}]", *objects[index], ""]
        for (owner, sub), lines in sorted(subs.items()):
            if owner == index:
                text += [f"[{index:04X}sub{sub:X}]", *lines, ""]
    return "\n".join(text)


def _variable(
    name: str, code: int, access: str, default: str, mapped: bool = False
) -> list[str]:
    lines = [f"ParameterName={name}", "ObjectType=0x7", f"DataType=0x{code:04X}"]
    lines += [f"AccessType={access}"]
    lines += [f"DefaultValue={default}"] if default else []
    return [*lines, f"PDOMapping={int(mapped)}"]


def _pdo(
    objects: dict[int, list[str]],
    subs: dict[tuple[int, int], list[str]],
    index: int,
    variables: int,
    cob_id: int,
    group: tuple[str, ...],
) -> None:
    parameters, mapping = index, index + 0x200
    what = "RPDO" if index < 0x1800 else "TPDO"
    number = (index & 0x1FF) + 1
    objects[parameters] = [
        f"ParameterName={what} {number}",
        "ObjectType=0x9",
        "SubNumber=3",
    ]
    subs[parameters, 0] = _variable("Highest sub-index", 5, "ro", "2")
    subs[parameters, 1] = _variable("COB-ID", 7, "rw", f"0x{cob_id:X}")
    subs[parameters, 2] = _variable("Transmission type", 5, "rw", "255")
    objects[mapping] = [
        f"ParameterName={what} mapping {number}", "ObjectType=0x9", f"SubNumber={len(group) + 1}",
    ]  # fmt: skip
    subs[mapping, 0] = _variable("Number of entries", 5, "rw", str(len(group)))
    for sub, name in enumerate(group, 1):
        kind = BY_NAME[name]
        place = variables + KINDS.index(kind)
        value = f"0x{place << 16 | kind.bits:08X}"
        subs[mapping, sub] = _variable(f"Entry {sub}", 7, "rw", value)


def rounds(number: int, struct: type[Any], time: type[Any]) -> Iterator[Any]:
    """Yield samples for a PDO, in which every field has each of its values."""
    lists = [values(name, time) for name in GROUPS[number - 1]]
    for n in range(max(map(len, lists))):
        yield struct(time(), *(found[n % len(found)] for found in lists))


def values(name: str, time: type[Any]) -> Values:
    """Return the values of a data type, as generated code has them."""
    if name in _TIMES:
        return tuple(time(*fields) for fields in _TIMES[name])
    return BY_NAME[name].values


def content(sample: Any) -> list[Any]:
    """Return the members of a sample except its time stamp."""
    return [getattr(sample, name) for name in type(sample).__match_args__][1:]


def generate(folder: Path) -> Path:
    """Generate the components of the file; return the folder to import `PACKAGE` from."""
    (folder / "table_4.eds").write_text(eds(), encoding="latin-1")
    operations = ", ".join(f'"{0x2200 + n:04X}"' for n in range(len(KINDS)))
    bus = (
        "[bus]\nbit_rate = 500\n[device.table4]\neds = 'table_4.eds'\n"
        f"operations = [{operations}]\n[node.only]\ndevice = 'table4'\nid = 1\n"
    )
    (folder / "every_type.toml").write_text(bus, encoding="utf-8")
    project = f'[sources]\npaths = ["."]\n[output]\npackage = "{PACKAGE}"\n'
    (folder / "rtgen.toml").write_text(project, encoding="utf-8")
    command = [sys.executable, "-m", "rtgen", "generate", "--quiet"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "generated"


def proxy(name: str) -> Any:
    """Return the generated proxy, as a component of that name."""
    return import_module(f"{PACKAGE}.components.table4_proxy").Table4Proxy(name)


def device(name: str) -> Any:
    """Return the generated device, as a component of that name; it sends back what it receives."""
    base = import_module(f"{PACKAGE}.components.table4_device").Table4DeviceBase

    class Echo(base):  # type: ignore[misc]
        def __init__(self, name: str) -> None:
            super().__init__(name)
            self.calls: list[str] = []

        def on_activated(self, ec_id: int) -> ReturnCode_t:
            self.calls.append("on_activated")
            return RTC_OK

        def on_deactivated(self, ec_id: int) -> ReturnCode_t:
            self.calls.append("on_deactivated")
            return RTC_OK

        def on_aborting(self, ec_id: int) -> ReturnCode_t:
            self.calls.append("on_aborting")
            return RTC_OK

        def on_reset(self, ec_id: int) -> ReturnCode_t:
            self.calls.append("on_reset")
            return RTC_OK

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            for number in range(1, len(GROUPS) + 1):
                port = self.in_ports[f"rpdo{number}"]
                out = self.out_ports[f"tpdo{number}"]
                for sample in unread(port):
                    out.write(out.type(sample.tm, *content(sample)))
            return RTC_OK

    return Echo(name)


def configured(component: Any, settings: Mapping[str, object]) -> Any:
    """Return the component with these parameters, without a network to operate."""
    component.configuration_sets.set("network", "")
    for name, value in settings.items():
        component.configuration_sets.set(name, str(value))
    return component


class Source(Component):
    """A component with an OutPort for each InPort of a proxy."""

    def __init__(self, target: Component) -> None:
        super().__init__("Source0")
        for name, port in target.in_ports.items():
            self.add_out_port(name, port.type)


class Exchange:
    """A proxy in a system, with its input and its output."""

    def __init__(self, clock: Clock, settings: Mapping[str, object]) -> None:
        self.system = System(clock, check_values="always")
        self.proxy = configured(proxy("Proxy0"), settings)
        self.system.add(self.proxy, 200.0)
        self.source = Source(self.proxy)
        self.system.add(self.source)
        for name in self.proxy.in_ports:
            ends = ("Source0", name), ("Proxy0", name)
            self.system.connect(*ends, {"dataport.buffer.length": "64"})
        self.got: dict[str, list[list[Any]]] = {}
        self.system.add_listener(self._note)

    def __enter__(self) -> Exchange:
        return self

    def __exit__(self, *exception: object) -> None:
        self.system.close()

    def _note(self, record: object) -> None:
        if isinstance(record, SampleRecord) and record.instance == "Proxy0":
            self.got.setdefault(record.port, []).append(content(record.value))

    def activate(self) -> None:
        self.system.activate("Proxy0")
        limit = self.system.time + 20 * SECOND
        self.system.run(limit, until=lambda s: s.state("Proxy0") is ACTIVE_STATE)
        assert self.system.state("Proxy0") is ACTIVE_STATE, self.proxy.reason

    def pdos(self) -> Iterator[tuple[int, list[Any], list[Any]]]:
        """Send every value in every PDO; yield number, sent values, and returned values."""
        # The device's samples on becoming OPERATIONAL.
        limit = self.system.time + 60 * SECOND
        self.system.run(limit, until=lambda _: len(self.got) == len(GROUPS))
        self.got.clear()
        for number in range(1, len(GROUPS) + 1):
            port = self.source.out_ports[f"rpdo{number}"]
            samples = list(rounds(number, port.type, Time))
            for sample in samples:
                port.write(sample)
            sent = [content(sample) for sample in samples]
            name = f"tpdo{number}"
            limit = self.system.time + 60 * SECOND
            self.system.run(
                limit,
                until=lambda s: len(self.got.get(name, ())) >= len(sent),  # noqa: B023
            )
            yield number, sent, self.got.get(name, [])

    def objects(self) -> Iterator[tuple[str, list[Any], list[Any]]]:
        """Write and read every value by the typed operations of the SDO service."""
        consumer = self.source.add_consumer("sdo", "sdo", self._interface())
        self.system.connect(("Source0", "sdo"), ("Proxy0", "sdo"))
        service = consumer.object
        for kind in KINDS:
            name, wanted, got = kind.name, [*values(kind.name, Time)], []
            for value in wanted:
                getattr(service, f"set_{name}_sdo")(value)
                got.append(getattr(service, f"get_{name}_sdo")())
            yield name, wanted, got

    @staticmethod
    def _interface() -> Any:
        return import_module(f"{PACKAGE}.table4").ObjectAccess


def serve(settings: Mapping[str, object]) -> None:
    """Run the process of a device: print `ready`, then execute commands until the input ends.

    It answers each line with its state and its callbacks.
    """
    with System(RealClock(), check_values="always") as system:
        component = configured(device("Device0"), settings)
        system.add(component, 200.0)
        system.run(1)
        print("ready", flush=True)
        for line in sys.stdin:
            match line.strip():
                case "fail":
                    system.context("Device0").fail_component(component, "on purpose")
                case "state":
                    state, calls = system.state("Device0"), list(component.calls)
                    del component.calls[: len(calls)]
                    print(state.name, *calls, flush=True)
                case verb:
                    getattr(system, verb)("Device0")


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    serve(dict(pair.split("=", 1) for pair in sys.argv[2:]))
