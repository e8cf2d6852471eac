"""A node as seen by its proxy: a station that receives PDOs, heartbeats and emergencies."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping
from typing import Final, Protocol

import msgspec

from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Network,
    NodeDescription,
    PdoDescription,
)
from rtgen.runtime.canopen.hooks import Receiver
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.runtime.canopen.wire.emergency import Emergency, emergency_in
from rtgen.runtime.canopen.wire.frames import (
    EMERGENCY,
    ERROR_CONTROL,
    NMT,
    CobId,
    Frame,
    earliest,
)
from rtgen.runtime.canopen.wire.guarding import NodeGuard
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatConsumer, HeartbeatNews
from rtgen.runtime.canopen.wire.nmt import NmtState, decode_command
from rtgen.runtime.canopen.wire.pdo_transmission import (
    EVENT_PROFILE,
    SYNC_ACYCLIC,
    PdoParameters,
    TpdoTransmitter,
    is_synchronous,
)
from rtgen.runtime.canopen.wire.sync import PREDEFINED_SYNC, sync_counter

QUEUE: Final = 4096
"""Capacity of the queue of PDOs for the proxy's next tick; the oldest are dropped."""
_FLIPS: Final = 4
"""Number of alternating states within two heartbeat periods that indicates a second node."""


class Wiring(msgspec.Struct, frozen=True):
    """The PDOs of a node by number: those that its proxy receives and those it sends.

    `unsent` gives the reason why the proxy does not send the others.
    """

    received: Mapping[int, PdoDescription]
    sent: Mapping[int, PdoDescription]
    unsent: Mapping[int, str]


def wiring(
    description: DeviceDescription, node_id: int, network: Network | None = None
) -> Wiring:
    """Return the PDOs of the network, falling back to those of the device description.

    An RPDO with the COB-ID of another node's TPDO is linked to that TPDO, and not sent by the
    proxy.
    """
    node = None if network is None else network.node(node_id)
    pdos = description.pdos if node is None else node.pdos
    others = set() if network is None else _transmitted(network, node)
    received: dict[int, PdoDescription] = {}
    sent: dict[int, PdoDescription] = {}
    unsent: dict[int, str] = {}
    for pdo in pdos:
        cob_id = CobId(pdo.cob_id_of(node_id))
        if not cob_id.valid:
            if pdo.direction == "rpdo":
                unsent[pdo.number] = "it is not valid"
            continue
        if pdo.direction == "tpdo":
            received[pdo.number] = pdo
        elif (cob_id.can_id, cob_id.extended) in others:
            unsent[pdo.number] = "another node sends it"
        else:
            sent[pdo.number] = pdo
    return Wiring(received, sent, unsent)


def _transmitted(
    network: Network, but: NodeDescription | None
) -> set[tuple[int, bool]]:
    """Return the PDOs sent by other nodes: identifiers, and whether they have 29 bits."""
    found = set()
    for node in network.nodes:
        for pdo in node.pdos if node is not but else ():
            cob_id = CobId(pdo.cob_id_of(node.id))
            if pdo.direction == "tpdo" and cob_id.valid:
                found.add((cob_id.can_id, cob_id.extended))
    return found


def transmitter_of(pdo: PdoDescription, node_id: int) -> TpdoTransmitter:
    """Return the transmitter of an RPDO of the node.

    A synchronous RPDO is sent with its latest value at each SYNC, since the node applies one per
    SYNC. Others are sent for every value, or with the latest one after the inhibit time.
    """
    synchronous = is_synchronous(pdo.transmission_type)
    return TpdoTransmitter(
        PdoParameters(
            cob_id=pdo.cob_id_of(node_id),
            transmission_type=SYNC_ACYCLIC if synchronous else EVENT_PROFILE,
            inhibit_time=pdo.inhibit_time,
        )
    )


class Watcher(Protocol):
    """Observer of a node; called with the link's lock held."""

    def timeout(self) -> int:
        """Return the current heartbeat time-out in ns; 0 for none."""

    def received(self) -> None:
        """Called for a PDO."""

    def malformed(self, number: int, octets: int, expected: int) -> None:
        """Called for a TPDO of a wrong length, the first one after those of the right length."""

    def unusable(self, number: int, why: str) -> None:
        """Called for a TPDO with a value that no port can have, the first one after others."""

    def booted(self, node: ProxiedNode) -> None:
        """Called for a boot-up message."""

    def beat(self, node: ProxiedNode, state: NmtState) -> None:
        """Called for a heartbeat."""

    def lost(self, node: ProxiedNode) -> None:
        """Called when the heartbeat is overdue."""

    def clashed(self, node: ProxiedNode) -> None:
        """Called when heartbeats contradict each other."""

    def on_emergency(self, node: ProxiedNode, emergency: Emergency) -> None:
        """Called for an emergency message."""

    def cut_off(self, node: ProxiedNode) -> None:
        """Called when the bus is lost."""


class ReceivedPdo(msgspec.Struct):
    """A TPDO of the device.

    `malformed`: the last one had a wrong length; `unusable`: a value that its port cannot have.
    """

    number: int
    receiver: Receiver
    extended: bool
    size: int
    too_short: int = 0
    too_long: int = 0
    malformed: bool = False
    unusable: bool = False


class ProxiedNode:
    """The station of one node. `transmitters` are those of its RPDOs.

    `sync` is the COB-ID of SYNC, `emergency` that of the node's emergencies, None: predefined.

    While `listening`, PDOs are queued in `queue` with their data and times. `boots` counts
    boot-up messages, `emergencies` emergency messages; `emergency` is the latest one that has not
    been cleared. `dropped` counts PDOs lost because the queue was full, `refused` those with a
    value that its port cannot have.
    """

    deadline: int | None

    def __init__(
        self,
        node_id: int,
        received: Mapping[int, PdoDescription],
        receivers: Mapping[int, Receiver],
        watcher: Watcher,
        transmitters: Collection[TpdoTransmitter] = (),
        sync: CobId = PREDEFINED_SYNC,
        emergency: CobId | None = None,
    ) -> None:
        self.node_id = node_id
        self.queue: deque[tuple[ReceivedPdo, bytes, int]] = deque(maxlen=QUEUE)
        self.listening = False
        self.dropped = 0
        self.refused = 0
        self.boots = 0
        self.emergencies = 0
        self.emergency: Emergency | None = None
        self._watcher = watcher
        self._consumer = HeartbeatConsumer(node_id, 0)
        self._guard = NodeGuard(node_id)
        self.guarded = False
        """Whether it is polled by node guarding, or was when it was lost."""
        self._heartbeat_id = ERROR_CONTROL + node_id
        emergency = emergency or CobId(EMERGENCY + node_id)
        self._emergency = emergency if emergency.valid else None
        self._flips: deque[int] = deque(maxlen=_FLIPS)
        self._pdos: dict[int, ReceivedPdo] = {}
        for number, pdo in received.items():
            if number in receivers:
                cob_id = CobId(pdo.cob_id_of(node_id))
                bits = sum(bits for _, _, bits in pdo.mapping)
                self._pdos[cob_id.can_id] = ReceivedPdo(
                    number, receivers[number], cob_id.extended, (bits + 7) // 8
                )
        self._transmitters = tuple(transmitters)
        self._at_sync = tuple(t for t in transmitters if t.synchronous)
        self._sync = sync if self._at_sync and sync.configurable else None
        others = (each.can_id for each in (self._emergency, self._sync) if each)
        self.identifiers = frozenset((NMT, self._heartbeat_id, *self._pdos, *others))
        self.deadline = None

    @property
    def state(self) -> NmtState | None:
        """The last reported NMT state; None before the first, and after the node is lost."""
        return self._consumer.state

    @property
    def timeout(self) -> int:
        """The time-out of the supervision in ns; 0 without supervision."""
        return self._consumer.timeout

    @property
    def too_short(self) -> int:
        """PDOs that were dropped because they were too short."""
        return sum(pdo.too_short for pdo in self._pdos.values())

    @property
    def too_long(self) -> int:
        """PDOs that were truncated because they were too long."""
        return sum(pdo.too_long for pdo in self._pdos.values())

    @property
    def overwritten(self) -> int:
        """Values of RPDOs that were replaced by newer ones before they were sent."""
        return sum(transmitter.overwritten for transmitter in self._transmitters)

    def listen(self, now: int) -> None:
        """Start receiving and sending PDOs."""
        if not self.listening:
            self.queue.clear()
            self.listening = True
            for transmitter in self._transmitters:
                transmitter.start(now)

    def pause(self) -> None:
        """Stop receiving and sending PDOs; unsent values are dropped."""
        self.listening = False
        for transmitter in self._transmitters:
            transmitter.stop()
        self._set_deadline()

    def guard(self, period: int, now: int) -> None:
        """Poll the node by node guarding, every `period` ns, until it boots or is lost."""
        self.guarded = True
        self._guard.start(period, now)
        self._consumer.configure(self._watcher.timeout(), now)
        self._consumer.watch(now)
        self._set_deadline()

    def transmit(
        self, values: Iterable[tuple[TpdoTransmitter, bytes]], now: int
    ) -> list[Frame]:
        """Set values of RPDOs; return the frames to send immediately."""
        frames = [transmitter.update(data, now) for transmitter, data in values]
        self._set_deadline()
        return [frame for frame in frames if frame is not None]

    def command_sent(self) -> None:
        """Record that an NMT command was sent, so that a change of state is expected."""
        self._flips.clear()

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """See `Station`."""
        can_id = frame.can_id
        pdo = self._pdos.get(can_id)
        if pdo is not None:
            if self.listening and frame.extended is pdo.extended and not frame.remote:
                self._take(pdo, frame.data, now)
        elif can_id == self._heartbeat_id:
            self._on_heartbeat(frame, now)
        elif self._emergency is not None and self._emergency.carries(frame):
            self._on_emergency(frame)
        elif can_id == NMT:
            command = decode_command(frame)
            if command is not None and command[1] in (0, self.node_id):
                self.command_sent()
        elif self._is_sync(frame):
            frames = (t.sync(0, now) for t in self._at_sync)
            return [each for each in frames if each is not None]
        return ()

    def _is_sync(self, frame: Frame) -> bool:
        sync = self._sync
        if sync is None or frame.remote or not sync.carries(frame):
            return False
        return sync_counter(frame) is not None

    def poll(self, now: int) -> Iterable[Frame]:
        """See `Station`."""
        event = self._consumer.poll(now)
        if event is not None:
            self._guard.stop()
        frames = [self._guard.poll(now), *(t.poll(now) for t in self._transmitters)]
        self._set_deadline()
        if event is not None:
            self._watcher.lost(self)
        return [frame for frame in frames if frame is not None]

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """See `Station`: the known state of the node becomes invalid."""
        self._consumer = HeartbeatConsumer(self.node_id, 0)
        self._guard.stop()
        self._set_deadline()
        if not up:
            self._watcher.cut_off(self)
        return ()

    def refuse(self, pdo: ReceivedPdo, error: PdoError) -> None:
        """Count a PDO with a value that its port cannot have; report the first one."""
        self.refused += 1
        if not pdo.unusable:
            pdo.unusable = True
            self._watcher.unusable(pdo.number, str(error))

    def _take(self, pdo: ReceivedPdo, data: bytes, now: int) -> None:
        was_malformed, pdo.malformed = pdo.malformed, len(data) != pdo.size
        if pdo.malformed:
            if not was_malformed:
                self._watcher.malformed(pdo.number, len(data), pdo.size)
            if len(data) < pdo.size:
                pdo.too_short += 1
                return
            pdo.too_long += 1
            data = data[: pdo.size]
        queue = self.queue
        if len(queue) == QUEUE:
            self.dropped += 1
        queue.append((pdo, data, now))
        self._watcher.received()

    def _set_deadline(self) -> None:
        self.deadline = earliest(
            self._consumer.deadline,
            self._guard.deadline,
            *[transmitter.deadline for transmitter in self._transmitters],
        )

    def _on_heartbeat(self, frame: Frame, now: int) -> None:
        if frame.remote or not self._guard.accepts(frame):
            return
        before = self._consumer.state
        self._consumer.configure(self._watcher.timeout(), now)
        event = self._consumer.receive(frame, now)
        if event is not None and event.news is HeartbeatNews.BOOT_UP:
            self._guard.stop()
            self._set_deadline()
            self.boots += 1
            self._flips.clear()
            self._watcher.booted(self)
            return
        self._set_deadline()
        state = self._consumer.state
        if state is None or frame.extended:
            return
        operational = NmtState.OPERATIONAL
        if before is not None and (before is operational) != (state is operational):
            self._flips.append(now)
            if self._contradictory():
                self._watcher.clashed(self)
                return
        self._watcher.beat(self, state)

    def _contradictory(self) -> bool:
        flips = self._flips
        return len(flips) == _FLIPS and 3 * (flips[-1] - flips[0]) < 2 * self.timeout

    def _on_emergency(self, frame: Frame) -> None:
        emergency = emergency_in(frame)
        if emergency is None:
            return
        self.emergencies += 1
        self.emergency = None if emergency.cleared else emergency
        self._watcher.on_emergency(self, emergency)
