"""A node that enforces each condition of CiA 301 for writes to its communication objects.

Its tables are its own: it shares the reader of descriptions and the transport of SDO with rtgen,
but neither defaults of COB-IDs nor the order of writes. Where CiA 301 leaves room, it refuses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Final

from rtgen.compiler.layouts.can_values import CanValueError, octets
from rtgen.compiler.model.canopen import (
    Access,
    DataType,
    Device,
    NodeRelative,
    Variable,
)
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

Number = tuple[int, int]

BIT31, BIT30, BIT29 = 1 << 31, 1 << 30, 1 << 29
LOW: Final = BIT30 - 1
"""Bits 0 to 29 of a COB-ID."""

UNSUPPORTED, READ_ONLY, LOCKED = 0x06010000, 0x06010002, 0x06010003
NO_OBJECT, NOT_MAPPABLE, TOO_MANY = 0x06020000, 0x06040041, 0x06040042
INCOMPATIBLE, LENGTH, NO_SUB = 0x06040043, 0x06070010, 0x06090011
INVALID, TOO_HIGH, TOO_LOW, STATE = 0x06090030, 0x06090031, 0x06090032, 0x08000022
NOT_STORED: Final = 0x08000020

INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127

SIZES: Final = {
    DataType.BOOLEAN: 1, DataType.INTEGER8: 1, DataType.UNSIGNED8: 1,
    DataType.INTEGER16: 2, DataType.UNSIGNED16: 2,
    DataType.INTEGER24: 3, DataType.UNSIGNED24: 3,
    DataType.INTEGER32: 4, DataType.UNSIGNED32: 4, DataType.REAL32: 4,
    DataType.INTEGER40: 5, DataType.UNSIGNED40: 5,
    DataType.INTEGER48: 6, DataType.UNSIGNED48: 6,
    DataType.TIME_OF_DAY: 6, DataType.TIME_DIFFERENCE: 6,
    DataType.INTEGER56: 7, DataType.UNSIGNED56: 7,
    DataType.INTEGER64: 8, DataType.UNSIGNED64: 8, DataType.REAL64: 8,
    DataType.VISIBLE_CHAR: 1,
}  # fmt: skip
SIGNED: Final = frozenset(t for t in SIZES if t.name.startswith("INTEGER"))
PLAIN: Final = SIGNED | {t for t in SIZES if t.name.startswith("UNSIGNED")}


def is_restricted(can_id: int) -> bool:
    """Return whether CiA 301 restricts an identifier (table "restricted CAN-IDs")."""
    return (
        can_id <= 0x07F
        or 0x101 <= can_id <= 0x180
        or 0x581 <= can_id <= 0x5FF
        or 0x601 <= can_id <= 0x67F
        or 0x6E0 <= can_id <= 0x6FF
        or can_id >= 0x701
    )


def can_be(cob_id: int) -> bool:
    """Return whether a communication object may have a COB-ID."""
    if cob_id & BIT29:
        return True
    return not cob_id & 0x1FFFF800 and not is_restricted(cob_id & 0x7FF)


def is_pdo(index: int) -> bool:
    return 0x1400 <= index < 0x1600 or 0x1800 <= index < 0x1A00


def is_mapping(index: int) -> bool:
    return 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00


def is_cob_id(number: Number) -> bool:
    index, sub = number
    if index in (0x1005, 0x1012, 0x1014):
        return sub == 0
    if index == 0x1028:
        return sub > 0
    return (is_pdo(index) and sub == 1) or (0x1201 <= index < 0x1300 and sub in (1, 2))


def function_code(index: int) -> int | None:
    """Return the function code of a service that has the node-id added to it."""
    if index == 0x1014:
        return 0x080
    if 0x1400 <= index <= 0x1403:
        return 0x200 + 0x100 * (index - 0x1400)
    if 0x1800 <= index <= 0x1803:
        return 0x180 + 0x100 * (index - 0x1800)
    return None


def power_on(number: Number, stated: int | None, node_id: int) -> int:
    """Return the COB-ID with which the node begins, from that of its description."""
    index = number[0]
    code = function_code(index)
    fixed = {0x1005: 0x080, 0x1012: 0x100}.get(index)
    base = fixed if code is None else code + node_id
    if stated is None:
        return BIT31 if base is None else base
    stated &= 0xFFFFFFFF
    is_off = fixed is None and bool(stated & BIT31)
    if stated & BIT29 or is_off:
        return stated
    if stated & 0x1FFFFFFF in (0, code):
        return (BIT31 if base is None else base) | stated & (BIT31 | BIT30)
    if can_be(stated):
        return stated
    if fixed is None:
        return stated | BIT31
    return stated & ~(BIT31 | BIT30 if index == 0x1012 else BIT30)


class StrictNode:
    """A station: NMT, SDO, SYNC, EMCY, and TPDOs of their identifiers only.

    `refused` are the writes that it has refused, with their codes; `sent` its frames. `syncs`
    counts the SYNC messages that it has understood, `odd_syncs` those of another length.
    """

    def __init__(self, device: Device, node_id: int) -> None:
        self.device = device
        self.id = node_id
        self.state = INITIALISING
        self.refused: list[tuple[Number, bytes, int]] = []
        self.sent: list[Frame] = []
        self.syncs = self.odd_syncs = self.resets = 0
        self._variables = {(v.index, v.subindex): v for v in device.variables}
        self._indices = {index for index, _ in self._variables}
        self._own_entries = {
            (v.index >= 0x1A00, v.default)
            for v in device.variables
            if is_mapping(v.index) and v.subindex and isinstance(v.default, int)
        }
        self.values: dict[Number, bytes] = {}
        self.identity: Mapping[Number, int | None] = {}
        """Values of 1000h and 1018h in place of those of the description."""
        self._server = SdoServer(node_id, self)
        self._boot: int | None = None
        self._beat: int | None = None
        self._load()

    # Station

    identifiers = None

    @property
    def deadline(self) -> int | None:
        times = (self._boot, self._beat, self._server.deadline)
        return min((t for t in times if t is not None), default=None)

    def power_on(self, now: int) -> None:
        """Begin to boot."""
        self.state = INITIALISING
        self._load()
        self._beat, self._boot = None, now + 500_000
        self._server.reset()

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        if frame.can_id == 0 and not frame.extended:
            return self._said(self._obey(frame, now))
        if self.state == INITIALISING:
            return ()
        if self._is(frame, self.number((0x1005, 0), 0x80)):
            self._take_sync(frame)
        if self.state != STOPPED:
            before = self.number((0x1017, 0), 0)
            answers = self._server.receive(frame, now)
            if self.number((0x1017, 0), 0) != before:
                self._schedule(now)
            return self._said(answers)
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        frames = self._server.poll(now)
        if self._boot is not None and now >= self._boot:
            self._boot, self.state = None, PRE_OPERATIONAL
            frames.append(Frame(0x700 + self.id, b"\0"))
            self._schedule(now)
        if self._beat is not None and now >= self._beat:
            frames.append(Frame(0x700 + self.id, bytes((self.state,))))
            self._schedule(now)
        return self._said(frames)

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()

    def _said(self, frames: Iterable[Frame]) -> list[Frame]:
        found = list(frames)
        self.sent += found
        return found

    def _schedule(self, now: int) -> None:
        period = self.number((0x1017, 0), 0) * 1_000_000
        self._beat = now + period if period else None

    def _obey(self, frame: Frame, now: int) -> list[Frame]:
        if len(frame.data) != 2 or frame.data[1] not in (0, self.id):
            return []
        command = frame.data[0]
        if command in (0x81, 0x82):
            self.resets += 1
            self.power_on(now)
        elif self.state != INITIALISING:
            states = {1: OPERATIONAL, 2: STOPPED, 0x80: PRE_OPERATIONAL}
            self.state = states[command]
            if command == 1:
                return [*self._emergency(), *self._process_data()]
        return []

    def _emergency(self) -> list[Frame]:
        """Return "no error", which each node may send at any time."""
        if (0x1014, 0) not in self.values:
            return []
        cob_id = self.number((0x1014, 0), BIT31)
        return [] if cob_id & BIT31 else [self._frame(cob_id, bytes(8))]

    def _process_data(self) -> list[Frame]:
        return [self._frame(cob_id, bytes(1)) for cob_id in self.tpdos()]

    def tpdos(self) -> list[int]:
        """Return the COB-IDs of the TPDOs that are valid, and map something."""
        found = []
        for index, sub in sorted(self.values):
            if 0x1800 <= index < 0x1A00 and sub == 1:
                cob_id = self.number((index, 1), BIT31)
                if not cob_id & BIT31 and self._mapped(index):
                    found.append(cob_id)
        return found

    def _mapped(self, index: int) -> int:
        """Return the number of objects that a PDO maps; that of a multiplexed one is 0."""
        count = self.number((index + 0x200, 0), 0)
        places = range(1, count + 1) if count <= 64 else ()
        return sum(self.number((index + 0x200, place), 0) > 0 for place in places)

    @staticmethod
    def _frame(cob_id: int, data: bytes) -> Frame:
        extended = bool(cob_id & BIT29)
        return Frame(
            cob_id & (0x1FFFFFFF if extended else 0x7FF), data, False, extended
        )

    @staticmethod
    def _is(frame: Frame, cob_id: int) -> bool:
        extended = bool(cob_id & BIT29)
        mask = 0x1FFFFFFF if extended else 0x7FF
        if not can_be(cob_id & ~(BIT31 | BIT30)):
            return False
        return frame.can_id == cob_id & mask and frame.extended == extended

    def _take_sync(self, frame: Frame) -> None:
        counts = self.number((0x1019, 0), 0)
        wanted = (1 if counts else 0,) if (0x1019, 0) in self.values else (0, 1)
        if len(frame.data) in wanted and not frame.remote:
            self.syncs += 1
        else:
            self.odd_syncs += 1

    # Object dictionary

    def _load(self) -> None:
        for number, variable in self._variables.items():
            known = self.identity.get(number)
            self.values[number] = (
                self._initial(number, variable)
                if known is None
                else known.to_bytes(4, "little")
            )

    def _initial(self, number: Number, variable: Variable) -> bytes:
        value = variable.default
        if isinstance(value, NodeRelative):
            value = self.id + value.offset
        if is_cob_id(number):
            stated = value if isinstance(value, int) else None
            return power_on(number, stated, self.id).to_bytes(4, "little")
        size = SIZES.get(variable.data_type)  # type: ignore[call-overload]
        if value is None and variable.data_type in PLAIN:
            low = variable.low if isinstance(variable.low, int) else 0
            high = variable.high if isinstance(variable.high, int) else 0
            value = max(low, 0) or min(high, 0)
        try:
            found = b"" if value is None else octets(variable.data_type, value)
        except CanValueError:
            found = b""
        return found.ljust(size or 0, b"\0")

    def number(self, number: Number, absent: int) -> int:
        """Return an unsigned value."""
        if number not in self.values:
            return absent
        return int.from_bytes(self.values[number], "little")

    def read(self, index: int, subindex: int) -> bytes:
        """See `ObjectDictionary`."""
        number = index, subindex
        if number not in self.values:
            raise SdoAbort(NO_SUB if index in self._indices else NO_OBJECT)
        return self.values[number]

    def writable_size(self, index: int, subindex: int) -> int:
        """See `ObjectDictionary`."""
        return 1 << 16

    def write(self, index: int, subindex: int, value: bytes) -> None:
        """See `ObjectDictionary`."""
        number = index, subindex
        try:
            self._check(number, value)
        except SdoAbort as abort:
            self.refused.append((number, value, abort.code))
            raise
        changes = self.values[number] != value
        self.values[number] = value
        if changes and index not in (0x1020, 0x1010, 0x1011):
            # CiA 301, 7.5.2.22: the configuration is no longer the verified one.
            for sub in (1, 2):
                if (0x1020, sub) in self.values:
                    self.values[0x1020, sub] = bytes(4)

    def _check(self, number: Number, value: bytes) -> None:
        index, sub = number
        variable = self._variables.get(number)
        if variable is None:
            raise SdoAbort(NO_SUB if index in self._indices else NO_OBJECT)
        if variable.access in (Access.RO, Access.CONST):
            raise SdoAbort(READ_ONLY)
        size = SIZES.get(variable.data_type)  # type: ignore[call-overload]
        if size is not None and len(value) != size:
            raise SdoAbort(LENGTH)
        if variable.data_type in PLAIN:
            signed = variable.data_type in SIGNED
            self._check_limits(variable, int.from_bytes(value, "little", signed=signed))
        new = int.from_bytes(value, "little")
        if is_cob_id(number):
            self._check_cob_id(number, new)
        for applies, check in self._rules():
            if applies(index):
                check(index, sub, new)

    @staticmethod
    def _check_limits(variable: Variable, value: int) -> None:
        if isinstance(variable.low, int) and value < variable.low:
            raise SdoAbort(TOO_LOW)
        if isinstance(variable.high, int) and value > variable.high:
            raise SdoAbort(TOO_HIGH)

    def _rules(
        self,
    ) -> tuple[tuple[Callable[[int], bool], Callable[[int, int, int], None]], ...]:
        return (
            (lambda index: index == 0x1003, self._check_history),
            (lambda index: index in (0x1010, 0x1011), self._check_store),
            (lambda index: index == 0x1016, self._check_consumer),
            (lambda index: index == 0x1019, self._check_counter),
            (lambda index: 0x1200 <= index < 0x1300, self._check_sdo),
            (is_pdo, self._check_pdo),
            (is_mapping, self._check_mapping),
        )

    def _check_cob_id(self, number: Number, new: int) -> None:
        index, old = number[0], self.number(number, 0)
        changes = (old ^ new) & LOW
        if index == 0x1005:
            exists, will = bool(old & BIT30), True
        elif index == 0x1012:
            exists, will = bool(old & (BIT31 | BIT30)), True
        else:
            exists, will = not old & BIT31, not new & BIT31
        if exists and not can_be(old & LOW):
            exists = False
        if exists and changes:
            raise SdoAbort(INVALID)
        # An identifier that is off may be any for PDOs and SDOs; others keep one they can have.
        if (will or index in (0x1014, 0x1028)) and changes and not can_be(new & LOW):
            raise SdoAbort(INVALID)
        if will and not can_be(new & LOW):
            raise SdoAbort(INVALID)

    @staticmethod
    def _check_history(index: int, sub: int, new: int) -> None:
        if sub or new:
            raise SdoAbort(INVALID)

    @staticmethod
    def _check_store(index: int, sub: int, new: int) -> None:
        if new != int.from_bytes(b"save" if index == 0x1010 else b"load", "little"):
            raise SdoAbort(NOT_STORED)

    def _check_consumer(self, index: int, sub: int, new: int) -> None:
        node, time = new >> 16 & 0xFF, new & 0xFFFF
        if not sub or not time or not 1 <= node <= 127:
            return
        for (other, place), value in self.values.items():
            entry = int.from_bytes(value, "little")
            used = entry & 0xFFFF and entry >> 16 & 0xFF == node
            if other == 0x1016 and place not in (0, sub) and used:
                raise SdoAbort(INCOMPATIBLE)

    def _check_counter(self, index: int, sub: int, new: int) -> None:
        if self.number((0x1006, 0), 0):
            raise SdoAbort(STATE)
        if new == 1 or new > 240:
            raise SdoAbort(INVALID)

    def _check_sdo(self, index: int, sub: int, new: int) -> None:
        valid = not any(self.number((index, k), BIT31) & BIT31 for k in (1, 2))
        if sub == 3 and valid and new != self.number((index, sub), 0):
            raise SdoAbort(INVALID)

    def _check_pdo(self, index: int, sub: int, new: int) -> None:
        valid = not self.number((index, 1), BIT31) & BIT31
        changes = new != self.number((index, sub), 0)
        if sub == 1 and not new & BIT31 and not valid:
            mapped = self.number((index + 0x200, 0), 1)
            if not mapped:
                raise SdoAbort(INVALID)
        if sub == 2 and 240 < new < (254 if index < 0x1800 else 252):
            raise SdoAbort(INVALID)
        if sub in (2, 3, 6) and valid and changes:
            raise SdoAbort(INVALID)
        if sub == 6 and new > 240:
            raise SdoAbort(INVALID)

    def _check_mapping(self, index: int, sub: int, new: int) -> None:
        if not self.number((index - 0x200, 1), BIT31) & BIT31:
            raise SdoAbort(UNSUPPORTED)
        count = (index, 0)
        if sub:
            if self.number(count, 0):
                raise SdoAbort(LOCKED)
            if new:
                self._check_entry(index, new)
            return
        if new in (0xFE, 0xFF):
            return
        places = [n for i, n in self.values if i == index and n]
        if new > 64 or new > len(places):
            raise SdoAbort(TOO_MANY)
        entries = [self.number((index, place), 0) for place in range(1, new + 1)]
        if sum(entry & 0xFF for entry in entries) > 64:
            raise SdoAbort(TOO_MANY)
        for entry in entries:
            self._check_entry(index, entry)

    def _check_entry(self, index: int, entry: int) -> None:
        sent = index >= 0x1A00
        if (sent, entry) in self._own_entries:
            return
        number = entry >> 16, entry >> 8 & 0xFF
        if number[0] < 0x20:
            if sent or number[0] not in self.device.dummies:
                raise SdoAbort(NOT_MAPPABLE)
            return
        variable = self._variables.get(number)
        if variable is None:
            raise SdoAbort(NO_OBJECT)
        ways = {
            Access.RO: (True,), Access.CONST: (True,), Access.RWR: (True,),
            Access.WO: (False,), Access.RWW: (False,), Access.RW: (True, False),
        }  # fmt: skip
        if not variable.pdo_mappable or sent not in ways[variable.access]:
            raise SdoAbort(NOT_MAPPABLE)


class LiteralNode(StrictNode):
    """A node that begins with any COB-ID of its description, also 0 and restricted ones.

    With a DCF it begins with the configured ones, and so do consumers of heartbeats; where none is
    stated it is 0. It refuses another identifier for one that stays in use.
    """

    def _initial(self, number: Number, variable: Variable) -> bytes:
        if not is_cob_id(number):
            if number[0] == 0x1016 and isinstance(variable.value, int):
                return variable.value.to_bytes(
                    SIZES[DataType(variable.data_type)], "little"
                )
            return super()._initial(number, variable)
        value = variable.default if variable.value is None else variable.value
        if isinstance(value, NodeRelative):
            value = self.id + value.offset
        stated = value if isinstance(value, int) else 0
        return (stated & 0xFFFFFFFF).to_bytes(4, "little")

    def _check_cob_id(self, number: Number, new: int) -> None:
        index, old = number[0], self.number(number, 0)
        on = {0x1005: BIT30, 0x1012: BIT31 | BIT30}.get(index)
        before, after = ((c & on if on else not c & BIT31) for c in (old, new))
        if before and after and (old ^ new) & LOW:
            raise SdoAbort(INVALID)
        if after and not can_be(new & LOW):
            raise SdoAbort(INVALID)
