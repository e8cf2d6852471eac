"""Writes device descriptions for tests: objects in, text of an EDS out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

WIDTHS = {
    0x01: 1,
    0x02: 8,
    0x03: 16,
    0x04: 32,
    0x05: 8,
    0x06: 16,
    0x07: 32,
    0x08: 32,
    0x0C: 48,
    0x10: 24,
    0x11: 64,
    0x15: 64,
    0x1B: 64,
    0xA0: 8,
}
"""Bits of data types by their code."""


@dataclass(frozen=True, slots=True)
class Thing:
    """An object: its name, the code of its data type, its access, and whether it is mappable."""

    name: str
    type: int = 0x06
    access: str = "rw"
    mappable: bool = True
    default: str = "0"


def eds(
    things: Sequence[Thing],
    tpdos: Mapping[int, Sequence[int]] | None = None,
    rpdos: Mapping[int, Sequence[int]] | None = None,
    first: int = 0x2000,
) -> str:
    """Return the text, with objects numbered from `first` on; a PDO is a list of mapped entries."""
    objects = {first + place: thing for place, thing in enumerate(things)}
    manufacturer = [f"0x{index:04X}" for index in objects]
    pdos = [
        (base + number - 1, entries)
        for base, pdos_of in ((0x1800, tpdos or {}), (0x1400, rpdos or {}))
        for number, entries in sorted(pdos_of.items())
    ]
    optional = [f"0x{index + step:04X}" for index, _ in pdos for step in (0, 0x200)]
    mandatory = ["0x1000", "0x1001", "0x1018"]
    text = "[FileInfo]\nFileName=made.eds\nEDSVersion=4.0\n"
    text += "[DeviceInfo]\nVendorName=rtgen\nProductName=Odd\nGranularity=1\n"
    text += f"NrOfRXPDO={len(rpdos or {})}\nNrOfTXPDO={len(tpdos or {})}\n"
    text += "[DummyUsage]\n"
    text += "".join(f"Dummy000{code}=1\n" for code in range(1, 8))
    for title, numbers in (
        ("MandatoryObjects", mandatory),
        ("OptionalObjects", optional),
        ("ManufacturerObjects", manufacturer),
    ):
        text += f"[{title}]\nSupportedObjects={len(numbers)}\n"
        text += "".join(f"{place}={n}\n" for place, n in enumerate(numbers, 1))
    text += _variable("1000", Thing("Device type", 0x07, "ro", False))
    text += _variable("1001", Thing("Error register", 0x05, "ro", False))
    text += _record("1018", "Identity", [Thing("Vendor-ID", 0x07, "ro", False, "1")])
    for index, thing in objects.items():
        text += _variable(f"{index:04X}", thing)
    for index, entries in pdos:
        number, first_one = index & 0x1FF, 0x180 if index >= 0x1800 else 0x200
        identifier = first_one + 0x100 * number if number < 4 else 0x80000000
        communication = [
            Thing("COB-ID", 0x07, "rw", False, f"$NODEID+0x{identifier:X}"),
            Thing("Transmission type", 0x05, "rw", False, "255"),
        ]
        text += _record(f"{index:04X}", "PDO parameter", communication)
        mapped = [Thing("Entry", 0x07, "rw", False, f"0x{e:08X}") for e in entries]
        text += _record(f"{index + 0x200:04X}", "PDO mapping", mapped)
    return text


def entry(index: int, bits: int, subindex: int = 0) -> int:
    """Return an entry of a mapping."""
    return index << 16 | subindex << 8 | bits


def _variable(section: str, thing: Thing) -> str:
    return (
        f"[{section}]\nParameterName={thing.name}\nObjectType=7\n"
        f"DataType=0x{thing.type:04X}\nAccessType={thing.access}\n"
        f"DefaultValue={thing.default}\nPDOMapping={int(thing.mappable)}\n"
    )


def _record(index: str, name: str, things: Sequence[Thing]) -> str:
    text = (
        f"[{index}]\nParameterName={name}\nObjectType=9\nSubNumber={len(things) + 1}\n"
    )
    count = Thing("Number of entries", 0x05, "rw", False, str(len(things)))
    for place, thing in enumerate((count, *things)):
        text += _variable(f"{index}sub{place:X}", thing)
    return text
