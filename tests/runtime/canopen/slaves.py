"""A slave for tests of managers, with faults on demand."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SDO_REQUEST, Frame
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatProducer
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtSlave, NmtState, Service
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

MS = 1_000_000
Number = tuple[int, int]
IDENTITY = (0x00020192, 0x9A, 0x1234, 0x00010002, 77)


class Slave:
    """Boots after `boot_time` ns, has a table of values, and a heartbeat by 1017h."""

    def __init__(self, node_id: int, identity: tuple[int, ...] = IDENTITY) -> None:
        self.node_id = node_id
        self.nmt = NmtSlave(node_id)
        self.values: dict[Number, bytes] = {
            (0x1000, 0): identity[0].to_bytes(4, "little"),
            (0x1017, 0): bytes(2),
            **{(0x2000 + index, 0): bytes(4) for index in range(8)},
            **{
                (0x1018, 1 + index): number.to_bytes(4, "little")
                for index, number in enumerate(identity[1:])
            },
        }
        self.writes: list[tuple[Number, bytes]] = []
        self.commands: list[NmtCommand] = []
        self.refused: dict[Number, int] = {}
        self.forgetful: set[Number] = set()
        self.boot_time = MS
        self.dead = False
        self.obeys: Callable[[NmtCommand], bool] = lambda command: True
        self.identifiers = frozenset((0, SDO_REQUEST + node_id))
        self._server = SdoServer(node_id, self)
        self._heartbeat = HeartbeatProducer(node_id)
        self._boot_at: int | None = None

    # The object dictionary.

    def read(self, index: int, subindex: int) -> bytes:
        if (index, subindex) not in self.values:
            raise SdoAbort(sdo.NO_OBJECT)
        return self.values[index, subindex]

    def writable_size(self, index: int, subindex: int) -> int:
        return len(self.read(index, subindex)) if index < 0x2000 else 1000

    def write(self, index: int, subindex: int, value: bytes) -> None:
        number = index, subindex
        if number in self.refused:
            raise SdoAbort(self.refused[number])
        self.writes.append((number, value))
        if number not in self.forgetful:
            self.values[number] = value

    # The station.

    @property
    def deadline(self) -> int | None:
        if self.dead:
            return None
        times = (self._boot_at, self._heartbeat.deadline, self._server.deadline)
        return min((time for time in times if time is not None), default=None)

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        if self.dead:
            return []
        if frame.can_id:
            if not self.nmt.allows(Service.SDO):
                return []
            before = self.values[0x1017, 0]
            frames = self._server.receive(frame, now)
            if self.values[0x1017, 0] != before:
                period = int.from_bytes(self.values[0x1017, 0], "little")
                self._heartbeat.configure(period * MS, now)
            return frames
        command = NmtCommand(frame.data[0])
        if frame.data[1] not in (0, self.node_id) or not self.obeys(command):
            return []
        self.commands.append(command)
        self.nmt.receive(frame)
        if self.nmt.state is NmtState.INITIALISING:
            self.power_on(now)
        return []

    def power_on(self, now: int) -> None:
        """Start again; the values of 1017h and from 2000h on are lost."""
        self.nmt = NmtSlave(self.node_id)
        self._heartbeat = HeartbeatProducer(self.node_id)
        self._server = SdoServer(self.node_id, self)
        for number in self.values:
            if number[0] >= 0x1017 and number[0] != 0x1018:
                self.values[number] = bytes(len(self.values[number]))
        self._boot_at = now + self.boot_time

    def poll(self, now: int) -> Iterable[Frame]:
        if self.dead:
            return
        if self._boot_at is not None and now >= self._boot_at:
            self._boot_at = None
            yield self.nmt.boot()
        heartbeat = self._heartbeat.poll(now, self.nmt.state)
        if heartbeat is not None:
            yield heartbeat
        yield from self._server.poll(now)

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()
