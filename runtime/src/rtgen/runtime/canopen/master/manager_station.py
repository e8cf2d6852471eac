"""Manager of a network on its bus: NMT master, producer of SYNC and heartbeat."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from heapq import heappop, heappush
from typing import Final

from rtgen.runtime.canopen.bus.link import Link, no_guarding
from rtgen.runtime.canopen.description import Network
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.master.managed_node import ManagedNode, NodePhase, NodeReport
from rtgen.runtime.canopen.wire.emergency import emergency_in
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    LSS_RESPONSE,
    MILLISECOND,
    NMT,
    CobId,
    Frame,
    earliest,
)
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatProducer
from rtgen.runtime.canopen.wire.lss_master import Assigned, LssError, LssMaster, assign
from rtgen.runtime.canopen.wire.nmt import (
    NmtCommand,
    NmtState,
    command_frame,
    decode_command,
    heartbeat_frame,
)
from rtgen.runtime.canopen.wire.sync import SyncProducer

_MICROSECOND: Final = 1000
_SYNC_OBJECTS: Final = (0x1005, 0x1019)
_SETTLING: Final = 5 * MILLISECOND
_FASTEST: Final = 1000
"""Bit rate in kbit/s that is assumed if the network does not state one."""
_BOOT_UP_BITS: Final = 65
"""Length of a boot-up message on the bus."""


class ManagerStation:
    """Runs a network between `start` and `halt`; on the bus between `attach` and `detach`.

    While running it is `link.master`. `listener` receives every change of a node, with the link's
    lock held.
    """

    def __init__(
        self,
        link: Link,
        network: Network,
        listener: Callable[[NodeReport], None] = lambda report: None,
    ) -> None:
        self.network = network
        boot_ups = len(network.nodes) * _BOOT_UP_BITS * MILLISECOND
        self.settling = _SETTLING + boot_ups // (network.bit_rate or _FASTEST)
        """See `Host`."""
        self.nodes = {
            node.id: ManagedNode(node, link.sdo(node.id), self)
            for node in network.nodes
        }
        cob_ids = ((CobId(n.emergency_cob_id), n.id) for n in network.nodes)
        self._emergencies = {
            (each.can_id, each.extended): self.nodes[node]
            for each, node in cob_ids
            if each.valid
        }
        self.identifiers = frozenset(
            (
                NMT,
                LSS_RESPONSE,
                ERROR_CONTROL + network.manager,
                *(ERROR_CONTROL + node for node in self.nodes),
                *(can_id for can_id, _ in self._emergencies),
            )
        )
        self.deadline: int | None = None
        self.running = False
        self.link = link
        self._listener = listener
        self._lss = LssMaster()
        self._sync = (
            SyncProducer(
                network.sync * _MICROSECOND,
                network.sync_overflow,
                CobId(network.sync_cob_id),
            )
            if network.sync
            else None
        )
        self._sync_nodes = {
            node.id
            for node in network.nodes
            if any(write.index in _SYNC_OBJECTS for write in node.configuration)
        }
        self._awaited: set[int] = set()
        """Nodes that must be set up before they understand SYNC."""
        self._heartbeat = HeartbeatProducer(
            network.manager, network.heartbeat * MILLISECOND
        )
        self._clash = ""
        self._failed: dict[int, ManagedNode] = {}
        self._attached = False
        self._up = link.up
        self._frames: list[Frame] = []
        # Heap of due times; a node's own deadline may be later by now.
        self._agenda: list[tuple[int, int]] = []
        self._noted: dict[int, int] = {}

    # Interface to the owning component

    @property
    def failure(self) -> str:
        """Why the network cannot operate; empty if it can."""
        if self._clash:
            return self._clash
        for node in tuple(self._failed.values()):
            name = f"{node.description.name} (node {node.description.id})"
            return f"{name}: {node.reason}"
        return ""

    def reports(self) -> list[NodeReport]:
        """Return the state of every node, by node-id."""
        with self.link.lock:
            return [self.nodes[node].report() for node in sorted(self.nodes)]

    def start(self) -> None:
        """Reset and boot the nodes, and become the NMT master.

        Raises RuntimeError if the link already has a master.
        """
        link = self.link
        with link.lock:
            if not self._attached:
                link.attach(self)
                self._attached, self._up = True, link.up
            if link.master is not None and link.master is not self:
                raise RuntimeError("there is another NMT master on this bus")
            link.master = self
            self.running, self._clash = True, ""
            if self._up:
                self._begin(link.now())
            else:
                self._cut_off()
            self._flush()

    def halt(self) -> None:
        """Switch the nodes to pre-operational and stop managing them; the heartbeat continues."""
        with self.link.lock:
            if not self.running:
                return
            self.running = False
            self.link.master = None
            self._lss.cancel()
            if self._sync is not None:
                self._sync.stop()
            self._command(NmtCommand.ENTER_PRE_OPERATIONAL, 0)
            for node in self.nodes.values():
                node.idle()
            self._flush()

    def close(self) -> None:
        """Halt the network, and leave the bus."""
        self.halt()
        self.link.detach(self)
        self._attached = False

    # NmtMaster

    def request(self, command: int, node_id: int) -> None:
        """See `NmtMaster`. While the bus is lost, the request is only recorded."""
        nmt_command = NmtCommand(command)
        with self.link.lock:
            if node_id == 0 and nmt_command is not NmtCommand.START:
                self._command(nmt_command, 0)
            elif node_id not in (0, *self.nodes):
                self._command(nmt_command, node_id)
            for node in self.nodes.values():
                if node_id in (0, node.description.id):
                    broadcast = node_id == 0 and nmt_command is not NmtCommand.START
                    node.request(nmt_command, send=not broadcast)
                    self._schedule(node)
            self._flush()

    def readiness(self, node_id: int) -> bool | str:
        """See `NmtMaster`."""
        node = self.nodes.get(node_id)
        if node is None:
            return True
        if node.phase in (NodePhase.FAILED, NodePhase.MISSING):
            return node.reason or "it is missing"
        return node.in_use

    # Station

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """See `Station`."""
        can_id = frame.can_id
        reporter = self._emergencies.get((can_id, frame.extended))
        if reporter is not None:
            emergency = emergency_in(frame)
            if emergency is not None:
                reporter.on_emergency(emergency)
        elif can_id == NMT:
            self._overhear(frame)
        elif not frame.extended:
            node = self.nodes.get(can_id - ERROR_CONTROL)
            if node is not None:
                node.on_error_control(frame, now)
                self._schedule(node)
            elif can_id == LSS_RESPONSE:
                self._frames += self._lss.receive(frame, now)
            elif self._is_own(frame) and self.running and not self._clash:
                self._clash = (
                    f"another node has the manager's node-id {self.network.manager}"
                )
        return self._answer()

    def poll(self, now: int) -> Iterable[Frame]:
        """See `Station`."""
        if self._sync is not None and (sync := self._sync.poll(now)) is not None:
            self._frames.append(sync)
        state = NmtState.OPERATIONAL if self.running else NmtState.PRE_OPERATIONAL
        if (heartbeat := self._heartbeat.poll(now, state)) is not None:
            self._frames.append(heartbeat)
        self._frames += self._lss.poll(now)
        agenda = self._agenda
        while agenda and agenda[0][0] <= now:
            due, node_id = heappop(agenda)
            if self._noted.get(node_id) != due:
                continue
            del self._noted[node_id]
            node = self.nodes[node_id]
            node.poll(now)
            self._schedule(node)
        return self._answer()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """See `Station`: when the bus is available again, all nodes are booted again."""
        self._up = up
        if not up:
            self._heartbeat.stop()
            if self.running:
                self._cut_off()
            self._frames.clear()
        elif self.running:
            self._begin(now)
        return self._answer()

    # Host of the nodes

    def now(self) -> int:
        """See `Host`."""
        return self.link.now()

    def command(self, command: NmtCommand, node_id: int) -> None:
        """See `Host`."""
        self._command(command, node_id)

    def guard(self, request: Frame) -> str:
        """See `Host`."""
        if not self.link.carries_remote_frames:
            return no_guarding(self.link)
        self._frames.append(request)
        return ""

    def assign(self, node: ManagedNode) -> None:
        """See `Host`."""
        description = node.description

        def done(outcome: Assigned | LssError) -> None:
            if isinstance(outcome, LssError):
                if node.phase is NodePhase.ASSIGNING:
                    timeout = description.boot_timeout
                    reason = f"no boot-up message within {timeout} ms, and {outcome}"
                    node.fail(reason, absent=True)
            else:
                node.assigned(outcome.before)
            self._schedule(node)

        procedure = assign(description.identity[1:], description.id)
        self._frames += self._lss.submit(procedure, done, self.link.now())

    def changed(self, node: ManagedNode) -> None:
        """See `Host`."""
        if node.phase is NodePhase.FAILED and node.description.mandatory:
            self._failed[node.description.id] = node
        else:
            self._failed.pop(node.description.id, None)
        is_over = node.restarts or not node.setting_up
        if node.description.id in self._awaited and is_over:
            self._awaited.discard(node.description.id)
            if self._sync is not None and self.running and not self._awaited:
                self._sync.start(self.link.now())
        self._listener(node.report())

    def settle(self, node: ManagedNode) -> None:
        """See `Host`."""
        self._schedule(node)
        self._flush()

    # Private methods

    def _is_own(self, frame: Frame) -> bool:
        """Return whether a frame has the identifier of the manager's heartbeat."""
        return frame.can_id == ERROR_CONTROL + self.network.manager

    def _overhear(self, frame: Frame) -> None:
        """Record a command of another station, which explains what nodes do next."""
        command = decode_command(frame)
        if command is None or not self.running:
            return
        for node in self.nodes.values():
            if command[1] in (0, node.description.id):
                node.overhear(command[0])

    def _begin(self, now: int) -> None:
        """Reset all nodes with one frame, before anything else; then send the boot-up message."""
        self._lss.cancel()
        self._command(NmtCommand.RESET_COMMUNICATION, 0)
        manager = self.network.manager
        self._frames.append(heartbeat_frame(manager, NmtState.INITIALISING))
        self._heartbeat.booted(now)
        self._awaited = set(self._sync_nodes)
        if self._sync is not None and not self._awaited:
            self._sync.start(now)
        for node in self.nodes.values():
            node.activate()
            self._schedule(node)

    def _cut_off(self) -> None:
        if self._sync is not None:
            self._sync.stop()
        self._lss.cancel()
        for node in self.nodes.values():
            node.cut_off("the bus is gone")
            self._schedule(node)

    def _command(self, command: NmtCommand, node_id: int) -> None:
        if self._up:
            self._frames.append(command_frame(command, node_id))

    def _schedule(self, node: ManagedNode) -> None:
        """Schedule a node, unless it is already scheduled for an earlier time."""
        due, node_id = node.deadline, node.description.id
        if due is None:
            return
        noted = self._noted.get(node_id)
        if noted is None or due < noted:
            self._noted[node_id] = due
            heappush(self._agenda, (due, node_id))

    def _answer(self) -> list[Frame]:
        """Compute the deadline; return the frames to send."""
        self.deadline = earliest(
            self._agenda[0][0] if self._agenda else None,
            None if self._sync is None else self._sync.deadline,
            self._heartbeat.deadline,
            self._lss.deadline,
        )
        frames, self._frames = self._frames, []
        return frames

    def _flush(self) -> None:
        """Send pending frames, outside a call by the link."""
        frames = self._answer()
        if frames and self._up:
            # If the bus has just been lost, `link_changed` follows.
            with suppress(LinkError):
                self.link.send(frames, self)
        self.link.refresh(self)
