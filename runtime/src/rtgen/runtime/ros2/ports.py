"""Data ports as topics: samples of OutPorts are published, messages are written to InPorts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec

from rtgen.facts.ros_qos import Profile, seconds
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.medium import Subscription
from rtgen.runtime.failures import log
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.ros2.marshaling import Marshaling
from rtgen.runtime.ros2.network import Ros2Error, RosNetwork, RosTopic
from rtgen.runtime.ros2.types import decoded, encoded


class Joint(msgspec.Struct, frozen=True):
    """A port of the system with its topic, by its fully qualified name.

    `marshaling` is for data sent as another message, `node` as in `RosTopic`.
    """

    port: InPort[Any] | OutPort[Any]
    topic: str
    profile: Profile
    marshaling: Marshaling | None = None
    node: str = ""


class TopicWriter:
    """Publishes the samples of an OutPort."""

    def __init__(
        self, network: RosNetwork, port: OutPort[Any], topic: RosTopic, joint: Joint
    ) -> None:
        self._publish = network.publisher(topic, joint.profile)
        self._port = port
        self._marshaling = joint.marshaling
        port.add_outlet(self.send)

    def send(self, value: Any) -> PortStatus:
        """Publish a sample. Raises CdrError.

        PORT_ERROR if the network fails, or for a value without counterpart in its message.
        """
        try:
            if self._marshaling is not None:
                octets = self._marshaled(self._marshaling, value)
            else:
                octets = encoded(value)
            self._publish(octets)
        except Ros2Error as error:
            log.warning("%s: %s", self._port, error)
            return PortStatus.PORT_ERROR
        return PORT_OK

    def _marshaled(self, marshaling: Marshaling, value: Any) -> bytes:
        try:
            return encoded(marshaling.to_message(value))
        except (CdrError, ValueError) as error:
            raise Ros2Error(f"a sample cannot be sent: {error}") from error

    def close(self) -> None:
        """Stop publishing."""
        self._port.remove_outlet(self.send)


class TopicConnector(DataConnector[Any]):
    """The connection of an InPort with a topic; `invalid` messages could not be decoded."""

    def __init__(self, port: InPort[Any], topic: str, profile: Profile) -> None:
        outside: OutPort[Any] = OutPort("topic", port.type, topic.strip("/"))
        super().__init__(topic, outside, port, {}, lambda: port._guard)
        self.invalid = 0
        self.subscription: Subscription | None = None
        self.deadline = seconds(profile.deadline)
        self.why_missed = (
            "lost in the network, not to be decoded, or more than the depth of "
            f"{profile.depth} waited: depth in [ros2.topics] of rtgen.toml keeps more"
        )

    @property
    def missed(self) -> int:
        """See `DataConnector`."""
        return self.invalid + (self.subscription.lost if self.subscription else 0)

    @property
    def missed_deadlines(self) -> int:
        """See `DataConnector`."""
        return self.subscription.missed_deadlines if self.subscription else 0


class TopicReader:
    """Writes messages of a topic to an InPort."""

    def __init__(
        self, network: RosNetwork, port: InPort[Any], topic: RosTopic, joint: Joint
    ) -> None:
        self._type = topic.type
        self._marshaling = joint.marshaling
        self._connector = TopicConnector(port, topic.name, joint.profile)
        self._connector.attach()
        subscription = network.subscribe(topic, joint.profile, self._take)
        self._connector.subscription = subscription

    @property
    def invalid(self) -> int:
        """Number of messages that could not be decoded."""
        return self._connector.invalid

    def _take(self, octets: bytes) -> None:
        port = self._connector.target
        try:
            value = decoded(self._type, octets)
            if self._marshaling is not None:
                value = self._marshaling.of_message(value)
        except (CdrError, ValueError) as error:
            self._connector.invalid += 1
            if self._connector.invalid == 1:
                log.warning("%s: a message cannot be decoded: %s", port, error)
            return
        self._connector.give(value)

    def close(self) -> None:
        """Stop receiving."""
        self._connector.detach()


class RosPorts:
    """The ports of a system that are topics, until `close`, which closes the network."""

    def __init__(self, network: RosNetwork, joints: Iterable[Joint]) -> None:
        """Connect the ports to their topics. Raises Ros2Error."""
        self._network = network
        self._ends: list[TopicWriter | TopicReader] = []
        try:
            for joint in joints:
                marshaling = joint.marshaling
                type_ = joint.port.type if marshaling is None else marshaling.message
                topic = RosTopic(joint.topic, type_, joint.node)
                self._ends.append(_end_of(network, joint, topic))
        except Ros2Error:
            self.close()
            raise

    def close(self) -> None:
        """Disconnect the ports, and close the network."""
        for each in self._ends:
            each.close()
        self._network.close()


def _end_of(
    network: RosNetwork, joint: Joint, topic: RosTopic
) -> TopicWriter | TopicReader:
    if isinstance(joint.port, OutPort):
        return TopicWriter(network, joint.port, topic, joint)
    return TopicReader(network, joint.port, topic, joint)
