"""A device with an object of every kind, and a bench that simulates the bus of its node."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Kind,
    ObjectDescription,
    ObjectValue,
    PdoDescription,
)
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import MILLISECOND, SDO_REQUEST, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, command_frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient

NODE_ID = 5

KINDS: tuple[Kind, ...] = (
    "bool", "char", "i8", "i16", "i24", "i32", "i40", "i48", "i56", "i64",
    "u8", "u16", "u24", "u32", "u40", "u48", "u56", "u64", "r32", "r64",
    "time_of_day", "time_difference", "string", "wstring", "octets",
)  # fmt: skip
FIRST = 0x2000
"""Index of the first object of `KINDS`; all are readable, writable and mappable."""


def number_of(kind: Kind) -> int:
    """Return the index of the object of a kind."""
    return FIRST + KINDS.index(kind)


def var(
    index: int,
    subindex: int,
    kind: Kind,
    access: str = "rw",
    default: ObjectValue | None = None,
    *,
    low: int | float | None = None,
    high: int | float | None = None,
    relative: bool = False,
    mappable: bool = False,
) -> ObjectDescription:
    return ObjectDescription(
        index, subindex, f"o_{index:04X}_{subindex:02X}", kind, access, default,
        low, high, relative, mappable,
    )  # fmt: skip


def pdo_objects(
    base: int, count: int, *, access: str = "rw"
) -> list[ObjectDescription]:
    """Return the parameters of PDOs with `count` entries each."""
    mapped = base + 0x200
    kinds: tuple[tuple[int, Kind], ...] = (
        (1, "u32"), (2, "u8"), (3, "u16"), (5, "u16"), (6, "u8"),
    )  # fmt: skip
    return [
        var(base, 0, "u8", "const", 6),
        *(var(base, sub, kind) for sub, kind in kinds),
        var(mapped, 0, "u8", access, 0),
        *(var(mapped, sub, "u32", access, 0) for sub in range(1, count + 1)),
    ]


def pdo(
    direction: str,
    number: int,
    *entries: tuple[int, int, int],
    cob_id: int | None = None,
    transmission_type: int = 255,
    **times: int,
) -> PdoDescription:
    base = {"rpdo": 0x200, "tpdo": 0x180}[direction] + 0x100 * (number - 1)
    return PdoDescription(
        "rpdo" if direction == "rpdo" else "tpdo",
        number,
        base if cob_id is None else cob_id,
        relative=cob_id is None,
        transmission_type=transmission_type,
        mapping=entries,
        **times,
    )


COMMUNICATION = (
    var(0x1000, 0, "u32", "ro", 0x00020192),
    var(0x1001, 0, "u8", "ro", 0, mappable=True),
    var(0x1003, 0, "u8", "rw", 0),
    *(var(0x1003, sub, "u32", "ro", 0) for sub in range(1, 5)),
    var(0x1005, 0, "u32", "rw", 0x80),
    var(0x1006, 0, "u32", "rw", 0),
    var(0x1008, 0, "string", "const", "Bench device"),
    var(0x1010, 0, "u8", "const", 4),
    *(var(0x1010, sub, "u32", "rw", 1) for sub in range(1, 5)),
    var(0x1011, 0, "u8", "const", 4),
    *(var(0x1011, sub, "u32", "rw", 1) for sub in range(1, 5)),
    var(0x1012, 0, "u32", "rw", 0x80000100),
    var(0x1014, 0, "u32", "rw", 0x80, relative=True),
    var(0x1015, 0, "u16", "rw", 0),
    var(0x1016, 0, "u8", "const", 2),
    *(var(0x1016, sub, "u32", "rw", 0) for sub in range(1, 3)),
    var(0x1017, 0, "u16", "rw", 0),
    var(0x1018, 0, "u8", "const", 4),
    var(0x1018, 1, "u32", "ro", None),
    var(0x1018, 2, "u32", "ro", None),
    var(0x1018, 3, "u32", "ro", None),
    var(0x1018, 4, "u32", "ro", None),
    var(0x1019, 0, "u8", "rw", 0),
    var(0x1029, 0, "u8", "const", 1),
    var(0x1029, 1, "u8", "rw", 0, high=2),
    var(0x1F80, 0, "u32", "rw", 0),
)
APPLICATION = (
    *(var(number_of(kind), 0, kind, mappable=True) for kind in KINDS),
    var(0x2100, 0, "u16", "ro", 7, mappable=True),
    var(0x2101, 0, "u16", "wo", None, mappable=True),
    var(0x2102, 0, "u16", "const", 9),
    var(0x2103, 0, "i16", "rw", 0, low=-100, high=100, mappable=True),
    var(0x2104, 0, "r32", "rw", 0.0, low=-1.5, high=1.5, mappable=True),
    var(0x2105, 0, "u16", "rwr", 0, mappable=True),
    var(0x2106, 0, "u16", "rww", 0, mappable=True),
    var(0x6040, 0, "u16", "rww", 0, mappable=True),
    var(0x6041, 0, "u16", "ro", 0x40, mappable=True),
    var(0x6064, 0, "i32", "ro", 0, mappable=True),
    var(0x607A, 0, "i32", "rww", 0, mappable=True),
)
PDOS = (
    pdo("rpdo", 1, (0x6040, 0, 16), (0x607A, 0, 32)),
    pdo("rpdo", 2),
    pdo("tpdo", 1, (0x6041, 0, 16), (0x6064, 0, 32)),
    pdo("tpdo", 2),
)
DEVICE = DeviceDescription(
    "Bench",
    (
        *COMMUNICATION,
        *pdo_objects(0x1400, 8),
        *pdo_objects(0x1401, 64),
        *pdo_objects(0x1800, 8),
        *pdo_objects(0x1801, 64),
        *APPLICATION,
    ),
    PDOS,
    vendor_id=0x00FFFF01,
    product_code=0x4242,
    revision_number=0x00010002,
    lss=True,
    granularity=1,
    dummies=(2, 3, 4, 5, 6, 7),
)


def with_pdos(*pdos: PdoDescription, granularity: int = 1) -> DeviceDescription:
    """Return the device with other PDOs."""
    return replace(DEVICE, pdos=pdos, granularity=granularity)


class Bench:
    """Passes frames and the time to a node, and records its frames."""

    def __init__(self, node: DeviceNode | None = None, *, boot: bool = True) -> None:
        self.node = node or DeviceNode(DEVICE, NODE_ID, serial_number=99)
        self.now = 0
        self.sent: list[Frame] = []
        self._client = SdoClient(NODE_ID)
        if boot:
            self.note(self.node.boot(0))

    def note(self, frames: Iterable[Frame]) -> list[Frame]:
        got = list(frames)
        self.sent += got
        return got

    def give(self, can_id: int, data: bytes = b"", **kind: bool) -> list[Frame]:
        """Pass a frame; return the node's frames."""
        return self.note(self.node.receive(Frame(can_id, data, **kind), self.now))

    def command(self, command: NmtCommand, node_id: int = NODE_ID) -> list[Frame]:
        return self.note(self.node.receive(command_frame(command, node_id), self.now))

    def start(self) -> list[Frame]:
        return self.command(NmtCommand.START)

    def flush(self) -> list[Frame]:
        return self.note(self.node.flush(self.now))

    def run(self, milliseconds: float) -> list[Frame]:
        """Advance the time; return the frames of the node's timers."""
        end = self.now + round(milliseconds * MILLISECOND)
        got: list[Frame] = []
        while (due := self.node.deadline) is not None and due <= end:
            self.now = max(due, self.now)
            got += self.node.poll(self.now)
        self.now = end
        return self.note(got)

    def read(self, index: int, subindex: int = 0, *, block: bool = False) -> bytes:
        """Read by SDO. Raises SdoAbort."""
        return self._transfer(
            self._client.upload(index, subindex, self.now, block=block)
        )

    def write(
        self, index: int, subindex: int, value: bytes | int, size: int = 0
    ) -> None:
        """Write by SDO; an integer in as many octets as the object has. Raises SdoAbort."""
        if isinstance(value, int):
            size = size or self.node.dictionary.writable_size(index, subindex)
            value = value.to_bytes(size, "little", signed=value < 0)
        self._transfer(self._client.download(index, subindex, value, self.now))

    def refusal(self, index: int, subindex: int, value: bytes | int) -> int:
        """Return the abort code of a write, 0 for success."""
        try:
            self.write(index, subindex, value)
        except SdoAbort as abort:
            return abort.code
        return 0

    def _transfer(self, requests: list[Frame]) -> bytes:
        client = self._client
        while client.busy:
            assert requests, "the server is silent"
            assert all(r.can_id == SDO_REQUEST + NODE_ID for r in requests)
            answers = [a for r in requests for a in self.node.receive(r, self.now)]
            self.note(answers)
            requests = [r for a in answers for r in client.receive(a, self.now)]
        while not client.ready:
            self.now = client.deadline or self.now
            client.poll(self.now)
        return client.result()
