"""A node as seen by its manager: boot, identification, configuration, start, supervision.

Follows the published outline of the boot procedure of CiA 302-2: reset communication, wait for
the boot-up message, compare 1000h and 1018h, write the configuration and read it back, start the
node. The procedure is repeated after every boot-up message.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final, Protocol

import msgspec

from rtgen.runtime.canopen.bus.sdo_channel import ATTEMPTS, Outcome, SdoChannel
from rtgen.runtime.canopen.description import NodeDescription
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.master.second_node import FOREIGN_ANSWERS, SecondNodeDetector
from rtgen.runtime.canopen.node_setup import SetUp, SetUpError, number_text, set_up
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import Emergency
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame, earliest
from rtgen.runtime.canopen.wire.guarding import NodeGuard
from rtgen.runtime.canopen.wire.heartbeat import (
    HeartbeatConsumer,
    HeartbeatEvent,
    HeartbeatNews,
)
from rtgen.runtime.canopen.wire.lss import UNCONFIGURED
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.runtime.canopen.wire.sdo import SdoAbort


class NodePhase(IntEnum):
    """Phases of the boot procedure; CANopen::NodePhase of the shared IDL."""

    IDLE = 0
    """The manager is not running the network."""
    ASSIGNING = 1
    """LSS is assigning its node-id."""
    AWAITED = 2
    """The node was reset; its boot-up message is pending."""
    IDENTIFYING = 3
    CONFIGURING = 4
    READY = 5
    """The node is configured, and must not be started."""
    STARTING = 6
    RUNNING = 7
    HALTED = 8
    """The node was commanded to leave OPERATIONAL, or has left by itself."""
    MISSING = 9
    """An optional node that is absent."""
    FAILED = 10


_IN_USE: Final = frozenset(
    {NodePhase.READY, NodePhase.STARTING, NodePhase.RUNNING, NodePhase.HALTED}
)
"""Phases of a configured, supervised node."""

_SETTING_UP: Final = frozenset(
    {
        NodePhase.ASSIGNING,
        NodePhase.AWAITED,
        NodePhase.IDENTIFYING,
        NodePhase.CONFIGURING,
    }
)

_UNFIT_ANSWERS: Final = (sdo.TIMED_OUT, sdo.TOGGLE_ERROR, sdo.COMMAND_UNKNOWN)
"""Results of transfers whose responses are missing, or belong to another transfer."""
_ASKED_STATES: Final = {
    NmtCommand.START: NmtState.OPERATIONAL,
    NmtCommand.STOP: NmtState.STOPPED,
    NmtCommand.ENTER_PRE_OPERATIONAL: NmtState.PRE_OPERATIONAL,
    NmtCommand.RESET_NODE: NmtState.INITIALISING,
    NmtCommand.RESET_COMMUNICATION: NmtState.INITIALISING,
}
_RESETS: Final = (NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION)


class Host(Protocol):
    """Methods of the manager used by the node."""

    settling: int
    """Time in ns without a second boot-up message of a node after which its set-up begins.

    The first one may have waited in the node's controller since before the reset.
    """

    def now(self) -> int:
        """Return the time in ns."""

    def command(self, command: NmtCommand, node_id: int) -> None:
        """Send an NMT command."""

    def guard(self, request: Frame) -> str:
        """Send a node guarding request; return why the bus cannot carry it, empty if it can."""

    def assign(self, node: ManagedNode) -> None:
        """Assign the node-id by LSS; calls `assigned` or `fail` later."""

    def changed(self, node: ManagedNode) -> None:
        """Called when the node's state has changed."""

    def settle(self, node: ManagedNode) -> None:
        """Called when the node has frames or a deadline from outside a call by the manager."""


class NodeReport(msgspec.Struct, frozen=True, gc=False):
    """The state of a node since a time (ns of the link).

    `reason` is the latest error; empty for a node that runs.
    """

    since: int
    id: int
    name: str
    phase: NodePhase
    nmt: NmtState | None
    restarts: int
    reason: str

    @property
    def nmt_name(self) -> str:
        """The enumerator of CANopen::NmtState."""
        return f"NMT_{'UNKNOWN' if self.nmt is None else self.nmt.name}"


class ManagedNode:
    """The boot procedure of one node. `deadline` is the time of the next call of `poll`.

    On an error the node is reset up to `restarts` times (of its description); then it is FAILED,
    or MISSING if it has never answered and is not mandatory. A boot-up message or a command
    starts the procedure again.
    """

    def __init__(
        self, description: NodeDescription, channel: SdoChannel, host: Host
    ) -> None:
        self.description = description
        self.phase = NodePhase.IDLE
        self.since = 0
        self.reason = ""
        self.restarts = 0
        self._channel = channel
        self._host = host
        self._timeout = description.heartbeat_timeout * MILLISECOND
        self._guard = NodeGuard(description.id)
        self._sign = (
            "answer to node guarding" if description.guard_time else "heartbeat"
        )
        self._consumer = HeartbeatConsumer(description.id, self._timeout)
        self._attempt = 0
        self._limit: int | None = None
        self._settled: int | None = None
        """When the set-up begins after a boot-up message."""
        self._configured = False
        self._start = description.start
        self._assigned = False
        self._second_node = SecondNodeDetector(
            channel, description.heartbeat * MILLISECOND, self._timeout
        )
        self._bus_gone = False
        self._emergency: Emergency | None = None
        self._overheard: NmtCommand | None = None
        """The last command of another station that the node has not followed yet."""

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll`; None for never."""
        return earliest(
            self._consumer.deadline, self._guard.deadline, self._limit, self._settled
        )

    @property
    def nmt(self) -> NmtState | None:
        """The last reported NMT state; None if unknown."""
        return self._consumer.state

    @property
    def setting_up(self) -> bool:
        """Whether the node is being set up."""
        return self.phase in _SETTING_UP

    @property
    def in_use(self) -> bool:
        """Whether the node is configured and supervised."""
        return self.phase in _IN_USE

    def report(self) -> NodeReport:
        """Return the current state as a report."""
        node = self.description
        return NodeReport(
            self.since,
            node.id,
            node.name,
            self.phase,
            self.nmt,
            self.restarts,
            self.reason,
        )

    # Called by the manager

    def begin(
        self, command: NmtCommand | None = NmtCommand.RESET_COMMUNICATION
    ) -> None:
        """Reset the node and wait for its boot-up message; None: it has already been reset."""
        self._attempt += 1
        self._configured = self._assigned = self._bus_gone = False
        self._await_boot_up(command)

    def activate(self) -> None:
        """Start from the initial state, because the network starts and all nodes were reset."""
        self.restarts, self.reason = 0, ""
        self._start = self.description.start
        self.begin(None)

    def idle(self) -> None:
        """Stop managing the node."""
        self._attempt += 1
        self._configured = False
        self._enter(NodePhase.IDLE)

    def cut_off(self, reason: str) -> None:
        """Handle the loss of the bus: the node must boot within its boot time-out."""
        self._attempt += 1
        self._configured = False
        self.reason, self._bus_gone = reason, True
        self._await_boot_up(None)

    def request(self, command: NmtCommand, *, send: bool = True) -> None:
        """Process a request for an NMT state; `send` is False for a command to all nodes."""
        if self.phase is NodePhase.IDLE:
            if send:
                self._host.command(command, self.description.id)
        elif command in _RESETS:
            self.restarts, self._start = 0, self.description.start
            self.begin(command if send else None)
        elif command is NmtCommand.START:
            self._start = True
            self._start_wanted()
        else:
            self._start = False
            self._halt(command, send)

    def assigned(self, before: int) -> None:
        """Called after LSS has assigned the configured node-id; `before` is the previous one."""
        if self.phase is not NodePhase.ASSIGNING:
            return
        # A node without a node-id boots at the end of the LSS procedure.
        self._await_boot_up(None)
        if before != UNCONFIGURED:
            self._host.command(NmtCommand.RESET_COMMUNICATION, before)

    def on_error_control(self, frame: Frame, now: int) -> None:
        """Process an error control frame of the node (heartbeat, boot-up, guarding response)."""
        if not self._guard.accepts(frame):
            return
        event = self._consumer.receive(frame, now)
        phase = self.phase
        if phase in _IN_USE and self._second_node.beats_too_often(now):
            self._two_nodes("its heartbeat comes twice as often as it should")
            return
        if event is None or phase is NodePhase.IDLE:
            return
        if event.news is HeartbeatNews.BOOT_UP:
            self._booted(event.asked)
        elif phase in _IN_USE:
            self._on_heartbeat(event, now)
        elif phase is NodePhase.MISSING:
            self.begin()
        else:
            self._host.changed(self)

    def overhear(self, command: NmtCommand) -> None:
        """Record a command that another station has sent to the node."""
        self._overheard = command

    def on_emergency(self, emergency: Emergency) -> None:
        """Process an emergency message, which may explain a later error."""
        self._emergency = None if emergency.cleared else emergency

    def poll(self, now: int) -> None:
        """Process what is due."""
        lost = self._consumer.poll(now)
        request = self._guard.poll(now)
        if lost is not None and self.phase in _IN_USE:
            milliseconds = self.description.heartbeat_timeout
            if self.description.guard_time:
                self.fail(f"it is lost: no {self._sign} for {milliseconds} ms")
            else:
                self.fail(f"its heartbeat is lost: none for {milliseconds} ms")
        elif request is not None and (refused := self._host.guard(request)):
            self.fail(refused, final=True)
        elif self._limit is not None and now >= self._limit:
            self._limit = None
            self._on_timeout()
        elif self._settled is not None and now >= self._settled:
            self._settled = None
            self._set_up()

    def fail(self, reason: str, *, final: bool = False, absent: bool = False) -> None:
        """Handle an error: reset the node, or give it up.

        `final`: a reset would not help. `absent`: the node has never answered.
        """
        self._attempt += 1
        self.reason = reason
        if not final and self.restarts < self.description.restarts:
            self.restarts += 1
            self.begin()
            return
        missing = absent and not self.description.mandatory
        started = self.phase in (NodePhase.STARTING, NodePhase.RUNNING)
        self._configured = False
        if started and self.nmt is not NmtState.STOPPED:
            # An unsupervised node must not remain operational.
            self._host.command(NmtCommand.ENTER_PRE_OPERATIONAL, self.description.id)
        self._enter(NodePhase.MISSING if missing else NodePhase.FAILED)

    # Booting

    def _await_boot_up(self, command: NmtCommand | None) -> None:
        self._supervise_anew()
        self._consumer.ask(NmtState.INITIALISING)
        self._enter(NodePhase.AWAITED, self.description.boot_timeout)
        if command is not None:
            self._host.command(command, self.description.id)

    def _booted(self, asked: bool) -> None:
        self._channel.restart()
        if not asked and self.phase in _IN_USE:
            self.reason = f"it booted again {self._agent(*_RESETS)}"
        if self.phase in (NodePhase.FAILED, NodePhase.MISSING):
            self.restarts = 0
        self._attempt += 1
        self._configured, self._emergency = False, None
        again = self.phase in (NodePhase.IDENTIFYING, NodePhase.CONFIGURING)
        self._second_node.booted(again=again)
        self._enter(NodePhase.IDENTIFYING)
        self._settled = self._host.now() + self._host.settling

    def _set_up(self) -> None:
        self._go_on(set_up(self.description, self._identified), None)

    def _identified(self) -> None:
        self._enter(NodePhase.CONFIGURING)

    def _go_on(self, procedure: SetUp, value: bytes | None) -> None:
        """Continue the set-up up to its next transfer, or to its end."""
        try:
            transfer = next(procedure) if value is None else procedure.send(value)
        except StopIteration:
            self._set_up_done()
            return
        except SetUpError as error:
            self.fail(str(error), final=error.final)
            return
        attempt = self._attempt
        index, subindex, octets = transfer.index, transfer.subindex, transfer.value

        def done(outcome: Outcome) -> None:
            if attempt != self._attempt or isinstance(outcome, LinkError):
                return
            if isinstance(outcome, SdoAbort):
                verb = "read" if octets is None else "written"
                what = f"{number_text(index, subindex)} cannot be {verb}: {outcome}"
                unfit = outcome.code in _UNFIT_ANSWERS
                doubled = self._second_node.evidence if unfit else ""
                if doubled:
                    self._two_nodes(f"{what}, and {doubled}")
                else:
                    self.fail(what)
            elif self._second_node.answers:
                self._two_nodes(FOREIGN_ANSWERS)
            else:
                self._go_on(procedure, outcome)
            self._host.settle(self)

        if octets is None:
            self._channel.submit_upload(index, subindex, done, attempts=ATTEMPTS)
        else:
            attempts = ATTEMPTS if transfer.repeatable else 1
            self._channel.submit_download(
                index, subindex, octets, done, attempts=attempts
            )

    def _set_up_done(self) -> None:
        self._configured = True
        # The configured heartbeat time applies from here on.
        self._supervise_anew()
        if self.description.guard_time:
            now = self._host.now()
            self._guard.start(self.description.guard_time * MILLISECOND, now)
        if self._start:
            self._go_operational()
        else:
            node = self.description
            patience = node.boot_timeout + node.heartbeat_timeout
            self._enter(NodePhase.READY, patience if self._timeout else None)

    # Configured

    def _go_operational(self) -> None:
        node = self.description
        self._consumer.ask(NmtState.OPERATIONAL)
        if self._timeout and self.nmt is not NmtState.OPERATIONAL:
            patience = node.boot_timeout + node.heartbeat_timeout
            self._enter(NodePhase.STARTING, patience)
        else:
            self._enter(NodePhase.RUNNING)
        self._host.command(NmtCommand.START, node.id)

    def _start_wanted(self) -> None:
        if self.phase in _SETTING_UP:
            return
        if self._configured:
            self._go_operational()
        else:
            self.restarts = 0
            self.begin()

    def _halt(self, command: NmtCommand, send: bool) -> None:
        # A node in set-up will reach pre-operational; in STOPPED it could not respond to SDO.
        if self.phase in _SETTING_UP:
            return
        self._consumer.ask(_ASKED_STATES[command])
        if self.phase in _IN_USE:
            self._enter(NodePhase.HALTED)
        if send:
            self._host.command(command, self.description.id)

    def _on_heartbeat(self, event: HeartbeatEvent, now: int) -> None:
        state, phase = event.state, self.phase
        if phase in (NodePhase.READY, NodePhase.STARTING) and self._second_node.answers:
            self._two_nodes(FOREIGN_ANSWERS)
            return
        if phase is NodePhase.READY:
            self._limit = None
        if state is NmtState.OPERATIONAL:
            self._enter(NodePhase.RUNNING)
        elif state is NmtState.STOPPED and not event.asked:
            self.fail(f"it has stopped {self._agent(NmtCommand.STOP)}{self._cause()}")
        elif phase is NodePhase.RUNNING and event.news is HeartbeatNews.CHANGED:
            if not event.asked:
                agent = self._agent(NmtCommand.ENTER_PRE_OPERATIONAL)
                self.reason = f"it has left operational {agent}{self._cause()}"
            self._enter(NodePhase.HALTED)
        else:
            self._host.changed(self)

    def _two_nodes(self, what: str) -> None:
        self.fail(f"{what}: two nodes have the id {self.description.id}")

    def _agent(self, *commands: NmtCommand) -> str:
        """Return who has changed the node's state, if one of these commands would do so."""
        overheard, self._overheard = self._overheard, None
        if overheard in commands:
            return "by a command of another station"
        return "by itself"

    def _cause(self) -> str:
        return f", after EMCY {self._emergency}" if self._emergency else ""

    def _on_timeout(self) -> None:
        """Handle the time-out of a phase."""
        node = self.description
        if self.phase is NodePhase.AWAITED:
            if self._bus_gone:
                self.fail(self.reason, final=True)
                return
            if node.lss and not self._assigned:
                self._assigned = True
                self._enter(NodePhase.ASSIGNING)
                self._host.assign(self)
                return
            self.fail(f"no boot-up message within {node.boot_timeout} ms", absent=True)
            return
        patience = node.boot_timeout + node.heartbeat_timeout
        if self.nmt is None:
            self.fail(f"no {self._sign} within {patience} ms after its configuration")
        else:
            self.fail(f"it has not become operational within {patience} ms")

    def _supervise_anew(self) -> None:
        self._consumer = HeartbeatConsumer(self.description.id, self._timeout)
        self._second_node.restart_beats()

    def _enter(self, phase: NodePhase, milliseconds: int | None = None) -> None:
        """Enter a phase with a time limit."""
        now = self._host.now()
        self.phase, self.since = phase, now
        if phase is NodePhase.RUNNING:
            self.reason = ""
        self._settled = None
        if phase not in _IN_USE:
            self._guard.stop()
        self._limit = None if milliseconds is None else now + milliseconds * MILLISECOND
        self._host.changed(self)
