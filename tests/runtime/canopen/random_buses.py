"""Random descriptions of devices and bus files, mostly with values that a node can have."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from random import Random

_COB_FLAGS = (0, 0, 0, 0x80000000, 0x40000000)
_FREE = (0x190, 0x1F0, 0x2A5, 0x33C, 0x4C0, 0x555, *range(0x680, 0x6E0))
"""Identifiers that CiA 301 does not restrict."""
_EXTENDED = 0x20000000
Writes = dict[str, object]
"""Values of a bus file by their numbers."""
_UNREADABLE = "CAN-ID: 80h + Node-ID"
_MAPPABLE = 0x2000
_OBJECTS = 8


class Identifiers:
    """CAN identifiers, each of which is given once."""

    def __init__(self, chance: Random) -> None:
        self._chance = chance
        self._left = chance.sample(_FREE, len(_FREE))

    def next(self) -> int:
        """Return a COB-ID: an identifier of 11 bits, seldom one of 29."""
        identifier = self._left.pop()
        extended = self._chance.random() < 0.1
        return _EXTENDED | identifier << 12 if extended else identifier


class RandomDevice:
    """The text of an EDS or DCF, and what can be written: alternatives for each part."""

    def __init__(self, chance: Random, identifiers: Identifiers) -> None:
        self._chance = chance
        self._identifiers = identifiers
        self._text: list[str] = []
        self.writable: list[tuple[Writes, ...]] = []
        self.mappings: list[tuple[Writes, ...]] = []
        """Mappings to write, which the nodes of a kind have in common."""
        self._mappable = [chance.random() < 0.95 for _ in range(2 * _OBJECTS)]
        self.tpdos: list[int] = []
        self.rpdos: list[int] = []
        self._communication()
        self._sdos()
        for base in (0x1400, 0x1800):
            numbers = sorted({chance.choice((0, 1, 2, 3, 4, 9)) for _ in range(3)})
            for number in numbers[: chance.randrange(1, 4)]:
                self._pdo(base, number)
        self._application()
        self.text = self._whole()

    def _whole(self) -> str:
        rpdos, tpdos = len(self.rpdos), len(self.tpdos)
        return (
            "[FileInfo]\nFileName=d.eds\nEDSVersion=4.0\n[DeviceInfo]\nVendorName=v\n"
            "VendorNumber=1\nProductName=p\nProductNumber=2\nRevisionNumber=3\n"
            "BaudRate_500=1\nSimpleBootUpSlave=1\nGranularity=8\n"
            f"NrOfRXPDO={rpdos}\nNrOfTXPDO={tpdos}\nLSS_Supported=0\n"
            "[DummyUsage]\nDummy0005=1\nDummy0006=1\n" + "".join(self._text)
        )

    def _add(
        self,
        section: str,
        type_: int,
        default: str | None,
        access: str = "rw",
        more: str = "",
    ) -> None:
        entry = "" if default is None else f"DefaultValue={default}\n"
        self._text.append(
            f"[{section}]\nParameterName=O{section}\nObjectType=7\n"
            f"DataType={type_}\nAccessType={access}\n{entry}{more}"
        )

    def _record(self, index: int, subs: int, access: str = "const") -> None:
        self._text.append(
            f"[{index:04X}]\nParameterName=O{index:04X}\nObjectType=9\n"
            f"SubNumber={subs + 1}\n"
        )
        self._add(f"{index:04X}sub0", 5, str(subs), access)

    def _writes(self, number: str, *values: object) -> None:
        self.writable.append(tuple({number: value} for value in values))

    def _configured(self, value: str) -> str:
        """Return a value of a DCF, by chance."""
        return f"ParameterValue={value}\n" if self._chance.random() < 0.15 else ""

    def _cob_id(self, predefined: str) -> str | None:
        """Return the default of a COB-ID: the predefined one, another, or what stands for it."""
        free = f"0x{self._identifiers.next():X}"
        return self._chance.choice(
            [predefined] * 6 + [None, "0", "0x40000000", _UNREADABLE, free]
            + ["0x10", "0x585"]
        )  # fmt: skip

    def _communication(self) -> None:
        chance = self._chance
        self._add("1000", 7, "0x191", "ro")
        self._add("1001", 5, "0", "ro")
        self._record(0x1018, 4)
        for sub, value in enumerate((1, 2, 3, 0), 1):
            self._add(f"1018sub{sub}", 7, str(value), "ro")
        self._add("1017", 6, chance.choice(["0", "500", None]))
        self._writes("1017", 100, 200)
        if chance.random() < 0.8:
            self._add("1005", 7, self._cob_id("0x80"))
        if chance.random() < 0.7:
            self._add("1006", 7, chance.choice(["0", "0", "20000", None]))
            self._writes("1006", 0, 50000)
        if chance.random() < 0.5:
            self._add("1019", 5, chance.choice(["0", "0", "10", None]))
        if chance.random() < 0.3:
            self._add("1007", 7, "0")
            self._writes("1007", 1000)
        if chance.random() < 0.6:
            flags = chance.choice(("0x80000100", "0xC0000100", "0x100"))
            self._add("1012", 7, self._cob_id(flags))
            ids = [flag | self._identifiers.next() for flag in _COB_FLAGS]
            self._writes("1012", *ids, 0x80000100, 0x100)
        if chance.random() < 0.8:
            own, on, off = (self._identifiers.next() for _ in range(3))
            more = self._configured(f"0x{own:X}")
            self._add("1014", 7, self._cob_id("$NODEID+0x80"), more=more)
            self._writes("1014", on, 0x80000000 | off, '"$NODEID+0x80"')
        if chance.random() < 0.4:
            self._add("1015", 6, "0")
            self._writes("1015", 100)
        if chance.random() < 0.7:
            self._heartbeats()
        if chance.random() < 0.2:
            self._record(0x1020, 2)
            for sub in (1, 2):
                self._add(f"1020sub{sub}", 7, "0")
                self._writes(f"1020:{sub}", 4711)
        if chance.random() < 0.2:
            self._record(0x1028, 2)
            for sub in (1, 2):
                own, on, off = (self._identifiers.next() for _ in range(3))
                default = chance.choice(["0x80000000", f"0x{own:X}"])
                self._add(f"1028sub{sub}", 7, default)
                self._writes(f"1028:{sub}", on, 0x80000000 | off)
        if chance.random() < 0.2:
            self._record(0x1010, 1)
            self._add("1010sub1", 7, "1")
            self._writes("1010:1", 0x65766173)

    def _heartbeats(self) -> None:
        chance = self._chance
        entries = chance.randrange(1, 5)
        watched = chance.sample(range(1, 128), entries)
        self._record(0x1016, entries)
        for sub, node in enumerate(watched, 1):
            default = chance.choice([0, node << 16 | 30000])
            more = self._configured(f"0x{node << 16 | 20000:X}")
            self._add(f"1016sub{sub}", 7, f"0x{default:X}", more=more)
        places = [f"1016:{sub}" for sub in range(1, entries + 1)]
        alternatives = []
        for _ in range(4):
            # The same nodes in another order, others, and none.
            nodes = chance.sample(
                [*watched, *chance.sample(range(1, 128), 2), 0], entries
            )
            if len(set(nodes)) == entries:
                values = [node and node << 16 | 25000 for node in nodes]
                alternatives.append(dict(zip(places, values, strict=True)))
        self.writable.append((*alternatives, {places[0]: 0}))

    def _sdos(self) -> None:
        chance = self._chance
        for index in (0x1201, 0x1280):
            if chance.random() > 0.25:
                continue
            self._record(index, 3)
            for sub in (1, 2):
                own, other = self._identifiers.next(), self._identifiers.next()
                default = chance.choice(["0x80000000", f"0x{own:X}", None])
                self._add(f"{index:X}sub{sub}", 7, default)
                self._writes(f"{index:X}:{sub}", other, 0x80000000)
            self._add(f"{index:X}sub3", 5, "1")
            self._writes(f"{index:X}:3", 9)

    def _pdo(self, base: int, number: int) -> None:
        chance = self._chance
        index, sent = base + number, base == 0x1800
        (self.tpdos if sent else self.rpdos).append(number + 1)
        code = (0x180 if sent else 0x200) + 0x100 * number
        predefined = f"$NODEID+0x{code:X}" if number < 4 else "0x80000000"
        if number < 4 and chance.random() < 0.3:
            predefined = f"$NODEID+0x{0x80000000 | code:X}"
        fixed = chance.random() < 0.1
        access = "ro" if fixed else "rw"
        self._record(index, 6)
        own = f"0x{self._identifiers.next():X}"
        more = self._configured(own) if not fixed else ""
        self._add(f"{index:X}sub1", 7, self._cob_id(predefined), access, more)
        self._add(f"{index:X}sub2", 5, chance.choice(["255", "1", "0", "254", None]))
        self._add(f"{index:X}sub3", 6, "0")
        self._add(f"{index:X}sub5", 6, "0")
        self._add(f"{index:X}sub6", 5, "0")
        if not fixed:
            self._writes(f"{index:X}:1", f'"$NODEID+0x{code:X}"' if number < 4 else own)
        self._writes(f"{index:X}:2", 1, 255, 10, 0)
        self._writes(f"{index:X}:3", 100)
        self._writes(f"{index:X}:5", 50)
        self._mapping(index + 0x200, sent, fixed)

    def _mapping(self, index: int, sent: bool, fixed: bool) -> None:
        chance = self._chance
        places = chance.randrange(1, 5)
        count = chance.choice([0, 1, places, places])
        access = "const" if fixed and chance.random() < 0.5 else "rw"
        self._record(index, 0)
        self._text.pop()
        self._add(f"{index:X}sub0", 5, str(count), access)
        first = _MAPPABLE + (0 if sent else _OBJECTS)
        entries = [
            (first + chance.randrange(_OBJECTS)) << 16 | 8 for _ in range(places)
        ]
        for place, entry in enumerate(entries, 1):
            used = f"0x{entry:X}" if place <= count else chance.choice(["0", None])
            self._add(f"{index:X}sub{place}", 7, used, access)
        if access == "rw":
            usable = [
                (_MAPPABLE + place) << 16 | 8
                for place in range(first - _MAPPABLE, first - _MAPPABLE + _OBJECTS)
                if self._mappable[place]
            ]
            self.mappings.append(
                tuple(self._remapped(index, usable, places) for _ in range(3))
            )

    def _remapped(self, index: int, usable: list[int], places: int) -> Writes:
        """Return a mapping of some objects; seldom one that no device has."""
        chance = self._chance
        entries = [chance.choice(usable) for _ in range(chance.randrange(places + 1))]
        if entries and chance.random() < 0.05:
            entries[-1] += chance.choice([8, 1 << 16, -8])
        written = {f"{index:04X}:{k}": e for k, e in enumerate(entries, 1)}
        return {f"{index:04X}:0": len(entries), **written}

    def _application(self) -> None:
        chance = self._chance
        for place in range(2 * _OBJECTS):
            sent = place < _OBJECTS
            mappable = f"PDOMapping={int(self._mappable[place])}\n"
            access = chance.choice(["ro", "rwr"] if sent else ["wo", "rww", "rw"])
            self._add(f"{_MAPPABLE + place:X}", 5, "0", access, mappable)
        for place in range(4):
            section = f"{0x2100 + place:X}"
            limits = chance.choice(
                ["LowLimit=10\nHighLimit=100\n", "HighLimit=50\n", ""]
            )
            default = chance.choice(["20", None])
            self._add(section, 5, default, more=limits + self._configured("30"))
            self._writes(section, 15, 40)


class RandomBus:
    """A bus file with its descriptions in a folder; a seed always gives the same."""

    def __init__(self, seed: int, folder: Path) -> None:
        chance = Random(seed)
        lines = ["[bus]", "bit_rate = 500"]
        if chance.random() < 0.7:
            lines.append("sync = 0.02")
        if chance.random() < 0.3:
            lines.append("sync_counter = 10")
        if chance.random() < 0.5:
            lines.append("heartbeat = 0.2")
        ids = chance.sample(range(1, 120), chance.randrange(1, 4))
        # Two nodes of a kind with identifiers of its own are a clash.
        kinds = len(ids) if chance.random() < 0.8 else chance.randrange(1, len(ids) + 1)
        identifiers = Identifiers(chance)
        devices = [RandomDevice(chance, identifiers) for _ in range(kinds)]
        for number, device in enumerate(devices):
            suffix = chance.choice(("eds", "dcf"))
            name = f"d{number}.{suffix}"
            (folder / name).write_text(device.text, encoding="ascii")
            lines += [f"[device.d{number}]", f'eds = "{name}"']
            mappings = chance.sample(
                device.mappings, chance.randrange(min(2, len(device.mappings)) + 1)
            )
            table = f"device.d{number}"
            lines += self._values(chance, device.writable, table, 3, mappings)
        for place, node_id in enumerate(ids):
            number = place % kinds
            lines += [f"[node.n{place}]", f'device = "d{number}"', f"id = {node_id}"]
            writable = devices[number].writable
            lines += self._values(chance, writable, f"node.n{place}", 4)
        self.file = folder / "bus.toml"
        self.file.write_text("\n".join(lines) + "\n", encoding="ascii")

    @staticmethod
    def _values(
        chance: Random,
        writable: list[tuple[Writes, ...]],
        table: str,
        most: int,
        more: Sequence[tuple[Writes, ...]] = (),
    ) -> list[str]:
        parts = [*chance.sample(writable, chance.randrange(most + 1)), *more]
        written = [each for part in parts for each in chance.choice(part).items()]
        values = [f'"{number}" = {value}' for number, value in written]
        return [f"[{table}.values]", *values] if values else []
