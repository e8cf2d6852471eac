"""A drive's proxy as rtgen would make it, and a simple node that can be told to misbehave."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from stations import Recorder

from refrobots.rtc import Time, TimedLong
from rtgen.runtime import (
    ComponentProfile,
    LifeCycleState,
    ParameterProfile,
    RealClock,
    ReturnCode_t,
    SampleRecord,
    SimulatedClock,
    StateRecord,
    System,
)
from rtgen.runtime.canopen import sdo
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectDescription,
    ObjectNumber,
    ObjectValue,
    PdoDescription,
)
from rtgen.runtime.canopen.frames import (
    ERROR_CONTROL,
    MILLISECOND,
    NMT,
    SDO_REQUEST,
    Frame,
)
from rtgen.runtime.canopen.heartbeat import HeartbeatProducer
from rtgen.runtime.canopen.hooks import Receiver, Sender
from rtgen.runtime.canopen.link import Link
from rtgen.runtime.canopen.links import open_link
from rtgen.runtime.canopen.nmt import (
    NmtSlave,
    NmtState,
    Service,
    decode_command,
)
from rtgen.runtime.canopen.pdo import outside
from rtgen.runtime.canopen.port_samples import unread
from rtgen.runtime.canopen.proxy import CanopenProxy
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.sdo_server import SdoServer
from rtgen.runtime.canopen.simulated_bus import SimulatedCanBus

NODE = 5
MS = MILLISECOND
SECOND = 1000 * MS

DESCRIPTION = DeviceDescription(
    "Drive",
    (
        ObjectDescription(0x1000, 0, "Device_type", "u32", "ro", 0x20192),
        ObjectDescription(0x1001, 0, "Error_register", "u8", "ro", 0),
        ObjectDescription(0x1008, 0, "Device_name", "string", "const", "drive"),
        ObjectDescription(0x1017, 0, "Heartbeat_time", "u16", "rw", 0),
        ObjectDescription(0x1018, 1, "Vendor", "u32", "ro", 0x111),
        ObjectDescription(0x1018, 2, "Product", "u32", "ro", 0x222),
        ObjectDescription(0x2000, 0, "Program", "octets", "rw"),
        ObjectDescription(0x6064, 0, "Position", "i32", "ro", mappable=True),
        ObjectDescription(0x607A, 0, "Target", "i32", "rw", mappable=True),
        ObjectDescription(0x6083, 0, "Acceleration", "u32", "rw", 1000),
    ),
    (
        PdoDescription("tpdo", 1, 0x180, True, 255, ((0x6064, 0, 32),)),
        PdoDescription("rpdo", 1, 0x200, True, 255, ((0x607A, 0, 32),)),
    ),
    vendor_id=0x111,
    product_code=0x222,
)


@dataclass(slots=True)
class Configuration:
    interface: str = "virtual"
    channel: str = "can0"
    bitrate: int = 0
    options: str = ""
    node_id: int = NODE
    network: str = ""
    master: bool = True
    heartbeat_timeout: int = 0
    boot_timeout: int = 2000
    emergency_stop: str = ""
    recoveries: int = 0
    sdo_in_error: bool = False
    Acceleration: int = 1000


_TYPES = {str: "string", bool: "boolean", int: "long"}


class DriveProxy(CanopenProxy):
    """OutPort `tpdo1` has positions, InPort `rpdo1` targets."""

    description = DESCRIPTION
    networks = "canopen_networks"
    profile = ComponentProfile(
        "DriveProxy",
        rate=100.0,
        configuration=tuple(
            ParameterProfile(name, name, _TYPES[type(value)], str(value))
            for name, value in (
                (n, getattr(Configuration(), n)) for n in Configuration.__slots__
            )
        ),
    )

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.tpdo1 = self.add_out_port("tpdo1", TimedLong)
        self.rpdo1 = self.add_in_port("rpdo1", TimedLong)
        self.config = self.add_configuration(Configuration())
        self.calls: list[str] = []

    def _receivers(self) -> Mapping[int, Receiver]:
        return {1: self._receive_tpdo1}

    def _senders(self) -> Mapping[int, Sender]:
        return {1: self._send_rpdo1}

    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:
        value = self.config.Acceleration
        if value < 0:
            raise outside("Acceleration", value, 0, 2**32 - 1)
        return {(0x6083, 0): value}

    def _receive_tpdo1(self, data: bytes, now: int) -> None:
        (value,) = struct.unpack("<i", data)
        self.tpdo1.write(TimedLong(Time(*divmod(now, SECOND)), value))

    def _send_rpdo1(self) -> Iterator[bytes]:
        for sample in unread(self.rpdo1):
            if sample.data > 10**9:
                raise outside("Target", sample.data, -(10**9), 10**9)
            yield struct.pack("<i", sample.data)

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        self.calls.append("on_activated")
        return super().on_activated(ec_id)

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        self.calls.append("on_deactivated")
        return super().on_deactivated(ec_id)

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        self.calls.append("on_aborting")
        return super().on_aborting(ec_id)

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        self.calls.append("on_reset")
        return super().on_reset(ec_id)


class Objects:
    """Octets by number; `aborts` has the codes of those that are refused, and how."""

    def __init__(self) -> None:
        self.values: dict[ObjectNumber, bytes] = {
            (0x1000, 0): struct.pack("<I", 0x20192),
            (0x1008, 0): b"drive",
            (0x1017, 0): struct.pack("<H", 0),
            (0x1018, 1): struct.pack("<I", 0x111),
            (0x1018, 2): struct.pack("<I", 0x222),
            (0x2000, 0): b"",
            (0x6083, 0): struct.pack("<I", 1000),
        }
        self.aborts: dict[tuple[str, ObjectNumber], int] = {}
        self.writes: list[tuple[ObjectNumber, bytes]] = []

    def read(self, index: int, subindex: int) -> bytes:
        self._check("read", (index, subindex))
        return self.values[index, subindex]

    def writable_size(self, index: int, subindex: int) -> int:
        self._check("write", (index, subindex))
        return 10**6

    def write(self, index: int, subindex: int, value: bytes) -> None:
        self.values[index, subindex] = value
        self.writes.append(((index, subindex), value))

    def _check(self, way: str, number: ObjectNumber) -> None:
        if (code := self.aborts.get((way, number))) is not None:
            raise SdoAbort(code)
        if number not in self.values:
            raise SdoAbort(sdo.NO_OBJECT)


class SimpleNode:
    """A slave with SDO, NMT and heartbeat alone; it boots `delay` after a reset."""

    def __init__(
        self, link: Link, node_id: int = NODE, *, objects: Objects | None = None
    ) -> None:
        self.link = link
        self.id = node_id
        self.objects = objects or Objects()
        self.obeys = True
        self.delay = 10 * MS
        self.commands: list[int] = []
        self.nmt = NmtSlave(node_id)
        self.period = 0
        self._server = SdoServer(node_id, self.objects)
        self._producer = HeartbeatProducer(node_id)
        self._boot: int | None = None
        self.identifiers = frozenset((NMT, SDO_REQUEST + node_id))
        link.attach(self)

    @property
    def deadline(self) -> int | None:
        times = (self._boot, self._producer.deadline, self._server.deadline)
        return min((t for t in times if t is not None), default=None)

    @property
    def state(self) -> NmtState:
        return self.nmt.state

    def boot(self) -> None:
        with self.link.lock:
            self.send(*self._boots(self.link.now()))
            self.link.refresh(self)

    def go(self, state: NmtState) -> None:
        """Changes the state by itself, and tells it at once."""
        with self.link.lock:
            self.nmt.state = state
            self.beat(state)

    def beat(self, state: NmtState) -> None:
        self.send(Frame(ERROR_CONTROL + self.id, bytes((state,))))

    def mute(self) -> None:
        """Sends no heartbeat any more."""
        with self.link.lock:
            self._producer.stop()
            self.link.refresh(self)

    def leave(self) -> None:
        self.link.detach(self)

    def send(self, *frames: Frame) -> None:
        self.link.send(frames, self)

    def send_position(self, value: int) -> None:
        self.send(Frame(0x180 + self.id, struct.pack("<i", value)))

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        if frame.can_id == NMT:
            told = decode_command(frame)
            if told is not None and told[1] in (0, self.id):
                self.commands.append(told[0])
            if not self.obeys:
                return ()
            self.nmt.receive(frame)
            if self.nmt.state is NmtState.INITIALISING:
                self._producer.stop()
                self._server.reset()
                self._boot = now + self.delay
            return ()
        if not self.nmt.allows(Service.SDO):
            return ()
        answers = self._server.receive(frame, now)
        period = struct.unpack("<H", self.objects.values[0x1017, 0])[0] * MS
        if period != self.period:
            self.period = period
            self._producer.configure(period, now)
        return answers

    def poll(self, now: int) -> Iterable[Frame]:
        frames = self._server.poll(now)
        beat = self._producer.poll(now, self.nmt.state)
        frames += [beat] if beat is not None else []
        if self._boot is not None and now >= self._boot:
            frames += self._boots(now)
        return frames

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()

    def _boots(self, now: int) -> list[Frame]:
        self._boot = None
        self.objects.values[0x1017, 0] = struct.pack("<H", self.period // MS)
        frame = self.nmt.boot()
        self._producer.configure(self.period, now)
        self._producer.booted(now)
        return [frame]


@dataclass
class Bench:
    """A system with a proxy, its bus with a node of the same process, and what was seen."""

    clock: SimulatedClock | RealClock = field(default_factory=SimulatedClock)
    settings: Mapping[str, Any] = field(default_factory=dict)
    node: SimpleNode = field(init=False)

    def __post_init__(self) -> None:
        self.system = System(self.clock)
        self.states: list[StateRecord] = []
        self.samples: list[SampleRecord] = []
        self.system.add_listener(self._note)
        self.proxy = DriveProxy("Drive0")
        for name, value in self.settings.items():
            self.proxy.configuration_sets.set(name, str(value))
        self.link = open_link(self.clock, "virtual", "can0")
        self.recorder = Recorder()
        self.link.attach(self.recorder)
        self.system.add(self.proxy)

    @property
    def bus(self) -> SimulatedCanBus:
        assert isinstance(self.link, SimulatedCanBus)
        return self.link

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *exception: object) -> None:
        self.system.close()

    def with_node(self, **settings: Any) -> SimpleNode:
        self.node = SimpleNode(self.link, **settings)
        self.node.boot()
        return self.node

    @property
    def state(self) -> str:
        return self.system.state("Drive0").name.removesuffix("_STATE")

    @property
    def reason(self) -> str:
        return self.proxy.reason

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def until(self, state: str, seconds: float = 10.0) -> None:
        """Runs till the proxy is in a state; fails if it does not get there."""
        wanted = LifeCycleState[f"{state}_STATE"]
        limit = self.system.time + round(seconds * SECOND)
        self.system.run(limit, until=lambda s: s.state("Drive0") is wanted)
        assert self.state == state, self.reason

    def activate(self) -> None:
        self.system.activate("Drive0")
        self.until("ACTIVE")

    def commands(self) -> list[tuple[int, int]]:
        """NMT commands on the bus."""
        return [(f.data[0], f.data[1]) for f in self.recorder.frames if f.can_id == NMT]

    def told(self) -> list[int]:
        """States in the node's error control on the bus, without repetitions."""
        found: list[int] = []
        for frame in self.recorder.frames:
            if frame.can_id == ERROR_CONTROL + NODE and frame.data[0] not in found[-1:]:
                found.append(frame.data[0])
        return found

    def values(self) -> list[int]:
        return [s.value.data for s in self.samples if s.port == "tpdo1"]

    def _note(self, record: StateRecord | SampleRecord) -> None:
        if isinstance(record, StateRecord):
            self.states.append(record)
        else:
            self.samples.append(record)
