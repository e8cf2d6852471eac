"""Data ports as topics: what an OutPort writes is published, what comes is given to an InPort."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rtgen.facts.ros_qos import Profile
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.failures import log
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.ros2.network import Ros2Error, RosNetwork, RosTopic
from rtgen.runtime.xcdr import deserialize

_HEAD = b"\x00\x01\x00\x00"
"""The encapsulation header of classic CDR, little endian, as ROS 2 writes it."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A port of the system with the topic that it is, by its fully qualified name."""

    port: InPort[Any] | OutPort[Any]
    topic: str
    profile: Profile


class TopicWriter:
    """Publishes what an OutPort writes."""

    def __init__(
        self, network: RosNetwork, port: OutPort[Any], topic: RosTopic, profile: Profile
    ) -> None:
        self._publish = network.publisher(topic, profile)
        self._port = port
        port.add_outlet(self.send)

    def send(self, value: Any) -> PortStatus:
        """Publish a sample. Raises CdrError. PORT_ERROR if the network fails."""
        octets = _HEAD + value.to_cdr(True)
        try:
            self._publish(octets)
        except Ros2Error as error:
            log.warning("%s: %s", self._port, error)
            return PortStatus.PORT_ERROR
        return PORT_OK

    def close(self) -> None:
        """Publish no more."""
        self._port.remove_outlet(self.send)


class TopicReader:
    """Gives an InPort what comes on a topic; `invalid` messages could not be decoded."""

    def __init__(
        self, network: RosNetwork, port: InPort[Any], topic: RosTopic, profile: Profile
    ) -> None:
        self.invalid = 0
        outside: OutPort[Any] = OutPort("topic", port.type, topic.name.strip("/"))
        self._connector = DataConnector(
            topic.name, outside, port, {}, lambda: port._guard
        )
        self._connector.attach()
        network.subscribe(topic, profile, self._take)

    def _take(self, octets: bytes) -> None:
        port = self._connector.target
        try:
            value = deserialize(port.type, octets)
        except CdrError as error:
            self.invalid += 1
            if self.invalid == 1:
                log.warning("%s: a message cannot be decoded: %s", port, error)
            return
        self._connector.give(value)

    def close(self) -> None:
        """Receive no more."""
        self._connector.detach()


class RosPorts:
    """The ports of a system that are topics, until `close`, which closes the network."""

    def __init__(self, network: RosNetwork, joints: Iterable[Joint]) -> None:
        """Raises Ros2Error."""
        self._network = network
        self._made: list[TopicWriter | TopicReader] = []
        try:
            for joint in joints:
                topic = RosTopic(joint.topic, joint.port.type)
                self._made.append(_made(network, joint, topic))
        except Ros2Error:
            self.close()
            raise

    def close(self) -> None:
        """Take the ports from the network, and close it."""
        for each in self._made:
            each.close()
        self._network.close()


def _made(
    network: RosNetwork, joint: Joint, topic: RosTopic
) -> TopicWriter | TopicReader:
    if isinstance(joint.port, OutPort):
        return TopicWriter(network, joint.port, topic, joint.profile)
    return TopicReader(network, joint.port, topic, joint.profile)
