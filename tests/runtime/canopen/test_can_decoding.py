"""Decoded frames: every service, PDOs by the present mapping, SDO as a third station sees it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sdo_line import LOST, ONCE, Values, line

from rtgen.compiler.diagnostics import InputError
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, command_frame
from rtgen.tools.can.decoding.decoder import Decoded, Decoder
from rtgen.tools.can.decoding.node_index import NodeIndex, number_of, read_node_index
from rtgen.tools.can.decoding.sdo_decoding import MAX_VALUE, SdoFollower
from rtgen.tools.kit.exits import Refusal

SPECS = Path(__file__).parents[3] / "specs" / "canopen"
LINKED = read_node_index(SPECS / "pdo_linking.toml", [])

EDS = """[FileInfo]
FileName=odd.eds
[DeviceInfo]
Granularity=1
[MandatoryObjects]
SupportedObjects=1
1=0x1000
[1000]
ParameterName=Device type
ObjectType=7
DataType=7
AccessType=ro
DefaultValue=0
"""


def entry(section: str, name: str, code: int, default: str = "", more: str = "") -> str:
    return (
        f"[{section}]\nParameterName={name}\nObjectType=7\nDataType={code}\n"
        f"AccessType=rw\nPDOMapping=1\nDefaultValue={default}\n{more}\n"
    )


@pytest.fixture
def linked() -> NodeIndex:
    return LINKED


@pytest.fixture(scope="module")
def fourx() -> NodeIndex:
    return read_node_index(SPECS / "fourx.toml", [])


def decoded(known: NodeIndex, can_id: int, data: str = "") -> Decoded:
    return Decoder(known).decode(Frame(can_id, bytes.fromhex(data)))


@pytest.mark.parametrize(
    ("can_id", "data", "text"),
    [
        (0x000, "0101", "motor nmt start"),
        (0x000, "8200", "all nodes nmt reset communication"),
        (0x000, "7f02", "palette nmt unknown command 7Fh"),
        (0x000, "01", "nmt no command: 01"),
        (0x001, "02", "failsafe 02"),
        (0x080, "", "sync"),
        (0x080, "07", "sync 7"),
        (0x080, "0708", "sync of a wrong length: 07 08"),
        (0x100, "000000000000", "time 1984-01-01T00:00:00.000Z"),
        (0x100, "00", "time no time: 00"),
        (
            0x081,
            "1082110102030405",
            "motor emcy 8210h PDO too short (generic, communication) 01 02 03 04 05",
        ),
        (0x082, "0000000000000000", "palette emcy 0000h no error"),
        (0x083, "0023", "node 3 emcy no emergency: 00 23"),
        (0x701, "00", "motor heartbeat boot-up"),
        (0x702, "05", "palette heartbeat operational"),
        (0x77F, "7f", "manager heartbeat pre-operational"),
        (0x701, "ff", "motor guarding pre-operational (toggle bit set)"),
        (0x701, "33", "motor heartbeat unknown state 33h"),
        (0x701, "", "motor heartbeat no state: no data"),
        (0x203, "0102", "node 3 rpdo1 01 02"),
        (0x301, "0102", "frame 01 02"),
        (0x700, "00", "frame 00"),
        (0x581, "60", "motor sdo no message: 60"),
        (0x7E5, "0401000000000000", "lss all to configuration state"),
        (0x7E5, "4301000000000000", "lss select serial number 0x1"),
        (0x7E5, "1300020000000000", "lss set bit rate 500 kbit/s"),
        (0x7E5, "1300050000000000", "lss set bit rate entry 5 of table 0"),
        (0x7E5, "5100000000800000", "lss fastscan: who has no node-id"),
        (0x7E5, "5134120000070102", "lss fastscan: product 0x1234 down to bit 7"),
        (0x7E4, "4f00000000000000", "lss here"),
        (0x7E4, "1101000000000000", "lss node-id refused: error 1, 0"),
        (0x7E4, "5eff000000000000", "lss node-id is not set"),
        (0x7E4, "9900000000000000", "lss unknown command 99h: 00 00 00 00 00 00 00"),
        (0x7E4, "99", "lss no message: 99"),
    ],
)
def test_services(linked: NodeIndex, can_id: int, data: str, text: str) -> None:
    assert str(decoded(linked, can_id, data)) == text


def test_codes_and_nodes_for_machines(linked: NodeIndex) -> None:
    emergency = decoded(linked, 0x081, "1082110000000000").to_json()
    assert (emergency["kind"], emergency["node"], emergency["code"]) == (
        "emcy",
        1,
        0x8210,
    )
    command = Decoder(linked).decode(command_frame(NmtCommand.STOP)).to_json()
    assert (command["node"], command["text"]) == (0, "stop")
    time = Frame(0x100, bytes.fromhex("7bb4c404e238"))
    message = Decoder(linked).decode(time)
    assert message.text == "2023-11-14T22:13:20.123Z"


def test_remote_frames(linked: NodeIndex) -> None:
    decoder = Decoder(linked)
    assert str(decoder.decode(Frame(0x181, remote=True))) == "motor tpdo1 request"
    assert str(decoder.decode(Frame(0x701, remote=True))) == "motor guarding request"
    assert str(decoder.decode(Frame(0x12345, extended=True))) == "frame no data"


def test_a_link_tells_both_ends(linked: NodeIndex) -> None:
    message = decoded(linked, 0x482, "18fcffff")
    assert str(message) == "palette tpdo4 -> motor.rpdo2 Angle_reference=-1000"
    assert message.to_json()["values"] == [
        {"object": "2100:0", "name": "Angle_reference", "value": -1000}
    ]


def test_factors_and_units_of_the_bus_file(fourx: NodeIndex) -> None:
    message = decoded(fourx, 0x283, "e803000018fcffff")
    assert message.name == "rear_left"
    assert (
        message.text
        == "Position_actual_value=1.0 deg, Velocity_actual_value=-1.0 deg/s"
    )
    values = message.to_json()["values"]
    assert isinstance(values, list)
    assert values[0] == {
        "object": "6064:0",
        "name": "Position_actual_value",
        "value": 1.0,
        "raw": 1000,
        "unit": "deg",
    }


def test_scaled_values_are_rounded_to_what_the_bus_can_tell() -> None:
    """A step of the bus is 7.48e-6 rad/s; more digits than two below it say nothing."""
    beego = read_node_index(SPECS / "rh3_beego.toml", [])
    message = decoded(beego, 0x402, "74590100")
    assert message.text == "Target_velocity=0.66149973 rad/s"
    [value] = message.to_json()["values"]
    assert value["value"] == pytest.approx(0.66149973, abs=1e-8)
    assert value["raw"] == 0x15974


def test_lengths(linked: NodeIndex) -> None:
    short = decoded(linked, 0x201, "0f00")
    assert short.text.endswith("15 (enable operation) (too short: 2 of 3 octets)")
    assert [field.value for field in short.fields] == [15]
    long = decoded(linked, 0x201, "0f000308")
    assert long.text.endswith(
        "Modes_of_operation=3 (profile velocity) (too long: 4 octets for 3)"
    )


def write(decoder: Decoder, index: int, subindex: int, value: int, size: int) -> None:
    """Decode a write that node 1 confirms."""
    head = bytes((index & 0xFF, index >> 8, subindex))
    command = bytes((0x23 | (4 - size) << 2,))
    decoder.decode(Frame(0x601, command + head + value.to_bytes(4, "little")))
    decoder.decode(Frame(0x581, b"\x60" + head + bytes(4)))


def test_a_mapping_that_changes_is_followed(linked: NodeIndex) -> None:
    decoder = Decoder(linked)
    before = decoder.decode(Frame(0x181, b"\1\2\3")).text
    write(decoder, 0x1800, 1, 0x80000181, 4)
    assert str(decoder.decode(Frame(0x181, b"\1\2"))) == "frame 01 02"
    write(decoder, 0x1A00, 0, 0, 1)
    write(decoder, 0x1A00, 1, 0x00050008, 4)
    write(decoder, 0x1A00, 2, 0x60640020, 4)
    write(decoder, 0x1A00, 0, 2, 1)
    write(decoder, 0x1800, 1, 0x40000333, 4)
    message = decoder.decode(Frame(0x333, b"\x55\xfe\xff\xff\xff"))
    assert str(message) == "motor tpdo1 Position_actual_value=-2"
    write(decoder, 0x1014, 0, 0x0F5, 4)
    assert decoder.decode(Frame(0x0F5, bytes(8))).name == "motor"
    decoder.decode(Frame(0x701, b"\0"))
    assert decoder.decode(Frame(0x181, b"\1\2\3")).text == before
    assert decoder.decode(Frame(0x333, b"\1\2")).name == "node 51"


def test_a_refused_write_changes_nothing(linked: NodeIndex) -> None:
    decoder = Decoder(linked)
    decoder.decode(Frame(0x601, bytes.fromhex("2300180181010080")))
    message = decoder.decode(Frame(0x581, bytes.fromhex("8000180122000008")))
    assert message.text == (
        "abort 1800:1 COB_ID_1800_01 08000022h data cannot be transferred or stored "
        "in the present device state (by the server)"
    )
    assert message.code == 0x08000022
    assert decoder.decode(Frame(0x181, b"\1\2\3")).kind == "tpdo1"


def test_fields_of_any_width(tmp_path: Path) -> None:
    mapped = [
        (0x2000, 0x01, 1, "Flag"),
        (0x2001, 0x03, 5, "Small"),
        (0x2002, 0x10, 24, "Wide"),
        (0x2003, 0x09, 16, "Word"),
        (0x2004, 0x08, 18, "Real"),
    ]
    text = EDS + entry("1800", "TPDO 1", 0).replace("ObjectType=7", "ObjectType=9")
    text += entry("1800sub0", "n", 5, "2") + entry(
        "1800sub1", "COB", 7, "$NODEID+0x180"
    )
    text += "[1A00]\nParameterName=Map\nObjectType=9\n"
    text += entry("1A00sub0", "n", 5, str(len(mapped)))
    for place, (index, code, bits, name) in enumerate(mapped, 1):
        text += entry(f"1A00sub{place}", "m", 7, f"0x{index:04X}00{bits:02X}")
        text += entry(f"{index:04X}", name, code)
    path = tmp_path / "odd.eds"
    path.write_text(text)
    decoder = Decoder(read_node_index(None, [(9, path)]))
    bits = 1 | 0b10000 << 1 | 0xFFFFFE << 6 | int.from_bytes(b"ok", "little") << 30
    message = decoder.decode(Frame(0x189, bits.to_bytes(8, "little")))
    assert message.name == "odd"
    values = {field.name: field.value for field in message.fields}
    assert values == {
        "Flag": True,
        "Small": -16,
        "Wide": -2,
        "Word": "ok",
        "Real": 0.0,
    }


@pytest.mark.parametrize(
    ("statusword", "text"),
    [
        (0x0000, "not ready to switch on"),
        (0x0250, "switch on disabled"),
        (0x0231, "ready to switch on"),
        (0x0233, "switched on"),
        (0x0637, "operation enabled, target reached"),
        (0x02B7, "operation enabled, warning"),
        (0x0217, "quick stop active"),
        (0x021F, "fault reaction active"),
        (0x0218, "fault"),
        (0x0001, ""),
    ],
)
def test_the_state_of_a_drive(fourx: NodeIndex, statusword: int, text: str) -> None:
    data = statusword.to_bytes(2, "little") + b"\3"
    field, _ = Decoder(fourx).decode(Frame(0x181, data)).fields
    assert field.words == text
    assert field.to_json().get("words", "") == text


def test_the_command_to_a_drive(fourx: NodeIndex) -> None:
    text = {
        0x80: "fault reset",
        0x00: "disable voltage",
        0x02: "quick stop",
        0x06: "shutdown",
        0x07: "switch on",
        0x0F: "enable operation",
        0x1F: "enable operation",
        0x10F: "enable operation, halt",
    }
    for controlword, words in text.items():
        data = controlword.to_bytes(2, "little") + b"\3"
        assert Decoder(fourx).decode(Frame(0x201, data)).fields[0].words == words


# SDO as a third station sees it

SIZES = [0, 1, 4, 5, 7, 8, 14, 127 * 7, 127 * 7 + 1, 3000]


def value_of(size: int) -> bytes:
    return bytes(i * 31 % 251 for i in range(size))


def follow(frames: list[Frame]) -> list[tuple[bytes | None, bytes | None]]:
    """Return the content of each message, and the value of the variable that it completes."""
    follower = SdoFollower()
    found = []
    for frame in frames:
        take = follower.request if frame.can_id == 0x605 else follower.response
        step = take(frame.data)
        assert step.number == (0x2000, 0)
        found.append((step.value, step.holds))
    return found


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize("size", SIZES)
def test_a_write_is_put_together(size: int, block: bool) -> None:
    wire, value = line(Values()), value_of(size)
    wire.run(wire.client.download(0x2000, 0, value, 0, block=block))
    found = follow(wire.frames)
    assert [v for v, _ in found if v is not None] == [value]
    assert [h for _, h in found if h is not None] == [value]
    assert found[-1][1] == value


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize("size", SIZES)
def test_a_read_is_put_together(size: int, block: bool) -> None:
    value = value_of(size)
    wire = line(Values(value), block_size=20)
    assert wire.run(wire.client.upload(0x2000, 0, 0, block=block)) == value
    found = follow(wire.frames)
    assert [v for v, _ in found if v is not None] == [value]
    assert [h for _, h in found if h is not None] == [value]


@settings(max_examples=30, deadline=None)
@given(st.integers(300, 1500), st.sets(st.integers(3, 40), max_size=8), st.booleans())
def test_lost_segments_of_blocks_come_again(
    size: int, lost: set[int], reading: bool
) -> None:
    value = value_of(size)
    fates = [LOST if place in lost else ONCE for place in range(41)]
    wire = line(Values(value), fates, block_size=50)
    if reading:
        frames = wire.client.upload(0x2000, 0, 0, block=True)
    else:
        frames = wire.client.download(0x2000, 0, value, 0, block=True)
    assert wire.run(frames) in (value, b"")
    assert [v for v, _ in follow(wire.frames) if v is not None] == [value]


def test_a_transfer_that_began_before(linked: NodeIndex) -> None:
    message = decoded(linked, 0x581, "0041414141414141")
    assert str(message) == "motor sdo answer of a transfer that began before"
    message = decoded(linked, 0x601, "6000000000000000")
    assert str(message) == "motor sdo request of a transfer that began before"
    assert str(decoded(linked, 0x581, "6040600000000000")) == (
        "motor sdo write done 6040:0 Controlword"
    )


def test_a_long_value_is_only_counted() -> None:
    follower = SdoFollower()
    follower.request(bytes.fromhex("2000200000000000"))
    follower.response(bytes.fromhex("6000200000000000"))
    segments = MAX_VALUE // 7 + 1
    for place in range(segments):
        last = place == segments - 1
        step = follower.request(bytes((last,)) + bytes(7))
    assert (step.value, step.detail) == (None, f"{segments * 7} octets")


def test_segments_in_words(linked: NodeIndex) -> None:
    decoder = Decoder(linked)
    messages = [
        (0x601, "4008100000000000"),
        (0x581, "4108100009000000"),
        (0x601, "6000000000000000"),
        (0x581, "004d6f746f722075"),
        (0x601, "7000000000000000"),
        (0x581, "1b6e690000000000"),
    ]
    texts = [decoder.decode(Frame(i, bytes.fromhex(d))).text for i, d in messages]
    name = "1008:0 Manufacturer_device_name"
    assert texts == [
        f"read request {name}",
        f"read answer {name} 9 octets follow",
        f"segment request {name}",
        f"read segment {name} 7 of 9 octets",
        f"segment request {name}",
        f'last read segment {name} = "Motor uni" (9 octets)',
    ]


# Nodes and objects by name


def test_nodes_and_objects_by_name(linked: NodeIndex) -> None:
    assert linked.node("palette") == 2
    assert linked.node("0x7F") == 127
    motor = linked.nodes[1]
    assert motor.object("Controlword").number == (0x6040, 0)
    assert motor.object("CONTROLWORD").number == (0x6040, 0)
    assert motor.object("1018:1").name == "Vendor_ID"
    assert [n.id for n, _ in linked.find("Vendor_ID")] == [1, 2]
    assert [n.id for n, _ in linked.find("palette.6401:1")] == [2]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("moter.6040", "did you mean motor?"),
        ("motor.Contrlword", "did you mean Controlword?"),
        ("motor.1018:9", "no object '1018:9'"),
        ("200.6040", "node-id 200"),
        ("9.6040", "nothing is known"),
        ("Nonsense", "no object 'Nonsense'"),
    ],
)
def test_unknown_names_have_hints(linked: NodeIndex, text: str, hint: str) -> None:
    with pytest.raises(Refusal) as caught:
        linked.find(text)
    assert hint in str(caught.value)


def test_descriptions_of_single_nodes(tmp_path: Path) -> None:
    drive = SPECS / "epos_drive.eds"
    known = read_node_index(
        None, [(1, drive), (2, drive), (3, SPECS / "f_palette.eds")]
    )
    assert [n.name for n in known.nodes.values()] == [
        "epos_drive_1",
        "epos_drive_2",
        "f_palette",
    ]
    with pytest.raises(Refusal, match="whose is it"):
        read_node_index(None, [(None, drive)])
    with pytest.raises(InputError):
        read_node_index(None, [(1, tmp_path / "missing.eds")])
    with pytest.raises(InputError):
        read_node_index(tmp_path / "missing.toml", [])


def test_numbers() -> None:
    assert number_of("0x6401:0A") == (0x6401, 10)
    assert number_of("6040") == (0x6040, 0)
    assert number_of("12345") is None
    assert number_of("6401:100") is None


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=30))
def test_any_frames_have_words(frames: list[tuple[int, bytes]]) -> None:
    decoder = Decoder(LINKED)
    for can_id, data in frames:
        message = decoder.decode(Frame(can_id, data))
        assert message.kind
        assert message.to_json()["kind"] == message.kind
