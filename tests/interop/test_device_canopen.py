"""The slave with the `canopen` package as its master, over python-can's virtual bus.

Only time-outs that end a failed test depend on the clock.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from queue import Queue
from typing import Any

import canopen
import pytest
from canopen.objectdictionary import (
    BOOLEAN,
    DOMAIN,
    INTEGER8,
    INTEGER16,
    INTEGER24,
    INTEGER32,
    INTEGER40,
    INTEGER48,
    INTEGER56,
    INTEGER64,
    REAL32,
    REAL64,
    UNICODE_STRING,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED24,
    UNSIGNED32,
    UNSIGNED40,
    UNSIGNED48,
    UNSIGNED56,
    UNSIGNED64,
    VISIBLE_STRING,
    ODRecord,
    ODVariable,
)

from rtgen.runtime import RealClock
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.description import DeviceDescription, Kind, ObjectValue
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.nmt import NmtState

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from device_bench import DEVICE, NODE_ID, number_of
from test_object_values import BOUNDARIES

CHANNELS = count()
TIMEOUT = 20
CODES: dict[Kind, int] = {
    "bool": BOOLEAN, "i8": INTEGER8, "i16": INTEGER16, "i24": INTEGER24,
    "i32": INTEGER32, "i40": INTEGER40, "i48": INTEGER48, "i56": INTEGER56,
    "i64": INTEGER64, "u8": UNSIGNED8, "u16": UNSIGNED16, "u24": UNSIGNED24,
    "u32": UNSIGNED32, "u40": UNSIGNED40, "u48": UNSIGNED48, "u56": UNSIGNED56,
    "u64": UNSIGNED64, "r32": REAL32, "r64": REAL64, "string": VISIBLE_STRING,
    "wstring": UNICODE_STRING, "octets": DOMAIN, "char": VISIBLE_STRING,
    "time_of_day": DOMAIN, "time_difference": DOMAIN,
}  # fmt: skip


def dictionary() -> canopen.ObjectDictionary:
    """Return the bench device as an object dictionary of the package."""
    objects = canopen.ObjectDictionary()
    objects.node_id = NODE_ID
    records: dict[int, Any] = {}
    several = {o.index for o in DEVICE.objects if o.subindex}
    for described in DEVICE.objects:
        variable = ODVariable(described.name, described.index, described.subindex)
        variable.data_type = CODES[described.kind]
        variable.access_type = described.access
        variable.default = described.initial(NODE_ID)
        variable.pdo_mappable = described.mappable
        if described.index not in several:
            objects.add_object(variable)
            continue
        record = records.get(described.index)
        if record is None:
            record = ODRecord(f"r_{described.index:04X}", described.index)
            records[described.index] = record
            objects.add_object(record)
        record.add_member(variable)
    return objects


class Rig:
    """A slave on a real link, and the package's network and remote node."""

    def __init__(self, node: DeviceNode, *, boot: bool = True) -> None:
        channel = f"slave{next(CHANNELS)}"
        self.network = canopen.Network()
        self.network.connect(interface="virtual", channel=channel)
        self.network.lss.RESPONSE_TIMEOUT = TIMEOUT
        self.remote: Any = None
        self.meet()
        self.node = node
        self.link: Link = open_link(RealClock(), "virtual", channel)
        self.link.attach(node)
        if boot:
            with self.link.lock:
                self.send(node.boot(self.link.now()))

    def meet(self) -> None:
        """Restart the package's end."""
        if self.remote is not None:
            del self.network[NODE_ID]
        self.remote = canopen.RemoteNode(NODE_ID, dictionary())
        self.network.add_node(self.remote)
        self.remote.sdo.RESPONSE_TIMEOUT = TIMEOUT

    def reset(self) -> None:
        """Restart both ends."""
        with self.link.lock:
            self.node.store.values.clear()
            self.send(self.node.reset(self.link.now()))
        self.meet()

    def send(self, frames: Any) -> None:
        self.link.send(frames, self.node)
        self.link.refresh(self.node)

    def change(self, index: int, value: ObjectValue) -> None:
        """Set an object as the application."""
        with self.link.lock:
            self.node.set(index, 0, value)
            self.send(self.node.flush(self.link.now()))

    def until(self, condition: Any) -> None:
        assert self.link.wait(condition, TIMEOUT * 10**9)

    def go(self, state: str) -> None:
        self.remote.nmt.state = state
        wanted = NmtState[state.replace("-", "_")]
        self.until(lambda: self.node.state is wanted)

    def close(self) -> None:
        self.network.disconnect()
        self.link.detach(self.node)


@pytest.fixture(scope="module")
def shared() -> Iterator[Rig]:
    rig = Rig(DeviceNode(DEVICE, NODE_ID, serial_number=2))
    yield rig
    rig.close()


@pytest.fixture
def rig(shared: Rig) -> Rig:
    shared.reset()
    return shared


@pytest.mark.parametrize(("kind", "value", "octets"), BOUNDARIES)
def test_values_of_every_kind_by_sdo(
    rig: Rig, kind: Kind, value: ObjectValue, octets: str
) -> None:
    wire = bytes.fromhex(octets)
    rig.remote.sdo.download(number_of(kind), 0, wire)
    assert rig.node.get(number_of(kind)) == value
    rig.change(number_of(kind), values.zero(kind))
    rig.change(number_of(kind), value)
    assert rig.remote.sdo.upload(number_of(kind), 0) == wire
    if CODES[kind] != DOMAIN and kind not in ("string", "char"):
        assert rig.remote.sdo[number_of(kind)].raw == value


@pytest.mark.sampled(5)
@pytest.mark.parametrize("size", [1, 4, 5, 7, 8, 100, 889, 890, 3000])
@pytest.mark.parametrize("block", [False, True])
def test_long_values(rig: Rig, size: int, block: bool) -> None:
    value = bytes(n % 253 for n in range(size))
    remote = rig.remote.sdo[number_of("octets")]
    with remote.open("wb", block_transfer=block, size=size) as stream:
        stream.write(value)
    rig.until(lambda: rig.node.get(number_of("octets")) == value)
    with remote.open("rb", block_transfer=block) as stream:
        assert stream.read() == value
    # The last message of a block has no answer: the next one shows that it was right.
    assert rig.remote.sdo[0x1001].raw == 0


@pytest.mark.parametrize(
    ("index", "subindex", "octets", "code"),
    [
        (0x3000, 0, b"\1", sdo.NO_OBJECT),
        (0x1018, 9, b"\1", sdo.NO_SUBINDEX),
        (0x2100, 0, b"\1\0", sdo.READ_ONLY),
        (0x2103, 0, b"\1", sdo.LENGTH_TOO_LOW),
        (0x2103, 0, b"\1\0\0", sdo.LENGTH_TOO_HIGH),
        (0x2103, 0, b"\x65\0", sdo.VALUE_TOO_HIGH),
        (0x2103, 0, b"\0\x80", sdo.VALUE_TOO_LOW),
        (0x1010, 1, bytes(4), 0x08000020),
        (0x1016, 1, bytes(5), sdo.LENGTH_TOO_HIGH),
    ],
)
def test_refusals(
    rig: Rig, index: int, subindex: int, octets: bytes, code: int
) -> None:
    with pytest.raises(canopen.SdoAbortedError) as caught:
        rig.remote.sdo.download(index, subindex, octets)
    assert caught.value.code == code


def test_a_write_only_object_is_not_read(rig: Rig) -> None:
    with pytest.raises(canopen.SdoAbortedError) as caught:
        rig.remote.sdo.upload(0x2101, 0)
    assert caught.value.code == sdo.WRITE_ONLY


def test_nmt_heartbeat_and_boot_up(rig: Rig) -> None:
    rig.remote.sdo[0x1017].raw = 20
    assert rig.remote.nmt.wait_for_heartbeat(TIMEOUT) == "PRE-OPERATIONAL"
    for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
        rig.go(state)
        while rig.remote.nmt.wait_for_heartbeat(TIMEOUT) != state:
            assert rig.node.state is NmtState[state.replace("-", "_")]
    booted: Queue[int] = Queue()
    rig.network.subscribe(
        0x700 + NODE_ID, lambda can_id, data, time: booted.put(data[0])
    )
    for command in ("RESET", "RESET COMMUNICATION"):
        rig.remote.nmt.state = command
        while booted.get(timeout=TIMEOUT) != 0:
            continue
    assert rig.remote.sdo[0x1017].raw == 0


def test_pdos_both_ways(rig: Rig) -> None:
    rig.remote.tpdo.read()
    rig.remote.rpdo.read()
    rig.remote.tpdo[1].subscribe()
    got: Queue[tuple[int, int]] = Queue()
    rig.remote.tpdo[1].add_callback(lambda pdo: got.put((pdo[0].raw, pdo[1].raw)))
    rig.go("OPERATIONAL")
    assert got.get(timeout=TIMEOUT) == (0x40, 0)
    rig.change(0x6064, -123456)
    assert got.get(timeout=TIMEOUT) == (0x40, -123456)
    out = rig.remote.rpdo[1]
    out[0].raw, out[1].raw = 0x000F, -(2**31)
    out.transmit()
    rig.until(lambda: rig.node.get(0x607A) == -(2**31))
    assert rig.node.get(0x6040) == 15


def test_mapping_by_the_package(rig: Rig) -> None:
    out, back = rig.remote.rpdo[2], rig.remote.tpdo[2]
    for pdo in (out, back):
        pdo.read()
        pdo.clear()
        for kind in ("i24", "r32", "u8"):
            pdo.add_variable(number_of(kind))
        pdo.cob_id = 0x3A0 if pdo is out else 0x3A1
        pdo.trans_type = 255
        pdo.enabled = True
        pdo.save()
    back.subscribe()
    got: Queue[bytes] = Queue()
    back.add_callback(lambda pdo: got.put(bytes(pdo.data)))
    rig.go("OPERATIONAL")
    assert got.get(timeout=TIMEOUT) == bytes(8)
    out[0].raw, out[1].raw, out[2].raw = -5, 0.25, 200
    out.transmit()
    assert got.get(timeout=TIMEOUT) == bytes(out.data)
    assert rig.node.get(number_of("i24")) == -5
    assert rig.node.get(number_of("r32")) == 0.25


def test_a_mapping_that_cannot_be_is_refused(rig: Rig) -> None:
    pdo = rig.remote.tpdo[2]
    pdo.read()
    pdo.clear()
    pdo.add_variable(0x2106)
    with pytest.raises(canopen.SdoAbortedError) as caught:
        pdo.save()
    assert caught.value.code == 0x06040041


def test_sync(rig: Rig) -> None:
    rig.remote.tpdo.read()
    rig.remote.tpdo[1].trans_type = 2
    rig.remote.tpdo[1].save()
    got: Queue[bytes] = Queue()
    rig.remote.tpdo[1].add_callback(lambda pdo: got.put(bytes(pdo.data)))
    rig.go("OPERATIONAL")
    for _ in range(4):
        rig.network.sync.transmit()
    for _ in range(2):
        assert got.get(timeout=TIMEOUT) == bytes.fromhex("400000000000")


def test_emergencies(rig: Rig) -> None:
    got: Queue[Any] = Queue()
    rig.remote.emcy.add_callback(got.put)
    with rig.link.lock:
        rig.node.add_error(0x2310, b"\1\2\3")
        rig.send(rig.node.flush(rig.link.now()))
    error = got.get(timeout=TIMEOUT)
    assert (error.code, error.register, error.data) == (0x2310, 3, b"\1\2\3\0\0")
    assert rig.remote.sdo[0x1003][1].raw == 0x02012310
    with rig.link.lock:
        rig.node.remove_error(0x2310)
        rig.send(rig.node.flush(rig.link.now()))
    assert got.get(timeout=TIMEOUT).code == 0


def test_store_and_restore(rig: Rig) -> None:
    remote = rig.remote.sdo
    remote[0x2103].raw = 42
    remote.download(0x1010, 1, b"save")
    remote[0x2103].raw = 43
    rig.remote.nmt.state = "RESET"
    rig.until(lambda: rig.node.get(0x2103) == 42)
    remote.download(0x1011, 1, b"load")
    assert remote[0x2103].raw == 42
    rig.remote.nmt.state = "RESET"
    rig.until(lambda: rig.node.get(0x2103) == 0)


def test_lss_selects_configures_and_stores() -> None:
    rig = Rig(DeviceNode(DEVICE, serial_number=2))
    lss = rig.network.lss
    address = (DEVICE.vendor_id, DEVICE.product_code, DEVICE.revision_number, 2)
    assert lss.send_switch_state_selective(*address)
    assert lss.inquire_node_id() == 255
    for command, number in zip((0x5A, 0x5B, 0x5C, 0x5D), address, strict=True):
        assert lss.inquire_lss_address(command) == number
    with pytest.raises(canopen.lss.LssError):
        lss.configure_node_id(200)
    lss.configure_node_id(NODE_ID)
    lss.configure_bit_timing(2)
    with pytest.raises(canopen.lss.LssError):
        lss.configure_bit_timing(5)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    rig.until(lambda: rig.node.state is NmtState.PRE_OPERATIONAL)
    assert rig.remote.sdo[0x1018][4].raw == 2
    rig.close()


def test_lss_fastscan() -> None:
    device = DeviceNode(
        DeviceDescription("Bare", DEVICE.objects, DEVICE.pdos, 0x10, lss=True),
        serial_number=4,
    )
    rig = Rig(device)
    # Every bit that is 1 has no answering node.
    rig.network.lss.RESPONSE_TIMEOUT = 1
    found, address = rig.network.lss.fast_scan()
    assert found
    assert address == [0x10, 0, 0, 4]
    rig.network.lss.configure_node_id(NODE_ID)
    rig.network.lss.send_switch_state_global(0)
    rig.until(lambda: rig.node.node_id == NODE_ID)
    rig.close()


def test_two_nodes_with_one_id(rig: Rig) -> None:
    other = canopen.LocalNode(NODE_ID, dictionary())
    got: Queue[Any] = Queue()
    rig.remote.emcy.add_callback(got.put)
    network = canopen.Network()
    network.connect(
        interface="virtual", channel=rig.network.bus.channel_info.split()[-1]
    )
    network.add_node(other)
    other.nmt.send_command(0)
    assert got.get(timeout=TIMEOUT).code == 0x8150
    network.disconnect()
