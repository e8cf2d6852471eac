"""Random devices: generated code is in black's form, compiles, and carries all values."""

from __future__ import annotations

import importlib
import random
import string
import sys
from pathlib import Path
from typing import Any

import black
import pytest

from rtgen.cli import run
from rtgen.compiler.model.canopen import BITS, DataType
from rtgen.runtime import System

MODE = black.Mode(line_length=88, target_versions={black.TargetVersion.PY311})
TYPES = [*BITS, DataType.VISIBLE_STRING, DataType.OCTET_STRING, DataType.UNICODE_STRING]
NUMERIC = [t for t in BITS if t not in (1, 0xA0, 0x0C, 0x0D)]
LENGTHS = (1, 3, 8, 20, 60, 120)


class RandomDevice:
    """The texts of a device and of a bus file for it."""

    def __init__(self, seed: int, ports: str) -> None:
        self.random = random.Random(seed)
        self.sections: list[str] = []
        self.names: set[str] = set()
        self.factors: list[str] = []
        self._next = 0x2000
        self.mandatory()
        for direction, base in (("T", 0x1800), ("R", 0x1400)):
            for number in range(3):
                self.pdo(direction, base + number, self.fields())
        # A single field, and as many as possible.
        self.pdo("T", 0x1803, [(DataType.INTEGER32, 32)])
        self.pdo("R", 0x1403, [(DataType.INTEGER32, 32)])
        first = self._next
        self.pdo("T", 0x1804, [(DataType.BOOLEAN, 1)] * 64)
        self.pdo("R", 0x1404, [(DataType.BOOLEAN, 1)] * 64, first)
        self.eds = "\n".join(self.sections)
        factors = "\n".join(self.factors)
        self.bus = (
            f'[bus]\nbit_rate = 1000\n[device.it]\neds = "it.eds"\nports = "{ports}"\n'
            f'[device.it.factors]\n{factors}\n[node.it]\ndevice = "it"\nid = 5\n'
        )

    def section(self, name: str, **entries: object) -> None:
        self.sections.append(f"[{name}]")
        self.sections += [f"{key}={value}" for key, value in entries.items()]

    def variable(self, name: str, label: str, type_: int, **more: object) -> None:
        self.section(
            name,
            ParameterName=label,
            DataType=f"0x{type_:04X}",
            **({"AccessType": "rw"} | more),
        )

    def mandatory(self) -> None:
        self.section("DeviceInfo", Granularity=1)
        self.variable("1000", "Device type", 7)
        self.variable("1001", "Error register", 5)

    def fields(self) -> list[tuple[int, int]]:
        """Return types and lengths of fields that fit a PDO."""
        found: list[tuple[int, int]] = []
        room = 64
        while room and self.random.random() < 0.9:
            type_ = self.random.choice(TYPES)
            bits = BITS.get(type_) or 16
            if self.random.random() < 0.3 and type_ in NUMERIC[:8]:
                bits = self.random.randint(1, bits)
            if type_ in (DataType.REAL32, DataType.REAL64):
                bits = BITS[type_]
            if bits <= room and (type_ in BITS or room % 8 == 0):
                found.append((type_, bits))
                room -= bits
        return found or [(DataType.UNSIGNED8, 8)]

    def name(self) -> str:
        letters = string.ascii_letters + string.digits + " _-.()"
        length = self.random.choice(LENGTHS)
        while True:
            name = "".join(self.random.choice(letters) for _ in range(length)).strip()
            if name.strip(" _-.()") and name.lower() not in self.names:
                self.names.add(name.lower())
                return name

    def pdo(
        self,
        direction: str,
        index: int,
        fields: list[tuple[int, int]],
        known: int | None = None,
    ) -> None:
        """Map new objects, or those from an index on that are `known`."""
        number = index & 0x3FF
        title = f"{direction}PDO {number + 1}"
        self.section(f"{index:04X}", ParameterName=title, ObjectType=9, SubNumber=3)
        self.variable(f"{index:04X}sub0", "Highest", 5, DefaultValue=2)
        cob_id = f"0x{0x190 + 0x10 * number + 0x100 * (direction == 'R'):X}"
        self.variable(f"{index:04X}sub1", "COB-ID", 7, DefaultValue=cob_id)
        self.variable(f"{index:04X}sub2", "Type", 5, DefaultValue=255)
        mapping = index + 0x200
        count = len(fields)
        self.section(
            f"{mapping:04X}", ParameterName="Mapped", ObjectType=9, SubNumber=count + 1
        )
        self.variable(f"{mapping:04X}sub0", "Number", 5, DefaultValue=count)
        for subindex, (type_, bits) in enumerate(fields, 1):
            place = self._next if known is None else known + subindex - 1
            if known is None:
                self._next += 1
                self.variable(f"{place:04X}", self.name(), type_, PDOMapping=1)
            if known is None and type_ in NUMERIC and self.random.random() < 0.3:
                self.factors.append(f'"{place:04X}" = {self.random.uniform(-9, 9)!r}')
            entry = f"0x{place << 16 | bits:08X}"
            label = f"{mapping:04X}sub{subindex:X}"
            self.variable(label, f"Entry {subindex}", 7, DefaultValue=entry)


def make(folder: Path, seed: int, ports: str, package: str) -> None:
    device = RandomDevice(seed, ports)
    (folder / "it.eds").write_text(device.eds, encoding="utf-8")
    (folder / "it.toml").write_text(device.bus, encoding="utf-8")
    project = f'[sources]\npaths = ["it.toml"]\n[output]\npackage = "{package}"\n'
    (folder / "rtgen.toml").write_text(project, encoding="utf-8")
    assert run(["generate", "--no-cache", "--quiet", "--diagnostics", "json"]) == 0


@pytest.mark.sampled(1)
@pytest.mark.slow
@pytest.mark.parametrize("ports", ["pdo", "object"])
@pytest.mark.parametrize("seed", range(2))
def test_random_devices(
    seed: int, ports: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = f"random_{ports}_{seed}"
    monkeypatch.chdir(tmp_path)
    make(tmp_path, seed, ports, package)
    for path in (tmp_path / "generated" / package / "canopen").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert black.format_str(text, mode=MODE) == text, path
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    try:
        there_and_back(package)
    finally:
        for name in list(sys.modules):
            if name.partition(".")[0] == package:
                del sys.modules[name]


def there_and_back(package: str) -> None:
    """A proxy decodes what a device encodes, and the other way round."""
    device = importlib.import_module(f"{package}.components.it_device")
    codecs = importlib.import_module(f"{package}.components.it_proxy")
    proxy = codecs.ItProxy("it")
    description = proxy.description
    values: dict[tuple[int, int], Any] = {}
    written: dict[str, Any] = {}
    system = System()
    system.add(proxy)
    for name, port in proxy.out_ports.items():
        port._record = lambda sample, name=name: written.update({name: sample})
        port._rewire()
    assert set(proxy._receivers()) == set(range(1, 6))
    slave = device.ItSlave.__dict__
    outgoing = slave["_outgoing"](None)
    incoming = slave["_incoming"](None)
    for number, receive in proxy._receivers().items():
        pdo = description.pdo("tpdo", number)
        octets = sample_octets(pdo.mapping, description)
        written.clear()
        receive(octets, 7_000_000_001)
        values.clear()
        for name, sample in written.items():
            assert (sample.tm.sec, sample.tm.nsec) == (7, 1)
            outgoing[name](sample, values.__setitem__)
        fields = getattr(codecs, f"decode_tpdo{number}")(octets)
        compare(fields, pdo.mapping, values, description)
    assert set(incoming) == set(range(1, 6))


def sample_octets(mapping: tuple[tuple[int, int, int], ...], description: Any) -> bytes:
    """Return octets with small positive numbers: no NaN, no half characters, no odd times."""
    at = number = 0
    for index, subindex, bits in mapping:
        kind = description.by_number[index, subindex].kind
        if kind not in ("r32", "r64", "wstring", "time_of_day", "time_difference"):
            number |= (1 if bits > 1 or kind == "bool" else 0) << at
        at += bits
    return number.to_bytes((at + 7) // 8, "little")


def compare(
    fields: tuple[Any, ...],
    mapping: tuple[tuple[int, int, int], ...],
    values: dict[tuple[int, int], Any],
    description: Any,
) -> None:
    """Check that the object dictionary agrees with the codec on common values."""
    for field, (index, subindex, _) in zip(fields, mapping, strict=True):
        kind = description.by_number[index, subindex].kind
        value = values[index, subindex]
        if kind == "time_of_day":
            assert value == 441_763_200 * 10**9
        elif kind == "wstring":
            assert (field, value) == (b"\0\0", "")
        elif kind in ("r32", "r64"):
            assert value == pytest.approx(field)
        else:
            assert value == field
