"""The protocol side of a CANopen slave (CiA 301): all its services and its NMT states.

It is a `Station` of a link, without I/O and without a clock; `node` adds the application's side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final, TypeAlias

from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectNumber,
)
from rtgen.runtime.canopen.node.device_pdos import DevicePdos
from rtgen.runtime.canopen.node.device_sync import DeviceSync, DeviceTime
from rtgen.runtime.canopen.node.emergency_producer import (
    COB_ID,
    INHIBIT_TIME,
    EmergencyProducer,
)
from rtgen.runtime.canopen.node.error_control import ErrorControl
from rtgen.runtime.canopen.node.heartbeat_consumers import CONSUMERS, HeartbeatConsumers
from rtgen.runtime.canopen.node.identity import lss_address, preset_identity
from rtgen.runtime.canopen.node.node_events import NodeEvents
from rtgen.runtime.canopen.node.object_dictionary import (
    COMMUNICATION,
    DeviceDictionary,
)
from rtgen.runtime.canopen.node.parameter_store import ParameterStore
from rtgen.runtime.canopen.node.sdo_servers import FURTHER_SERVERS, SdoServers
from rtgen.runtime.canopen.wire.emergency import HEARTBEAT_LOST
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    LSS_REQUEST,
    MAX_NODE_ID,
    NMT,
    Frame,
    earliest,
)
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatEvent, HeartbeatNews
from rtgen.runtime.canopen.wire.lss import UNCONFIGURED, LssAddress
from rtgen.runtime.canopen.wire.lss_slave import LssSlave
from rtgen.runtime.canopen.wire.nmt import (
    NmtCommand,
    NmtSlave,
    NmtState,
    Service,
    Transition,
    decode_command,
)

ERROR_BEHAVIOUR: Final = (0x1029, 1)
NMT_STARTUP: Final = (0x1F80, 0)

BUS_OFF_RECOVERED: Final = 0x8140
ID_COLLISION: Final = 0x8150

_RESETS_OF_ALL: Final = (
    (NmtCommand.RESET_NODE, 0),
    (NmtCommand.RESET_COMMUNICATION, 0),
)
_SELF_STARTING: Final = 8
_ALL: Final = range(0x10000)

Handler: TypeAlias = Callable[[Frame], None]
"""Processes a frame."""


class DeviceStation:
    """A slave, in INITIALISING until `NodeEvents.ready` or `DeviceNode.boot`.

    With `node_id` 255 it waits for LSS, even if the description does not list LSS. For
    `merged_stop` see `NmtSlave`. It starts by itself with `self_start`, or if 1F80h is 8 (CiA
    302-2). `serial_number` is the value of 1018h:4.
    """

    def __init__(
        self,
        description: DeviceDescription,
        node_id: int = UNCONFIGURED,
        *,
        events: NodeEvents | None = None,
        self_start: bool = False,
        merged_stop: bool = False,
        serial_number: int | None = None,
    ) -> None:
        self.description = description
        self.events = events or NodeEvents()
        self.self_start = self_start
        self.merged_stop = merged_stop
        self.serial_number = serial_number
        self.dictionary = DeviceDictionary(description, self._changed)
        self.errors = EmergencyProducer(self.dictionary)
        self.pdos = DevicePdos(
            self.dictionary, self.errors, self._on_rpdo, self.events.refused
        )
        self.store = ParameterStore(self.dictionary)
        self._has_lss = description.lss or node_id == UNCONFIGURED
        self.lss = self._lss_slave(node_id)
        self._consumers = HeartbeatConsumers(
            self.dictionary, self.errors, self._on_heartbeat
        )
        self._sync = DeviceSync(self.dictionary, self.errors)
        self._time = DeviceTime(self.dictionary)
        self._nmt: NmtSlave | None = None
        self._servers = SdoServers(self.dictionary)
        self._error_control = ErrorControl(self.dictionary, self.errors)
        self._effects: dict[ObjectNumber, None] = {}
        self._now = 0
        self._out: list[Frame] = []
        self.deadline: int | None = None
        """See `Station`."""
        self._handlers: dict[int, tuple[Handler, ...]] = {}
        self._identifiers: frozenset[int] | None = None
        """None if the handlers must be determined again."""
        self._power_on()

    # Station

    @property
    def identifiers(self) -> frozenset[int]:
        """See `Station`."""
        if self._identifiers is None:
            self._handlers = self._handlers_of_now()
            self._identifiers = frozenset((NMT, *self._handlers))
        return self._identifiers

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """See `Station`."""
        self._now = now
        if frame.can_id == NMT:
            self._obey(frame)
            return self._take_frames()
        if self._identifiers is None:
            self._identifiers = self.identifiers
        handlers = self._handlers.get(frame.can_id, ())
        if handlers and (
            frame.can_id == LSS_REQUEST or self.state is not NmtState.INITIALISING
        ):
            for handler in handlers:
                handler(frame)
        return self._take_frames()

    def poll(self, now: int) -> Iterable[Frame]:
        """See `Station`."""
        self._now = now
        if self._nmt is not None and self.state is not NmtState.INITIALISING:
            self._out += self._servers.poll(now)
            self._consumers.poll(now)
            if self._error_control.poll(now):
                self.errors.add(HEARTBEAT_LOST)
                self._communication_error()
            sync = self._sync.poll(now) if self._allows(Service.SYNC) else None
            if sync is not None:
                self._out.append(sync)
                self._synchronise(sync)
            self._out += self.pdos.poll(now)
            beat = self._error_control.beat(now, self.state)
            if beat is not None:
                self._out.append(beat)
        return self._take_frames()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """See `Station`: the loss of the bus is a communication error (1029h)."""
        self._now = now
        if self._nmt is None or self.state is NmtState.INITIALISING:
            return ()
        if up:
            self.errors.event(BUS_OFF_RECOVERED)
        else:
            self._servers.reset()
            self._communication_error()
        return self._take_frames()

    # State

    @property
    def node_id(self) -> int:
        """The node-id, 255 while unconfigured."""
        return self.lss.active

    @property
    def state(self) -> NmtState:
        """The NMT state."""
        return NmtState.INITIALISING if self._nmt is None else self._nmt.state

    # Life cycle

    def take_node_id(self, node_id: int) -> None:
        """Set the node-id before the first boot-up. Raises ValueError for an invalid one."""
        self._has_lss = self.description.lss or node_id == UNCONFIGURED
        self.lss = self._lss_slave(node_id)
        self._power_on()

    def _lss_slave(self, node_id: int) -> LssSlave:
        if node_id != UNCONFIGURED and not 1 <= node_id <= MAX_NODE_ID:
            raise ValueError(f"node-id {node_id}: it is 1 to {MAX_NODE_ID}, or 255")
        return LssSlave(
            self._address,
            node_id,
            self._activate_bit_rate,
            self.description.bit_rates,
        )

    def _power_on(self) -> None:
        self._load(_ALL)
        self._begin()

    def _begin(self) -> None:
        """Enter INITIALISING with the current node-id."""
        self._identifiers = self.deadline = None
        if self.node_id == UNCONFIGURED:
            self._nmt = None
            return
        self._nmt = NmtSlave(
            self.node_id,
            self_start=self.self_start or self._starts_itself(),
            merged_stop=self.merged_stop,
            stopping=self.events.stopping,
        )
        self._servers.begin(self.node_id)
        self._error_control.begin(self.node_id)

    def _load(self, indices: range) -> None:
        self.dictionary.load(self.node_id, indices)
        preset_identity(self.dictionary, self.description, self.serial_number)
        self.pdos.load(self.node_id)
        self.store.apply(indices)
        self._configure_all()
        self.errors.reset(whole=indices == _ALL)
        self.events.loaded(indices)

    def _configure_all(self) -> None:
        self._effects.clear()
        self.errors.configure()
        self.pdos.configure()
        self._sync.configure()

    def _boot(self) -> None:
        nmt = self._nmt
        if nmt is None or nmt.state is not NmtState.INITIALISING:
            return
        self._out.append(nmt.boot())
        self._consumers.configure()
        self._error_control.boot(nmt.node_id, self._now)
        self._sync.start(self._now)
        self._on_transition(Transition(NmtState.INITIALISING, nmt.state, None))

    def _obey(self, frame: Frame) -> None:
        if self._nmt is None:
            if decode_command(frame) in _RESETS_OF_ALL:
                self._assign()
            return
        self._on_transition(self._nmt.receive(frame))

    def _on_transition(self, transition: Transition | None) -> None:
        if transition is None:
            return
        if transition.before is NmtState.INITIALISING:
            self._identifiers = None
        if transition.before is NmtState.OPERATIONAL:
            self.pdos.stop()
        if transition.after is NmtState.INITIALISING and self._nmt is not None:
            self._initialise(self._nmt.reset)
        elif transition.after is NmtState.STOPPED:
            self._servers.reset()
        elif transition.after is NmtState.OPERATIONAL:
            self.pdos.start(self._now)
        if transition.before is NmtState.STOPPED:
            self._sync.start(self._now)
        self.events.moved(transition)
        if self.state is NmtState.INITIALISING and self.events.ready():
            self._boot()

    def _initialise(self, command: NmtCommand) -> None:
        whole = command is NmtCommand.RESET_NODE
        self.lss.take_over(stored=whole)
        self._consumers.reset()
        self._load(_ALL if whole else COMMUNICATION)
        self._begin()

    def _assign(self) -> None:
        """Apply the node-id assigned by LSS to an unconfigured node."""
        if self.lss.pending.node_id == UNCONFIGURED:
            return
        self.lss.take_over(stored=False)
        self._load(_ALL)
        self._begin()
        if self.events.ready():
            self._boot()

    def _configure_layers(self, frame: Frame) -> None:
        if not self._has_lss:
            return
        before = self.lss.configuring
        self._out += self.lss.receive(frame)
        if self._nmt is None and before and not self.lss.configuring:
            self._assign()

    # Services

    def _allows(self, service: Service) -> bool:
        return self._nmt is not None and self._nmt.allows(service)

    def _handlers_of_now(self) -> dict[int, tuple[Handler, ...]]:
        """Return the handlers by CAN identifier."""
        handlers: dict[int, tuple[Handler, ...]] = {}

        def add(can_id: int, handler: Handler) -> None:
            handlers[can_id] = (*handlers.get(can_id, ()), handler)

        if self._has_lss:
            add(LSS_REQUEST, self._configure_layers)
        if self._nmt is None:
            return handlers
        node_id = self.node_id
        # Identifiers that only this node sends.
        for can_id in self._servers.responses:
            add(can_id, self._collide)
        add(ERROR_CONTROL + node_id, self._take_guarding)
        if self.errors.can_id is not None:
            add(self.errors.can_id, self._collide)
        for can_id in self._servers.requests:
            add(can_id, self._serve_sdo)
        for can_id in self._sync.identifiers:
            add(can_id, self._synchronise)
        for can_id in self._consumers.identifiers:
            add(can_id, self._take_heartbeat)
        for can_id in self._time.identifiers:
            add(can_id, self._take_time)
        for can_id in self.pdos.identifiers:
            add(can_id, self._serve_pdo)
        return handlers

    def _serve_sdo(self, frame: Frame) -> None:
        if self._allows(Service.SDO):
            self._out += self._servers.receive(frame, self._now)

    def _serve_pdo(self, frame: Frame) -> None:
        if self._allows(Service.PDO):
            self._out += self.pdos.receive(frame, self._now)

    def _take_heartbeat(self, frame: Frame) -> None:
        self._consumers.receive(frame, self._now)

    def _collide(self, frame: Frame) -> None:
        if frame.extended or frame.remote or self.errors.present(ID_COLLISION):
            return
        self.errors.add(ID_COLLISION)
        self.events.collided(frame.can_id)

    def _take_guarding(self, frame: Frame) -> None:
        if not frame.remote:
            self._collide(frame)
        elif not frame.extended:
            response = self._error_control.answer(self.node_id, self.state, self._now)
            if response is not None:
                self._out.append(response)

    def _synchronise(self, frame: Frame) -> None:
        if not self._allows(Service.SYNC):
            return
        counter = self._sync.counter(frame)
        if counter is not None and self._allows(Service.PDO):
            self._out += self.pdos.sync(counter, self._now)

    def _take_time(self, frame: Frame) -> None:
        moment = self._time.moment(frame)
        if moment is not None and self._allows(Service.TIME):
            self.events.time(moment)

    def _communication_error(self) -> None:
        """Handle a communication error according to 1029h:1; by default leave OPERATIONAL."""
        if self._nmt is None:
            return
        behaviour = self.dictionary.number(ERROR_BEHAVIOUR)
        if behaviour == 2:
            self._out += self.errors.take(self._now, at_once=True)
            self._on_transition(self._nmt.go(NmtState.STOPPED))
        elif behaviour == 0 and self.state is NmtState.OPERATIONAL:
            self._on_transition(self._nmt.go(NmtState.PRE_OPERATIONAL))

    def _on_heartbeat(self, node_id: int, event: HeartbeatEvent) -> None:
        # Notified first, since it is the reason for the change of state.
        self.events.heard(node_id, event)
        if event.news is HeartbeatNews.LOST:
            self._communication_error()

    def _on_rpdo(self, number: int) -> None:
        self.events.received(number)

    def _activate_bit_rate(self, bit_rate: int, delay: int) -> None:
        self.events.bit_rate(bit_rate, delay)

    # Object dictionary

    def _address(self) -> LssAddress:
        return lss_address(self.dictionary, self.description, self.serial_number)

    def _starts_itself(self) -> bool:
        return self.dictionary.number(NMT_STARTUP) == _SELF_STARTING

    def _changed(self, number: ObjectNumber) -> None:
        if number[0] in COMMUNICATION:
            self._effects[number] = None
        self.pdos.changed(number)

    def _settle(self) -> None:
        """Apply written parameters."""
        effects, self._effects = self._effects, {}
        self._identifiers = None
        indices = {number[0] for number in effects}
        if indices & {COB_ID, INHIBIT_TIME}:
            self.errors.configure()
        if indices & DeviceSync.indices:
            self._sync.configure()
        if not indices.isdisjoint(FURTHER_SERVERS):
            self._servers.configure()
        if self.state is NmtState.INITIALISING:
            return
        if indices & DeviceSync.indices:
            self._sync.start(self._now)
        if CONSUMERS in indices:
            self._consumers.configure()
        self._error_control.configure(indices, self._now)

    def _take_frames(self) -> list[Frame]:
        if self._effects:
            self._settle()
        self._out += self.pdos.flush(self._now)
        if self.errors.deadline is not None and self._allows(Service.EMERGENCY):
            self._out += self.errors.take(self._now)
        self.deadline = self._next_deadline()
        frames, self._out = self._out, []
        return frames

    def _next_deadline(self) -> int | None:
        if self._nmt is None or self._nmt.state is NmtState.INITIALISING:
            return None
        is_reported = self._allows(Service.EMERGENCY)
        return earliest(
            self._error_control.deadline,
            self._servers.deadline,
            self.pdos.deadline,
            self._consumers.deadline,
            self.errors.deadline if is_reported else None,
            self._sync.deadline if self._allows(Service.SYNC) else None,
        )
