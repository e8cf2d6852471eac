"""State transitions that a proxy performs on its node, as steps that wait for the bus.

Steps are generators that yield the event that they wait for. They end when the node has reached the
state; otherwise they raise NodeError, SdoAbort or LinkError. All I/O goes through the link.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Final, TypeAlias

from rtgen.runtime.canopen.bus.link import Link, no_guarding
from rtgen.runtime.canopen.bus.sdo_channel import ATTEMPTS, Outcome
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    NodeDescription,
    ObjectNumber,
    ObjectValue,
    Write,
)
from rtgen.runtime.canopen.master.parameter_writes import ParameterWriter
from rtgen.runtime.canopen.master.proxied_node import ProxiedNode
from rtgen.runtime.canopen.node_setup import IDENTITY, same
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import MILLISECOND
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, command_frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.failures import log

Steps: TypeAlias = Generator[str, None, None]

HEARTBEAT: Final = 100
"""Heartbeat period or guard time in ms set by a proxy acting as master, if the node has none."""
_LIFE_FACTOR: Final = 3
"""Periods without heartbeat or guarding response after which a node is lost."""
_MIN_TIMEOUT: Final = 1000 * MILLISECOND
"""Minimum time-out for a state."""
_ATTEMPTS: Final = 5
"""Maximum number of boot-ups during activation."""
_FOREIGN_ANSWERS: Final = 2
"""Minimum number of unexpected SDO responses that indicate a second node."""
_TWICE: Final = "answers twice: there are two of them, or another SDO client"
_HEARTBEAT_TIME: Final = (0x1017, 0)
_GUARD_TIME: Final = (0x100C, 0)
_GUARD_FACTOR: Final = (0x100D, 0)
_STATES: Final = {
    NmtState.INITIALISING: "initialising",
    NmtState.STOPPED: "stopped",
    NmtState.OPERATIONAL: "operational",
    NmtState.PRE_OPERATIONAL: "pre-operational",
    None: "unknown",
}


class NodeError(Exception):
    """The node does not reach the requested state, or has the wrong identity."""


class NodeControl:
    """Performs state transitions of one node.

    `placed` is the node's entry in its network, None without one. With `master`, NMT commands are
    sent directly if the process has no NMT master; the node is then identified and configured,
    too. Times are in ns; `heartbeat_timeout` 0 defaults to the network or the device.
    """

    def __init__(
        self,
        link: Link,
        node: ProxiedNode,
        description: DeviceDescription,
        placed: NodeDescription | None,
        *,
        master: bool,
        heartbeat_timeout: int,
        boot_timeout: int,
    ) -> None:
        self._link = link
        self._node = node
        self._description = description
        self._placed = placed
        self._master = master
        self._heartbeat_timeout = heartbeat_timeout
        self._boot_timeout = boot_timeout
        self._period = self._default(_HEARTBEAT_TIME) or self._default(_GUARD_TIME)
        self._life_factor = _LIFE_FACTOR
        if not self._default(_HEARTBEAT_TIME):
            self._life_factor = self._default(_GUARD_FACTOR) or _LIFE_FACTOR
        self._silent = False
        self._supervised = -1
        self._transfers = 0
        self._boots = 0
        self.running = False
        """Whether the node was brought to OPERATIONAL."""
        self.written: dict[ObjectNumber, ObjectValue] = {}
        """Parameters as written to the node; others are unknown."""

    @property
    def timeout(self) -> int:
        """The heartbeat time-out of the node; 0 if not known yet.

        That of a network applies once the node is configured, until it boots again.
        """
        node, placed, master = self._node, self._placed, self._link.master
        if self._silent or self._heartbeat_timeout:
            return 0 if self._silent else self._heartbeat_timeout
        if placed is None:
            return self._life_factor * self._period * MILLISECOND
        is_supervised = self._supervised == node.boots or (
            master is not None and master.readiness(node.node_id) is True
        )
        return placed.heartbeat_timeout * MILLISECOND if is_supervised else 0

    def activation(
        self, parameters: Callable[[], Mapping[ObjectNumber, ObjectValue]]
    ) -> Steps:
        """Enter OPERATIONAL with the parameters written; repeats what a reboot has undone."""
        for _ in range(_ATTEMPTS):
            self._boots = self._node.boots
            foreign = self._link.sdo(self._node.node_id).unexpected
            try:
                yield from self._start(parameters)
            except (SdoAbort, NodeError) as error:
                if self._node.boots == self._boots:
                    twice = self._link.sdo(self._node.node_id).unexpected > foreign
                    if twice and isinstance(error, SdoAbort):
                        error.add_note(f"{self} {_TWICE}")
                    raise
            else:
                if self._node.boots == self._boots:
                    return
        raise NodeError(f"{self} boots again and again")

    def deactivation(self) -> Steps:
        """Enter PRE_OPERATIONAL."""
        yield from self._go(NmtCommand.ENTER_PRE_OPERATIONAL, NmtState.PRE_OPERATIONAL)

    def reset(self) -> Steps:
        """Reset the node, and wait for its boot-up message."""
        node, link = self._node, self._link
        yield from self._await_master(None)
        boots, limit = node.boots, link.now() + self._boot_timeout
        self.command(NmtCommand.RESET_NODE)
        while node.boots == boots:
            if link.now() >= limit and not self._is_assigned_an_id():
                raise NodeError(
                    f"{self}: no boot-up message within {_seconds(self._boot_timeout)}"
                )
            yield f"the boot-up message of {self}"
        node.emergency = None
        self.written.clear()

    def _is_assigned_an_id(self) -> bool:
        """Return whether the manager is still assigning a node-id lost by a reset.

        Raises NodeError if the manager has given up.
        """
        master, placed = self._link.master, self._placed
        if master is None or placed is None or not placed.lss:
            return False
        readiness = master.readiness(self._node.node_id)
        if isinstance(readiness, str):
            raise NodeError(f"{self}: {readiness}")
        return True

    @property
    def can_command(self) -> bool:
        """Whether NMT commands can be sent: the process has a master, or acts as one."""
        return self._link.master is not None or self._master

    def command(self, command: NmtCommand) -> None:
        """Send an NMT command. Raises NodeError without a master, or LinkError."""
        link, node = self._link, self._node
        with link.lock:
            if link.master is not None:
                link.master.request(command, node.node_id)
            elif self._master:
                link.send((command_frame(command, node.node_id),), node)
            else:
                raise NodeError(
                    f"{self} cannot be commanded to change its state: this process has no NMT "
                    "master (a manager that is ACTIVE, or `master` of the proxy)"
                )
            node.command_sent()
            self.running = command is NmtCommand.START

    def __str__(self) -> str:
        return f"node {self._node.node_id}"

    # Activation

    def _start(
        self, parameters: Callable[[], Mapping[ObjectNumber, ObjectValue]]
    ) -> Steps:
        link = self._link
        self.written.clear()
        yield from self._await_master(NmtState.OPERATIONAL)
        if link.master is not None:
            yield from self._await_manager()
            self._boots = self._node.boots
        channel = link.sdo(self._node.node_id)
        self._transfers, foreign = 0, -channel.unexpected
        if link.master is None and self._master:
            yield from self._set_up()
        yield from self._supervise()
        values = parameters()
        for number, octets in self.parameter_writes(values):
            described = self._description.by_number[number]
            attempts = ATTEMPTS if described.readable else 1
            yield from self._download(number, octets, attempts)
        self.written.update(values)
        foreign += channel.unexpected
        if foreign >= max(_FOREIGN_ANSWERS, self._transfers - 1):
            raise NodeError(f"{self} {_TWICE}")
        yield from self._go(NmtCommand.START, NmtState.OPERATIONAL)

    def parameter_writes(
        self, values: Mapping[ObjectNumber, ObjectValue]
    ) -> list[tuple[ObjectNumber, bytes]]:
        """Return the writes of parameters. Raises ObjectValueError for an invalid value."""
        is_known = self._placed is not None or self._master
        writer = ParameterWriter(
            self._description,
            self._node.node_id,
            self._configuration if is_known else None,
            self.written,
            values,
        )
        return list(writer.writes())

    @property
    def _configuration(self) -> Sequence[Write]:
        placed = self._placed
        return (
            self._description.configuration if placed is None else placed.configuration
        )

    def _await_master(self, state: NmtState | None) -> Steps:
        """Wait for an NMT master here, or until another one has changed the node's state."""
        link, node = self._link, self._node
        limit = link.now() + self._boot_timeout
        while link.master is None and not self._master:
            if state is not None and node.state is state:
                return
            if link.now() >= limit:
                return
            yield f"an NMT master for {self}"

    def _await_manager(self) -> Steps:
        """Wait until the manager has configured the node."""
        while (master := self._link.master) is not None:
            readiness = master.readiness(self._node.node_id)
            if isinstance(readiness, str):
                raise NodeError(f"{self}: {readiness}")
            if readiness:
                return
            yield f"the manager to configure {self}"

    def _set_up(self) -> Steps:
        """Identify and configure the node, in place of a manager."""
        placed, writes = self._placed, self._configuration
        if writes and self._node.state is not NmtState.OPERATIONAL:
            yield from self._reset_communication()
        else:
            yield from self._await_answer()
        identity = (None,) * len(IDENTITY) if placed is None else placed.identity
        for (index, subindex, what), expected in zip(IDENTITY, identity, strict=True):
            if expected is None:
                continue
            octets = yield from self._upload((index, subindex))
            found = int.from_bytes(octets, "little")
            if found != expected:
                raise NodeError(
                    f"{self} is another device: its {what} ({index:04X}h:{subindex:X}) is "
                    f"{found:#x}, not {expected:#x}"
                )
        if self._node.state is NmtState.OPERATIONAL:
            return
        node_id = self._node.node_id
        last = {(w.index, w.subindex): w for w in writes if w.verify}
        for write in writes:
            number = write.index, write.subindex
            attempts = ATTEMPTS if write.repeatable else 1
            yield from self._download(number, write.octets(node_id), attempts)
        for number, write in last.items():
            if not same((yield from self._upload(number)), write.octets(node_id)):
                raise NodeError(
                    f"{self} does not keep the value written to {_text(number)}"
                )

    def _reset_communication(self) -> Steps:
        """Reset the communication of the node, so that its configuration is known."""
        link, node = self._link, self._node
        boots, limit = node.boots, link.now() + self._boot_timeout
        self.command(NmtCommand.RESET_COMMUNICATION)
        while node.boots == boots:
            if link.now() >= limit:
                raise self._missing()
            yield f"the boot-up message of {self}"
        self._boots = node.boots

    def _missing(self) -> NodeError:
        time = _seconds(self._boot_timeout)
        return NodeError(f"{self} is missing: no answer within {time}")

    def _await_answer(self) -> Steps:
        """Wait until the node responds, or the boot time-out has expired."""
        link = self._link
        limit = link.now() + self._boot_timeout
        while True:
            try:
                yield from self._upload((0x1000, 0), attempts=1)
            except SdoAbort as abort:
                if abort.code != sdo.TIMED_OUT:
                    return
            else:
                return
            if link.now() >= limit:
                raise self._missing()

    def _supervise(self) -> Steps:
        """Start supervision by the node's heartbeat, or by node guarding."""
        placed, guard_time = self._placed, 0
        if placed is None:
            self._life_factor = _LIFE_FACTOR
            self._period = yield from self._read_period()
            if not self._period:
                guard_time = yield from self._read_guard_time()
                self._period = guard_time
            self._silent = not self._period
        else:
            guard_time = placed.guard_time
            self._silent = not (placed.heartbeat or guard_time)
        self._supervised = self._node.boots
        if self._silent:
            log.warning(
                "%s is not supervised: it has neither heartbeat nor node guarding", self
            )
        if guard_time and self._master and self._link.master is None:
            link = self._link
            if not link.carries_remote_frames:
                raise NodeError(f"{self}: {no_guarding(link)}")
            with link.lock:
                self._node.guard(guard_time * MILLISECOND, link.now())
                link.refresh(self._node)

    def _read_period(self) -> Generator[str, None, int]:
        """Return the heartbeat period in ms; a master sets one in a node without."""
        period = yield from self._read_number(_HEARTBEAT_TIME)
        if period is None:
            return 0
        if period or not self._configures:
            return period
        period = self._wanted_period
        answer = yield from self._write_number(_HEARTBEAT_TIME, period, 2)
        return period if answer else 0

    def _read_guard_time(self) -> Generator[str, None, int]:
        """Return the guard time in ms, 0 if the node cannot be guarded; see `_read_period`."""
        period = yield from self._read_number(_GUARD_TIME)
        if period is None:
            return 0
        factor = yield from self._read_number(_GUARD_FACTOR)
        if period or not self._configures:
            self._life_factor = factor or _LIFE_FACTOR
            return period
        period = self._wanted_period
        # A node that does not store them still responds, without supervising its master.
        yield from self._write_number(_GUARD_TIME, period, 2)
        yield from self._write_number(_GUARD_FACTOR, _LIFE_FACTOR, 1)
        return period

    @property
    def _configures(self) -> bool:
        """Whether the proxy configures the supervision of the node."""
        return self._master and self._link.master is None

    @property
    def _wanted_period(self) -> int:
        if not self._heartbeat_timeout:
            return HEARTBEAT
        return max(1, self._heartbeat_timeout // (_LIFE_FACTOR * MILLISECOND))

    def _default(self, number: ObjectNumber) -> int:
        return self._description.initial_number(number, self._node.node_id)

    def _read_number(self, number: ObjectNumber) -> Generator[str, None, int | None]:
        """Return an unsigned integer, None if the node aborts."""
        try:
            octets = yield from self._upload(number)
        except SdoAbort as abort:
            if abort.code == sdo.TIMED_OUT:
                raise
            return None
        return int.from_bytes(octets, "little")

    def _write_number(
        self, number: ObjectNumber, value: int, size: int
    ) -> Generator[str, None, bool]:
        """Write an unsigned integer; return whether the node accepts it."""
        try:
            yield from self._download(number, value.to_bytes(size, "little"), ATTEMPTS)
        except SdoAbort as abort:
            if abort.code == sdo.TIMED_OUT:
                raise
            return False
        return True

    # Common steps

    def _go(self, command: NmtCommand, state: NmtState) -> Steps:
        """Command the node to a state, and wait for the heartbeat with that state."""
        link, node = self._link, self._node
        # Without heartbeat, only the boot-up message shows PRE_OPERATIONAL.
        is_reported = state is NmtState.OPERATIONAL or not self._silent
        if node.state is state and is_reported:
            self.running = state is NmtState.OPERATIONAL
            return
        self.command(command)
        patience = max(_MIN_TIMEOUT, node.timeout)
        limit = link.now() + patience
        while node.state is not state and not self._silent:
            if link.now() >= limit:
                raise NodeError(
                    f"{self} is not {_STATES[state]} within {_seconds(patience)}: "
                    f"its state is {_STATES[node.state]}"
                )
            yield f"{self} to be {_STATES[state]}"

    def _upload(
        self, number: ObjectNumber, attempts: int = ATTEMPTS
    ) -> Generator[str, None, bytes]:
        self._transfers += 1
        outcomes: list[Outcome] = []
        channel = self._link.sdo(self._node.node_id)
        channel.submit_upload(*number, outcomes.append, attempts=attempts)
        while not outcomes:
            yield f"{_text(number)} of {self}"
        return _octets_of(outcomes[0], f"{self}: {_text(number)} cannot be read")

    def _download(self, number: ObjectNumber, octets: bytes, attempts: int) -> Steps:
        self._transfers += 1
        outcomes: list[Outcome] = []
        channel = self._link.sdo(self._node.node_id)
        channel.submit_download(*number, octets, outcomes.append, attempts=attempts)
        while not outcomes:
            yield f"{_text(number)} of {self}"
        _octets_of(outcomes[0], f"{self}: {_text(number)} cannot be written")


def _octets_of(outcome: Outcome, what: str) -> bytes:
    """Return the octets of an outcome. Raises its error, with a note naming the object."""
    if isinstance(outcome, SdoAbort):
        outcome.add_note(what)
    if isinstance(outcome, bytes):
        return outcome
    raise outcome


def reason_of(error: Exception) -> str:
    """Return an error as text, with the notes about its object."""
    return ": ".join([*getattr(error, "__notes__", ()), str(error)])


def _text(number: ObjectNumber) -> str:
    return f"{number[0]:04X}h:{number[1]:X}"


def _seconds(time: int) -> str:
    return f"{time / 10**9:g} s"
