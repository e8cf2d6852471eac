"""The proxy of a CANopen device: PDOs as ports, objects by SDO, NMT states as RTC states.

Source: the published description of RTC-CANopen (table 3 and figure 110). The commands of each
transition are listed in `docs/canopen.md`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Final

from rtgen.facts.canopen_parameters import COMPONENT_FACTS
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.sdo_channel import Outcome, SdoChannel
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.hooks import ProxyHooks
from rtgen.runtime.canopen.master.node_control import (
    NodeControl,
    NodeError,
    Steps,
    reason_of,
)
from rtgen.runtime.canopen.master.proxied_node import ProxiedNode
from rtgen.runtime.canopen.master.proxy_connection import (
    ProxyConnection,
    planned,
    settings_of,
)
from rtgen.runtime.canopen.master.proxy_location import cob_ids, place
from rtgen.runtime.canopen.master.recovery import Recovery
from rtgen.runtime.canopen.master.state_mirror import StateMirror
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import MILLISECOND
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.runtime.canopen.wire.pdo_transmission import TpdoTransmitter
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.failures import log
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.context_operations import ExecutionContextOperations
from rtgen.runtime.rtc.life_cycle import Request

_BLOCK: Final = 128
"""Length in octets from which a value is written by block transfer."""


class CanopenProxy(ProxyHooks, Component, **COMPONENT_FACTS):
    """Base class of generated proxies.

    A proxy is on the bus from its start, and follows its node: an unsolicited change of the node's
    NMT state becomes a request to the component. Samples of the device are written to the OutPorts
    in `on_execute`, in order of arrival; `lost` counts those dropped because the queue was full.
    """

    config: Any
    """The `ProxyConfiguration`."""

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self._connection: ProxyConnection | None = None
        self._under_way: tuple[Request, Steps] | None = None
        self._dropped = 0
        self._reported: set[int] = set()
        self._without_blocks = False
        self.configuration_sets.on_change = self._parameters_changed
        self.observables["malformed"] = partial(self._counts, "too_short", "too_long")
        self.observables["refused"] = partial(self._counts, "refused")
        self.observables["overwritten"] = partial(self._counts, "overwritten")

    # Callbacks

    def on_initialize(self) -> ReturnCode_t:
        """Make the providers available in every state, so that objects are always accessible."""
        for provider in self.providers.values():
            provider.in_every_state = True
        return RTC_OK

    def on_startup(self, ec_id: int) -> ReturnCode_t:
        """Join the bus; after a failure, joining is retried when a transition needs the bus."""
        try:
            self._connect()
        except (NodeError, LinkError) as error:
            return self.fail(str(error))
        return RTC_OK

    def on_finalize(self) -> ReturnCode_t:
        """Leave the bus."""
        self._disconnect()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Write received PDOs to the OutPorts, and send the samples of the InPorts."""
        connection = self._connection
        assert connection is not None
        connection.deliver()
        values: list[tuple[TpdoTransmitter, bytes]] = []
        for number, sender, transmitter in connection.senders:
            try:
                values += [(transmitter, octets) for octets in sender()]
            except PdoError as error:
                return self.fail(f"rpdo{number}: {error}")
        if values:
            link, node = connection.link, connection.node
            try:
                with link.lock:
                    frames = node.transmit(values, link.now())
                    link.refresh(node)
                    link.send(frames, node)
            except LinkError as error:
                return self.fail(str(error))
        if connection.unsent:
            self._drop_unsent(connection)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Record the start of ACTIVE for automatic recovery."""
        if self._connection is not None:
            self._connection.recovery.worked(self.now())
        return RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Request a reset if automatic recovery is due."""
        connection = self._connection
        if connection is None or self._under_way is not None:
            return RTC_OK
        context = self.get_context(ec_id)
        if context is not None and connection.recovery.due(
            self.now(), up=connection.link.up
        ):
            log.warning("%s: recovers from: %s", self.instance_name, self.reason)
            context.reset_component(self)
        return RTC_OK

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Activate the component again after an automatic reset."""
        context, connection = self.get_context(ec_id), self._connection
        if (
            context is not None
            and connection is not None
            and connection.recovery.resumes()
        ):
            # In this tick the component is still in ERROR.
            self._at_end_of_cycle(lambda: _activate(context, self))
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Deliver the last samples; a component that is finalized stops its node."""
        connection = self._connection
        if connection is None:
            return RTC_OK
        connection.deliver()
        connection.pause()
        control = connection.control
        # a manager that ended earlier has switched its nodes to pre-operational
        if control.running and control.can_command:
            return self._command(NmtCommand.ENTER_PRE_OPERATIONAL)
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the node, or keep it in a state with SDO."""
        self._under_way = None
        connection = self._connection
        if connection is None:
            return RTC_OK
        connection.recovery.failed(self.now())
        connection.pause()
        connection.node.queue.clear()
        if connection.settings.sdo_in_error:
            return self._command(NmtCommand.ENTER_PRE_OPERATIONAL)
        if connection.node.state is NmtState.STOPPED:
            return RTC_OK
        return self._command(NmtCommand.STOP)

    # Objects

    def read_object(self, index: int, subindex: int = 0) -> ObjectValue:
        """See `ProxyHooks`; returns octets for an object that is not in the description."""
        described = self.description.by_number.get((index, subindex))
        if described is None:
            return self.read_octets(index, subindex)
        octets = self.read_octets(index, subindex)
        try:
            return values.uploaded(described.kind, octets)
        except values.ObjectValueError as error:
            raise SdoAbort(error.code) from error

    def write_object(self, index: int, subindex: int, value: ObjectValue) -> None:
        """See `ProxyHooks`."""
        described = self.description.by_number.get((index, subindex))
        kind = "octets" if described is None else described.kind
        self.write_octets(index, subindex, values.encode(kind, value))

    def read_octets(self, index: int, subindex: int) -> bytes:
        """See `ProxyHooks`."""
        described = self.description.by_number.get((index, subindex))
        large = described is None or described.kind == "octets"
        channel = self._channel()
        return self._in_blocks(
            large, lambda block: channel.upload(index, subindex, block=block)
        )

    def write_octets(self, index: int, subindex: int, value: bytes) -> None:
        """See `ProxyHooks`."""
        channel = self._channel()

        def write(block: bool) -> bytes:
            channel.download(index, subindex, value, block=block)
            return b""

        self._in_blocks(len(value) >= _BLOCK, write)

    def _channel(self) -> SdoChannel:
        """Return the node's SDO client. Raises SdoAbort for a node that is known to be stopped."""
        connection = self._joined()
        if connection.node.state is NmtState.STOPPED:
            # CiA 301, table 38: it would not respond.
            raise SdoAbort(sdo.DEVICE_STATE)
        return connection.link.sdo(connection.node.node_id)

    def _in_blocks(self, large: bool, transfer: Callable[[bool], bytes]) -> bytes:
        """Transfer by blocks if `large`.

        Falls back to segments if the server does not support block transfer.
        """
        if large and not self._without_blocks:
            try:
                return transfer(True)
            except SdoAbort as abort:
                # The server rejected it before anything was written.
                if abort.code != sdo.COMMAND_UNKNOWN:
                    raise
                self._without_blocks = True
        return transfer(False)

    # Interface to the runtime

    @property
    def lost(self) -> int:
        """See `Component`; includes dropped PDOs, and samples that are not sent."""
        connection = self._connection
        dropped = 0 if connection is None else connection.node.dropped
        return super().lost + self._dropped + dropped

    def _counts(self, *names: str) -> tuple[float, ...]:
        """Return these counts of the node since joining the bus; 0 before."""
        node = None if self._connection is None else self._connection.node
        return tuple(float(getattr(node, name, 0)) for name in names)

    def _gate(self, request: Request) -> ReturnCode_t | None:
        try:
            if self._under_way is None or self._under_way[0] is not request:
                self._under_way = request, self._steps(request)
            self._awaited = next(self._under_way[1])
            return None
        except StopIteration:
            self._under_way = None
            return RTC_OK
        except (NodeError, SdoAbort, LinkError, ValueError) as error:
            self._under_way = None
            if self._connection is not None:
                self._connection.recovery.failed(self.now())
            return self.fail(reason_of(error))

    def _steps(self, request: Request) -> Steps:
        # a transition in progress ends with the same node, even if parameters have changed
        ending = request is Request.DEACTIVATE
        connection = self._joined() if ending else self._connect()
        if not connection.link.up:
            raise LinkError("the bus is gone")
        if request is Request.ACTIVATE:
            connection.node.listen(connection.link.now())
            return connection.control.activation(self._parameter_values)
        if ending:
            return connection.control.deactivation()
        return connection.control.reset()

    def _arrived(self) -> None:
        if self._connection is not None:
            self._connection.deliver()

    def _drop_unsent(self, connection: ProxyConnection) -> None:
        """Count the samples of PDOs that the proxy does not send, and report them once."""
        for number, sender, why in connection.unsent:
            try:
                dropped = sum(1 for _ in sender())
            except PdoError:
                dropped = 1
            if dropped:
                self._dropped += dropped
                if number not in self._reported:
                    self._reported.add(number)
                    log.warning(
                        "%s: rpdo%d is not sent: %s", self.instance_name, number, why
                    )

    def _command(self, command: NmtCommand) -> ReturnCode_t:
        """Send an NMT command where waiting is impossible."""
        assert self._connection is not None
        try:
            self._connection.control.command(command)
        except (NodeError, LinkError) as error:
            return self.fail(str(error))
        return RTC_OK

    def _parameters_changed(self) -> None:
        """Write the changed parameters, if the device is active."""
        connection = self._connection
        if connection is None or not self.is_active:
            return
        node, written = connection.node, connection.control.written
        try:
            changed = {
                number: value
                for number, value in self._parameter_values().items()
                if written.get(number) != value
            }
            writes = connection.control.parameter_writes(changed)
        except ValueError as error:
            self._warn(str(error))
            return
        written.update(changed)
        channel = connection.link.sdo(node.node_id)
        for number, octets in writes:
            done = self._written(connection, number)
            channel.submit_download(*number, octets, done)

    def _written(
        self, connection: ProxyConnection, number: ObjectNumber
    ) -> Callable[[Outcome], None]:
        def done(outcome: Outcome) -> None:
            if isinstance(outcome, SdoAbort):
                connection.control.written.pop(number, None)
                name = self.description.by_number[number].name
                self._warn(f"{name} cannot be written: {outcome}")

        return done

    def _warn(self, what: str) -> None:
        """Report an error that does not stop the work."""
        self.reason = what
        log.warning("%s: %s", self.instance_name, what)

    # Bus

    def _joined(self) -> ProxyConnection:
        """Return the connection. Raises LinkError without one."""
        if self._connection is None:
            raise LinkError(f"{self.instance_name} is on no bus")
        return self._connection

    def _connect(self) -> ProxyConnection:
        """Join the bus of the current parameters. Raises LinkError, or NodeError."""
        settings = settings_of(self.config)
        if self._connection is not None:
            if self._connection.settings == settings:
                return self._connection
            self._disconnect()
        self._without_blocks = False
        network, placed = place(
            self.networks, settings.network, settings.node_id, self.description.name
        )
        plan = planned(self.description, settings, network, placed)
        node = ProxiedNode(
            settings.node_id,
            plan.wiring.received,
            self._receivers(),
            StateMirror(
                self,
                lambda: self._under_way is not None,
                self._timeout,
                lambda: link.now(),
                plan.emergencies,
                self._warn,
            ),
            plan.transmitters.values(),
            *cob_ids(self.description, settings.node_id, network, placed),
        )
        senders = self._senders()
        link = open_link(
            self, settings.interface, settings.channel, plan.bit_rate, settings.options
        )
        control = NodeControl(
            link,
            node,
            self.description,
            placed,
            master=settings.master,
            heartbeat_timeout=settings.heartbeat_timeout * MILLISECOND,
            boot_timeout=plan.boot_timeout * MILLISECOND,
        )
        connection = self._connection = ProxyConnection(
            settings,
            link,
            node,
            control,
            plan.sent(senders),
            plan.unsent(senders),
            self.now() - link.now(),
            Recovery(plan.recoveries),
        )
        link.attach(node)
        return connection

    def _timeout(self) -> int:
        connection = self._connection
        return 0 if connection is None else connection.control.timeout

    def _disconnect(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            self._dropped += connection.node.dropped
            connection.link.detach(connection.node)


def _activate(context: ExecutionContextOperations, proxy: CanopenProxy) -> None:
    context.activate_component(proxy)
