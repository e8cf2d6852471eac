"""Fuzzing of CANopen stations: with any frames, stations go on and their memory stays bounded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random

from fuzzing import ViolationError, log_uniform

from refrobots.canopen.networks.rh3_beego import NETWORK
from refrobots.components.epos_drive_proxy import EposDriveProxy
from refrobots.eposdrive import DESCRIPTION as DRIVE
from refrobots.fpalette import DESCRIPTION as PALETTE
from refrobots.ftmd import DESCRIPTION as FTMD
from refrobots.motorcoreunit import DESCRIPTION as MOTOR
from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.can.decoding.decoder import Decoder
from rtgen.tools.can.decoding.node_index import NodeIndex, read_node_index

ROOT = Path(__file__).parents[2]

_DEVICES = (DRIVE, PALETTE, FTMD, MOTOR)
_NODES = (0, 1, 1, 1, 2, 3, 127)
_BASES = (
    *(0x000, 0x080, 0x100, 0x180, 0x200, 0x280, 0x300, 0x400, 0x500),
    *(0x580, 0x580, 0x600, 0x600, 0x600, 0x600, 0x700, 0x700),
)
_IDENTIFIERS = (0x000, 0x000, 0x080, 0x100, 0x7E4, 0x7E5, 0x7E5)
_COMMANDS = (0x01, 0x02, 0x80, 0x81, 0x82)
_STATES = (0x00, 0x04, 0x05, 0x7F, 0x85)
_SDO = (
    *(0x22, 0x23, 0x2B, 0x2F, 0x21, 0x20, 0x00, 0x10, 0x01, 0x11, 0x40, 0x60, 0x70),
    *(0xC0, 0xC2, 0xC4, 0xC6, 0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0x80, 0x81, 0xFF, 0x7F),
    *(0x43, 0x4F, 0x41, 0x42),
)
_LSS = (0x04, 0x11, 0x13, 0x15, 0x17, *range(0x40, 0x52), 0x5A, 0x5E)
_INDICES = (
    *(0x1000, 0x1003, 0x1005, 0x1006, 0x1008, 0x100C, 0x1010, 0x1011, 0x1012, 0x1014),
    *(0x1015, 0x1016, 0x1017, 0x1018, 0x1019, 0x1029, 0x1400, 0x1401, 0x1600, 0x1601),
    *(0x1800, 0x1801, 0x1A00, 0x1A01, 0x6040, 0x6041, 0x6060, 0x607A, 0x60FF, 0x1F80),
)
_PERIODS = (0, 0, 0, 1, 3, 20, 400, 3000)
_MAX_FRAMES = 300
"""Maximum number of frames in an answer: a block of segments and others that may be due."""
_MAX_POLLS = 20_000
_POLLS_BEFORE_STALL = 8
_COMPLETE = 31
"""One in that many inputs has all polls of each pause; in the others the host stalls."""


@dataclass(frozen=True, slots=True)
class Strange:
    """A frame, and the milliseconds after it."""

    frame: Frame
    pause: int

    def __bytes__(self) -> bytes:
        f = self.frame
        flags = f.remote | f.extended << 1
        head = f.can_id.to_bytes(4, "little") + bytes((flags, len(f.data)))
        return head + f.data.ljust(8, b"\0") + self.pause.to_bytes(2, "little")

    @classmethod
    def read(cls, data: bytes) -> Iterator[Strange]:
        """Yield all frames encoded in the octets."""
        for at in range(0, len(data), 16):
            each = data[at : at + 16]
            if len(each) < 6:
                return
            remote, extended = bool(each[4] & 1), bool(each[4] & 2)
            can_id = int.from_bytes(each[:4], "little")
            can_id &= 0x1FFFFFFF if extended else 0x7FF
            frame = Frame(can_id, each[6:14][: each[5]], remote, extended)
            yield cls(frame, int.from_bytes(each[14:], "little"))


def strange(chance: Random) -> Strange:
    """Return a frame that resembles those of the stations."""
    if chance.random() < 0.25:
        can_id = chance.choice(_IDENTIFIERS)
    else:
        can_id = chance.choice(_BASES) + chance.choice(_NODES)
    data = chance.randbytes(chance.choice((0, 1, 2, 4, 6, 8, 8, 8)))
    if can_id == 0:
        data = bytes((chance.choice(_COMMANDS), chance.choice(_NODES)))
    elif 0x580 < can_id <= 0x67F:
        index = chance.choice(_INDICES).to_bytes(2, "little")
        value = chance.choice((data[:4], b"\1", b"\x7f", b"\x80\1\0\x80", b"save"))
        more = (
            index + bytes((chance.choice((0, 0, 1, 2, 3, 5)),)) + value.ljust(4, b"\0")
        )
        data = bytes((chance.choice(_SDO) ^ (chance.random() < 0.1),)) + more
    elif 0x700 < can_id <= 0x77F:
        data = bytes((chance.choice(_STATES),))
    elif can_id in (0x7E4, 0x7E5):
        data = bytes((chance.choice(_LSS), chance.randrange(4))) + data[2:].ljust(
            6, b"\0"
        )
    if chance.random() < 0.05:
        data = chance.randbytes(chance.randrange(9))
    odd = chance.random()
    if odd < 0.02:
        can_id = chance.randrange(1 << 29)
    frame = Frame(can_id, data, 0.02 < odd < 0.04, odd < 0.02 or odd > 0.98)
    return Strange(frame, chance.choice(_PERIODS))


class _Target:
    """Common base of the targets: random frames."""

    longest = 400

    def __init__(self, _folder: Path) -> None:
        pass

    def make(self, number: int) -> bytes:
        """Return frames, and the time between them."""
        chance = Random(number)
        count = log_uniform(1, self.longest, chance.random())
        return b"".join(bytes(strange(chance)) for _ in range(count))


class NodeTarget(_Target):
    """The target of a slave alone."""

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Send the frames to the slave, and run what is due between them.

        A host that stalls polls the slave a few times, and then at the end of the pause.
        """
        node = DeviceNode(_DEVICES[number % 4], 1 if number % 7 else 255)
        stall = _POLLS_BEFORE_STALL if number % _COMPLETE else _MAX_POLLS
        now = 0
        _hold(node.boot(now))
        for each in Strange.read(data):
            _hold(node.receive(each.frame, now))
            end = now + each.pause * MILLISECOND
            polls = 0
            while (due := node.deadline) is not None and due <= end:
                now = max(due, now) if polls < stall else end
                _hold(node.poll(now))
                polls += 1
                if polls > _MAX_POLLS:
                    raise ViolationError(f"it is always due, at {due}")
            now = end
        yield node.state.name


class BusTarget(_Target):
    """The target of a manager, a proxy and two drives on a bus; a decoder listens, too."""

    longest = 40

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Send the frames; the other stations go on."""
        system = System()
        assert system.clock.network is not None
        bus = simulated_bus(system.clock.network, "can0", 1_000_000)
        listener = _Listener()
        bus.attach(listener)
        for node_id in (1, 2):
            node = DeviceNode(DRIVE, node_id)
            bus.attach(node)
            bus.send(node.boot(bus.now()), node)
            bus.refresh(node)
        manager = ManagerStation(bus, NETWORK)
        manager.start()
        proxy = EposDriveProxy("Left0")
        for name, value in (("node_id", "1"), ("bitrate", "1000000")):
            proxy.configuration_sets.set(name, value)
        system.add(proxy)
        system.run(3 * SECOND)
        system.activate("Left0")
        for each in Strange.read(data):
            if bus.up:
                bus.send([each.frame])
            system.run(system.time + each.pause * MILLISECOND)
            if number % 3 == 0 and each.pause > 300:
                system.reset("Left0")
        yield system.state("Left0").name
        yield from (node.phase.name for node in manager.nodes.values())
        yield from listener.kinds
        system.close()


class _Listener:
    """Decodes all frames on the bus."""

    identifiers = None
    deadline = None

    def __init__(self) -> None:
        self.kinds: set[str] = set()
        self._decoder = Decoder(_known())

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        decoded = self._decoder.decode(frame)
        str(decoded)
        decoded.to_json()
        self.kinds.add(decoded.kind)
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        return ()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()


@cache
def _known() -> NodeIndex:
    return read_node_index(ROOT / "specs/canopen/rh3_beego.toml", [])


def _hold(frames: Iterable[Frame]) -> None:
    count = len(list(frames))
    if count > _MAX_FRAMES:
        raise ViolationError(f"{count} frames at once")
