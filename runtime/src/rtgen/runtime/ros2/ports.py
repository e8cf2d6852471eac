"""Data ports as topics: samples of OutPorts are published, messages are written to InPorts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec

from rtgen.facts.ros_qos import Profile
from rtgen.runtime.cdr import CdrError
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


class TopicReader:
    """Writes messages of a topic to an InPort; `invalid` counts those that could not be decoded."""

    def __init__(
        self, network: RosNetwork, port: InPort[Any], topic: RosTopic, joint: Joint
    ) -> None:
        self.invalid = 0
        self._type = topic.type
        self._marshaling = joint.marshaling
        outside: OutPort[Any] = OutPort("topic", port.type, topic.name.strip("/"))
        self._connector = DataConnector(
            topic.name, outside, port, {}, lambda: port._guard
        )
        self._connector.attach()
        network.subscribe(topic, joint.profile, self._take)

    def _take(self, octets: bytes) -> None:
        port = self._connector.target
        try:
            value = decoded(self._type, octets)
            if self._marshaling is not None:
                value = self._marshaling.of_message(value)
        except (CdrError, ValueError) as error:
            self.invalid += 1
            if self.invalid == 1:
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
        self._made: list[TopicWriter | TopicReader] = []
        try:
            for joint in joints:
                marshaling = joint.marshaling
                type_ = joint.port.type if marshaling is None else marshaling.message
                topic = RosTopic(joint.topic, type_, joint.node)
                self._made.append(_made(network, joint, topic))
        except Ros2Error:
            self.close()
            raise

    def close(self) -> None:
        """Disconnect the ports, and close the network."""
        for each in self._made:
            each.close()
        self._network.close()


def _made(
    network: RosNetwork, joint: Joint, topic: RosTopic
) -> TopicWriter | TopicReader:
    if isinstance(joint.port, OutPort):
        return TopicWriter(network, joint.port, topic, joint)
    return TopicReader(network, joint.port, topic, joint)
