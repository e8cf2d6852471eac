"""The component of a CANopen device: a slave whose NMT states follow those of an RT component.

Source: the published description of RTC-CANopen (table 3 and figure 110). The callbacks for each
NMT command are listed in `docs/canopen.md`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Final

from rtgen.facts.canopen_parameters import COMPONENT_FACTS
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.configuration import DeviceConfiguration
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.hooks import DeviceHooks, Incoming, Outgoing
from rtgen.runtime.canopen.node.identity import SERIAL_NUMBER
from rtgen.runtime.canopen.node.node import USER_SOFTWARE, DeviceNode
from rtgen.runtime.canopen.node.node_events import NodeEvents
from rtgen.runtime.canopen.node.parameter_file import ParameterFile
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.runtime.canopen.wire.frames import CobId, Frame
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatEvent, HeartbeatNews
from rtgen.runtime.canopen.wire.lss import UNCONFIGURED
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, Transition
from rtgen.runtime.canopen.wire.pdo_transmission import RTR, RTR_SYNC
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.failures import log
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_OK,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.life_cycle import Request

_BUFFER: Final = {"dataport.buffer.length": "64"}
"""Buffer between ports and the bus; overwritten samples count as lost."""


class CanopenDevice(DeviceHooks, Component, **COMPONENT_FACTS):
    """Base class of generated devices; the device is on the bus from its initialization.

    Changes of `objects` and samples written to OutPorts are transmitted at the end of the tick.
    `node` offers hooks and errors to a behaviour: calls of its methods from outside its callbacks
    must hold `bus_lock`.
    """

    config: Any
    """The `DeviceConfiguration`."""
    self_start = False
    """Whether the device enters OPERATIONAL without a master."""
    merged_stop = False
    """Whether a stop command has the meaning of figure 111; see `NmtSlave`.

    The configuration parameter of the same name overrides it when the device joins its bus.
    """

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.node = DeviceNode(
            self.description,
            events=NodeEvents(
                moved=self._on_transition,
                received=self._on_rpdo,
                refused=self._on_refused,
                heard=self._on_heartbeat,
                collided=self._on_collision,
                bit_rate=self._on_bit_rate,
                stopping=self._can_end,
                ready=self._can_boot,
            ),
        )
        self._link: Link | None = None
        self._incoming_by_number: Mapping[int, Incoming] = {}
        self._inlets: dict[str, OutPort[Any]] = {}
        self._outlets: list[tuple[str, InPort[Any], Outgoing]] = []
        self._connectors: list[DataConnector[Any]] = []
        self.observables["overwritten"] = lambda: (self.node.pdos.overwritten,)
        self.observables["refused"] = lambda: (self.node.pdos.refused + self._refused,)
        self._refused = 0
        self._unusable: dict[int, bool] = {}
        """RPDOs with a refused value: whether it is one of the PDO that is being received."""
        self._was: LifeCycleState = INACTIVE_STATE
        self._resetting = False
        self._ending = False
        self._stopped_by = ""
        self._stop_pending = False
        """Whether ERROR was requested since the node had stopped, and is still pending."""
        self._follow_up: Request | None = None
        """The pending request that follows the node's state, and does not change it."""

    # Object dictionary

    @property
    def bus_lock(self) -> AbstractContextManager[object]:
        """The lock of the link; while it is held, the bus does not call the node."""
        return nullcontext() if self._link is None else self._link.lock

    def get_object(self, number: ObjectNumber) -> ObjectValue:
        """See `DeviceHooks`."""
        return self.node.dictionary.get(number)

    def set_object(self, number: ObjectNumber, value: ObjectValue) -> None:
        """See `DeviceHooks`."""
        with self.bus_lock:
            self.node.dictionary.set(number, value)

    # Life cycle

    def initialize(self) -> ReturnCode_t:
        """Initialize the component; the boot-up message follows `on_initialize`."""
        if self._alive:
            return PRECONDITION_NOT_MET
        self.configuration_sets.apply()
        try:
            link = self._join_bus()
        except (LinkError, ValueError) as error:
            self.reason = str(error)
            return ReturnCode_t.RTC_ERROR
        code = super().initialize()
        if code is not RTC_OK:
            self._leave_bus()
            return code
        with link.lock:
            self._send(self.node.boot(link.now()))
        self._at_end_of_cycle(self._end_of_tick)
        return RTC_OK

    def finalize(self) -> ReturnCode_t:
        """Finalize the component and leave the bus."""
        code = super().finalize()
        if not self._alive:
            self._leave_bus()
        return code

    @property
    def lost(self) -> int:
        """Samples lost at the ports, including those between OutPorts and the bus."""
        return super().lost + sum(port.lost for _, port, _ in self._outlets)

    def _join_bus(self) -> Link:
        config: DeviceConfiguration = self.config
        node = self.node
        self.merged_stop = self.merged_stop or config.merged_stop
        node.self_start, node.merged_stop = self.self_start, self.merged_stop
        if config.parameter_file:
            self._keep_parameters(
                ParameterFile(config.parameter_file, self.description)
            )
        node_id = config.node_id
        self._distinguish(node_id)
        node.take_node_id(node_id)
        link = self._link = open_link(
            self, config.interface, config.channel, config.bitrate, config.options
        )
        self._connect_ports()
        with link.lock:
            link.attach(node)
        self._warn_of_requests(link)
        return link

    def _distinguish(self, node_id: int) -> None:
        """Use the node-id as serial number, if there is none: LSS addresses are unique then."""
        serial = self.description.by_number.get(SERIAL_NUMBER)
        is_described = serial is not None and serial.initial(node_id)
        if self.node.serial_number is None and not is_described:
            self.node.serial_number = None if node_id == UNCONFIGURED else node_id

    def _keep_parameters(self, file: ParameterFile) -> None:
        """Load the stored parameters from a file, and save them when they change."""

        def keep(stored: Mapping[ObjectNumber, bytes]) -> None:
            try:
                file.write(stored)
            except OSError as error:
                log.warning(
                    "%s: parameters cannot be stored: %s", self.instance_name, error
                )
                raise

        self.node.store.values = file.read()
        self.node.store.keep = keep

    def _warn_of_requests(self, link: Link) -> None:
        """Warn of TPDOs that are only sent on remote frames, if the link has none."""
        for pdo in self.description.pdos:
            cob_id = CobId(pdo.cob_id_of(self.node.node_id))
            if pdo.direction != "tpdo" or not cob_id.valid:
                continue
            if pdo.transmission_type not in (RTR_SYNC, RTR):
                continue
            why = "its COB-ID allows none" if cob_id.bit30 else ""
            if not link.carries_remote_frames:
                why = f"{link} carries none"
            if why:
                log.warning(
                    "%s: samples written to tpdo%d are never sent: its transmission type %d "
                    "waits for a remote frame, and %s",
                    *(self.instance_name, pdo.number, pdo.transmission_type, why),
                )

    def _leave_bus(self) -> None:
        link, self._link = self._link, None
        if link is not None:
            link.detach(self.node)
        for connector in self._connectors:
            connector.detach()
        self._connectors.clear()

    def _connect_ports(self) -> None:
        self._incoming_by_number = self._incoming()
        bus = f"{self.instance_name}.bus"
        for name in self._fed_ports():
            in_port = self.in_ports[name]
            source = self._inlets[name] = OutPort(name, in_port.type, bus)
            self._connect(name, source, in_port)
        self._outlets = []
        for name, outgoing in self._outgoing().items():
            out_port = self.out_ports[name]
            target = InPort(name, out_port.type, bus)
            target._protect(self._clock.guard())
            self._connect(name, out_port, target)
            self._outlets.append((name, target, outgoing))

    def _fed_ports(self) -> list[str]:
        """Return the InPorts written by RPDOs; a behaviour may have further InPorts."""

        def get(number: ObjectNumber) -> ObjectValue:
            return values.zero(self.description.by_number[number].kind)

        incoming_values = (
            incoming(get, 0) for incoming in self._incoming_by_number.values()
        )
        return list(
            dict.fromkeys(name for samples in incoming_values for name, _ in samples)
        )

    def _connect(self, name: str, source: OutPort[Any], target: InPort[Any]) -> None:
        connector = DataConnector(
            f"{self.instance_name}.{name}", source, target, _BUFFER, self._clock.guard
        )
        connector.attach()
        self._connectors.append(connector)

    # Ticks

    def _end_of_tick(self) -> None:
        link = self._link
        if link is None:
            return
        self._at_end_of_cycle(self._end_of_tick)
        with link.lock:
            now = link.now()
            due = self.node.deadline
            frames = [*self._samples(now), *self.node.flush(now), *self._settle(now)]
            if frames or self.node.deadline != due:
                self._send(frames)

    def _samples(self, now: int) -> list[Frame]:
        """Write new samples of OutPorts to the object dictionary; one sample of each at a time."""
        frames: list[Frame] = []
        while fresh := [outlet for outlet in self._outlets if outlet[1].is_new()]:
            written: list[ObjectNumber] = []

            def take(number: ObjectNumber, value: ObjectValue) -> None:
                self.node.dictionary.set(number, value)
                written.append(number)  # noqa: B023

            for name, port, outgoing in fresh:
                try:
                    outgoing(port.read(), take)
                except ValueError as error:
                    self._request_failure(f"{name}: {error}")
            for number in written:
                self.node.trigger(*number)
            frames += self.node.flush(now)
        return frames

    def _send(self, frames: list[Frame]) -> None:
        link = self._link
        if link is None:
            return
        try:
            if frames:
                link.send(frames, self.node)
        except LinkError as error:
            log.warning("%s: %s", self.instance_name, error)
        link.refresh(self.node)

    # States

    def _gate(self, request: Request) -> ReturnCode_t | None:
        link = self._link
        if link is None:
            return RTC_OK
        with link.lock:
            now, state = link.now(), self.node.state
            is_own, self._follow_up = request is self._follow_up, None
            if request is Request.ACTIVATE:
                if state is NmtState.OPERATIONAL:
                    return RTC_OK
                if not (self.self_start and state is NmtState.PRE_OPERATIONAL):
                    self._awaited = "the NMT master's start"
                    return None
                self._send(self.node.go(NmtState.OPERATIONAL, now))
            elif request is Request.DEACTIVATE:
                self._ending, self.reason = True, ""
                if state is NmtState.OPERATIONAL and not is_own:
                    self._send(self.node.go(NmtState.PRE_OPERATIONAL, now))
            elif request is Request.RESET:
                self._resetting = True
                if state is NmtState.STOPPED and not is_own:
                    self._send(self.node.reset(now))
        return RTC_OK

    def _settle(self, now: int) -> list[Frame]:
        """Synchronize the states of component and node at the end of a tick."""
        state, before = self._state(), self._was
        self._was = state
        was_reset, self._resetting = self._resetting, False
        was_ended, self._ending = self._ending, False
        node = self.node
        frames: list[Frame] = []
        if state is ERROR_STATE:
            stopped, self._stop_pending = self._stop_pending, False
            failed = was_reset or (before is not ERROR_STATE and not stopped)
            if failed and node.state is not NmtState.STOPPED:
                return node.fail(now)
        elif before is ERROR_STATE:
            node.remove_error(USER_SOFTWARE)
        if was_ended and self.reason and self.merged_stop:
            frames += node.fail(now)
        if node.state is NmtState.INITIALISING and self._can_boot():
            frames += node.boot(now)
        self._follow()
        return frames + node.flush(now)

    def _on_transition(self, transition: Transition) -> None:
        if transition.command is NmtCommand.STOP:
            self._stopped_by = "stopped by the NMT master"
        if not self._resetting:
            self._follow()

    def _follow(self) -> None:
        """Request the component state that corresponds to the node's NMT state (table 3)."""
        nmt = self.node.state
        for context in tuple(self._contexts.values()):
            state = context.get_component_state(self)
            if nmt is NmtState.STOPPED:
                if state is not ERROR_STATE:
                    self._stop_pending = True
                    self._request_failure(self._stopped_by or "its node has stopped")
            elif state is ERROR_STATE:
                self._follow_up = Request.RESET
                context.reset_component(self)
            elif nmt is NmtState.OPERATIONAL and state is INACTIVE_STATE:
                context.activate_component(self)
            elif nmt is not NmtState.OPERATIONAL and state is ACTIVE_STATE:
                self._follow_up = Request.DEACTIVATE
                context.deactivate_component(self)

    def _state(self) -> LifeCycleState:
        """Return the component's state in its first context; INACTIVE without a context."""
        for context in tuple(self._contexts.values()):
            return context.get_component_state(self)
        return INACTIVE_STATE

    def _can_boot(self) -> bool:
        return not self._stop_pending and self._state() not in (
            ACTIVE_STATE,
            ERROR_STATE,
        )

    def _can_end(self) -> bool:
        return self._state() is not ERROR_STATE

    # Events of the node

    def _on_rpdo(self, number: int) -> None:
        incoming = self._incoming_by_number.get(number)
        if incoming is None:
            return
        try:
            samples = incoming(self.node.dictionary.get, self._clock.now())
        except PdoError as error:
            self._refused += 1
            self._refuse(number, f"{error}: it is ignored")
            samples = ()
        if self._unusable:
            if self._unusable.get(number):
                self._unusable[number] = False
            else:
                self._unusable.pop(number, None)
        for name, sample in samples:
            self._inlets[name].write(sample)

    def _on_refused(self, number: int, thing: ObjectNumber, why: SdoAbort) -> None:
        name = self.description.by_number[thing].name
        self._refuse(number, f"{name} keeps its value: {why}")

    def _refuse(self, number: int, why: str) -> None:
        """Report the first refused value of an RPDO, and again after a PDO without any."""
        if number not in self._unusable:
            log.warning("%s: rpdo%d: %s", self.instance_name, number, why)
        self._unusable[number] = True

    def _on_heartbeat(self, node_id: int, event: HeartbeatEvent) -> None:
        if event.news is HeartbeatNews.LOST:
            self._stopped_by = f"node {node_id} is lost: it has no heartbeat"
            log.warning("%s: %s", self.instance_name, self._stopped_by)

    def _on_collision(self, can_id: int) -> None:
        log.warning(
            "%s: another node has the node-id %d: it sends %03Xh",
            self.instance_name, self.node.node_id, can_id,
        )  # fmt: skip

    def _on_bit_rate(self, bit_rate: int, delay: int) -> None:
        log.warning(
            "%s: LSS requests %d kbit/s, which requires a restart",
            self.instance_name, bit_rate,
        )  # fmt: skip
