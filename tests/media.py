"""Networks of processes for tests: engines with media, and transports of systems."""

from __future__ import annotations

import atexit
import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Protocol

import pytest
from free_ports import free_port
from in_process import Network
from msgspec.structs import astuple

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated
from rtgen.runtime.distribution.medium import (
    Client,
    Medium,
    OnRequest,
    OnSample,
    Publisher,
    Qos,
    Sample,
    Subscription,
    Token,
    Topic,
    type_name,
)
from rtgen.runtime.distribution.transport import DistributedTransport

if TYPE_CHECKING:
    from rtgen.runtime.ros2.network import (
        RosNetwork,
        RosNode,
        RosQos,
        RosService,
        RosTopic,
    )

SYSTEM = "conformance"
DOMAIN = 90
_RESERVING_PORT = 21_000
"""A domain is reserved by the port of this number plus its own."""
LEASE = 1.5
"""Seconds after which a process without signs of life is lost, in tests of that."""


class Engine(Protocol):
    """Creates media that see each other, but no others."""

    def medium(self, system: str = SYSTEM) -> Medium: ...

    @property
    def address(self) -> str | None:
        """The argument of `medium_at` in another process; None if that is impossible."""
        ...


class _InProcess:
    address = None

    def __init__(self) -> None:
        self._networks: dict[str, Network] = {}

    def medium(self, system: str = SYSTEM) -> Medium:
        return self._networks.setdefault(system, Network()).medium()


class _Zenoh:
    """Peers that meet at one port, or clients of a router."""

    def __init__(self, lease: float | None, *, routed: bool) -> None:
        self.locator = f"tcp/127.0.0.1:{free_port()}"
        self.address = json.dumps({"zenoh": (self.locator, lease)})
        self._lease = lease
        self._routed = routed
        self._first = not routed

    def medium(self, system: str = SYSTEM) -> Medium:
        from rtgen.runtime.zenoh.medium import ZenohMedium
        from rtgen.runtime.zenoh.session import Endpoints

        if not (self._routed or self._first):
            return medium_at(self.address, system)
        self._first = False
        own = (self.locator,)
        connect, listen = (own, ()) if self._routed else ((), own)
        return ZenohMedium(system, Endpoints(None, connect, listen, self._lease))


class _Dds:
    """Participants of one domain, in a partition of their own."""

    def __init__(self, config: Path | None) -> None:
        file = None if config is None else str(config)
        partition = f"test-{os.urandom(8).hex()}"
        self.address = json.dumps({"dds": (partition, file)})

    def medium(self, system: str = SYSTEM) -> Medium:
        return medium_at(self.address, system)


@contextmanager
def _dds(lease: float | None) -> Iterator[Engine]:
    from rtgen.runtime.dds.medium import configuration

    if lease is None:
        yield _Dds(None)
        return
    with TemporaryDirectory() as folder:
        config = Path(folder) / "cyclonedds.xml"
        config.write_text(configuration(None, lease, lease), encoding="ascii")
        yield _Dds(config)


def medium_at(address: str, system: str = SYSTEM) -> Medium:
    """Return a medium of another process on the same network."""
    [(engine, (place, more))] = json.loads(address).items()
    if engine == "dds":
        from rtgen.runtime.dds.medium import DdsMedium

        config = None if more is None else Path(more)
        return DdsMedium(f"{place}/{system}", domain=DOMAIN, config=config)
    from rtgen.runtime.zenoh.medium import ZenohMedium
    from rtgen.runtime.zenoh.session import Endpoints

    return ZenohMedium(system, Endpoints(None, (place,), ("tcp/127.0.0.1:0",), more))


class _Ros:
    """Processes on a network of ROS 2, with a domain for each system."""

    address = None

    def __init__(self, opened: Callable[[RosNode], RosNetwork]) -> None:
        self._opened = opened
        self._domains: dict[str, int] = {}

    def medium(self, system: str = SYSTEM) -> Any:
        from rtgen.runtime.ros2.network import RosNode

        domain = self._domains.setdefault(system, own_domain() + len(self._domains))
        return _AsRos(self._opened(RosNode("node", "/", domain)))


class _AsRos:
    """Carries the octets of the suite in messages of ROS 2."""

    def __init__(self, network: RosNetwork) -> None:
        self._medium = network.medium
        self.close = network.close

    def publisher(self, topic: Topic, qos: Qos) -> Publisher:
        described, ros_qos = _ros(topic, qos)
        made = self._medium.publisher(described, ros_qos)
        publish = made.publish
        made.publish = lambda octets: publish(_wrapped(described.type, octets))  # type: ignore[method-assign]
        return made

    def subscribe(self, topic: Topic, qos: Qos, on_sample: OnSample) -> Subscription:
        described, ros_qos = _ros(topic, qos)

        def take(sample: Sample) -> None:
            octets = _unwrapped(described.type, sample.octets)
            on_sample(Sample(octets, sample.source, sample.sequence))

        return self._medium.subscribe(described, ros_qos, take)

    def serve(self, service: str, types: object, on_request: OnRequest) -> Token:
        described = _ros_service(service)

        def take(octets: bytes, reply: Callable[[bytes], None]) -> None:
            on_request(
                _unwrapped(described.request, octets),
                lambda answer: reply(_wrapped(described.reply, answer)),
            )

        return self._medium.serve(described.name, (described,), take)

    def client(self, service: str, types: object) -> Client:
        described = _ros_service(service)
        made = self._medium.client(described.name, described)
        call = made.call

        def wrapping(octets: bytes, timeout: float) -> bytes:
            reply = call(_wrapped(described.request, octets), timeout)
            return _unwrapped(described.reply, reply)

        made.call = wrapping  # type: ignore[method-assign]
        return made


def _wrapped(message: Any, octets: bytes) -> bytes:
    return b"\0\1\0\0" + bytes(message(octets).to_cdr(True))


def _unwrapped(message: Any, octets: bytes) -> bytes:
    return bytes(astuple(message.from_cdr(octets[4:], True))[0])


def _ros(topic: Topic, qos: Qos) -> tuple[RosTopic, RosQos]:
    from rtgen.facts.ros_qos import Durability, History, Profile, Reliability
    from rtgen.runtime.ros2.network import RosQos, RosTopic

    profile = Profile(
        depth=qos.depth or 10,
        reliability=(Reliability.RELIABLE if qos.reliable else Reliability.BEST_EFFORT),
        durability=Durability.TRANSIENT_LOCAL if qos.durable else Durability.VOLATILE,
        history=History.KEEP_ALL if qos.depth is None else History.KEEP_LAST,
    )
    message = _message(f"msg::{type_name(topic.type).rpartition('::')[2]}")
    return RosTopic(f"/{topic.name}", message), RosQos.of(profile)


def _ros_service(service: str) -> RosService:
    from rtgen.runtime.ros2.network import RosService

    request, reply = _message("srv::Octets_Request"), _message("srv::Octets_Response")
    return RosService(request, reply, f"/{service}", _message("msg::Event"))


@cache
def _message(name: str) -> Any:
    """Return a class of messages with octets, as a member whose name tells types apart."""
    last = name.rpartition("::")[2]
    member = last.lower()
    namespace = {
        "__annotations__": {member: bytes},
        "__module__": __name__,
        "_descriptor_": idl.struct(
            f"suite::{name}", **{member: idl.sequence(idl.OCTET)}
        ),
        member: b"",
    }
    return type(Aggregated)(last, (Aggregated,), namespace)


def _ros_zenoh() -> Callable[[RosNode], RosNetwork]:
    """Return what opens peers that meet at the first one."""
    from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

    place = f"tcp/127.0.0.1:{free_port()}"
    first = [configuration(connect=None, listen=place)]

    def opened(node: RosNode) -> RosNetwork:
        config = first.pop() if first else configuration(connect=place)
        return open_zenoh(node, config=config)

    return opened


@contextmanager
def router(locator: str, *others: str) -> Iterator[Any]:
    """Yield a session of Zenoh in router mode, which forwards between its clients and others."""
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": "router",
        "listen/endpoints": [locator],
        "connect/endpoints": others,
        "scouting/multicast/enabled": False,
        "scouting/delay": 0,
        # A large sample is not dropped because the machine is loaded.
        "transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments": 1_000_000,
    }.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config) as session:
        yield session


@contextmanager
def engine(name: str, lease: float | None = None) -> Iterator[Engine]:
    """Yield a separate network of an engine; `lease` [s] overrides the engine's default."""
    match name:
        case "in-process":
            yield _InProcess()
        case "dds":
            pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
            with _dds(lease) as network:
                yield network
        case "zenoh":
            pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
            yield _Zenoh(lease, routed=False)
        case "zenoh-router":
            pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
            routed = _Zenoh(lease, routed=True)
            with router(routed.locator):
                yield routed
        case "ros2-dds":
            pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
            from rtgen.runtime.ros2.dds import open_dds

            yield _Ros(open_dds)
        case "ros2-zenoh":
            pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
            yield _Ros(_ros_zenoh())


ENGINES = ("in-process", "dds", "zenoh", "zenoh-router")
MESSAGING = (
    *ENGINES,
    "ros2-dds",
    # Discovery takes it seconds: it is tried on one interpreter.
    pytest.param("ros2-zenoh", marks=pytest.mark.slow),
)
"""Engines, and those with the names of ROS 2, which have topics and services only."""


class Transports(Protocol):
    """Opens transports of one system, each that of a process."""

    def open(self, timeout: float) -> Any:
        """Return a transport, which is closed by its owner; `timeout` [s] of its calls."""

    @property
    def address(self) -> str | None:
        """The argument of `transport_at` in another process; None if that is impossible."""


class _Distributed:
    """Transports on an engine."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self.address = engine.address

    def open(self, timeout: float) -> Any:
        return DistributedTransport(self._engine.medium(), timeout=timeout)


class _Corba:
    """Transports that share a naming service."""

    def __init__(self, name_server: str) -> None:
        self.address = json.dumps({"corba": name_server})

    def open(self, timeout: float) -> Any:
        return transport_at(self.address, timeout)


def transport_at(address: str, timeout: float) -> Any:
    """Return the transport of another process of the same system."""
    [(kind, place)] = json.loads(address).items()
    if kind != "corba":
        return DistributedTransport(medium_at(address), timeout=timeout)
    from rtgen.runtime.corba.transport import NamedCorba

    return NamedCorba(name_server=place, timeout=timeout)


@contextmanager
def transports(name: str, lease: float | None = None) -> Iterator[Transports]:
    """Yield the transports of a separate system; `lease` as for `engine`."""
    if name != "corba":
        with engine(name, lease) as network:
            yield _Distributed(network)
        return
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    from rtgen.runtime.corba.name_server import NameServer

    with NameServer() as server:
        yield _Corba(server.address)


TRANSPORTS = (*ENGINES, "corba")


@cache
def own_domain() -> int:
    """Return a domain of DDS that no other process of these tests uses until this one ends.

    Topics of ROS 2 have no partition, so equal nodes of two processes would see each other.
    """
    for domain in range(100, 200):
        held = socket.socket()
        try:
            held.bind(("127.0.0.1", _RESERVING_PORT + domain))
        except OSError:
            held.close()
            continue
        atexit.register(held.close)
        return domain
    raise AssertionError("all domains are in use")
