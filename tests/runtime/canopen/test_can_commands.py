"""`rtgen can send`, `sdo`, `scan`, `plot` and `timing`, with complete slaves on a virtual bus."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import can
import pytest
from can_commands import bus, command, listeners, meanwhile, messages, received, texts
from can_nodes import SPECS, nodes
from device_bench import DEVICE, NODE_ID, number_of
from json_schemas import valid
from patience import until

from rtgen.cli import run
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.python_can import BusAddress
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.lss import LssAddress
from rtgen.runtime.canopen.wire.lss_master import Procedure
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.runtime.timing.clocks import RealClock
from rtgen.tools.can.decoding.node_index import read_node_index
from rtgen.tools.can.live import live_bus, lss_scan
from rtgen.tools.can.parsing.frames import frame_of_text
from rtgen.tools.kit.exits import Refusal

pytestmark = pytest.mark.waits

LINKED = str(SPECS / "pdo_linking.toml")
FOURX = str(SPECS / "fourx.toml")
FOUR = read_node_index(SPECS / "fourx.toml", [])
PAIR = {1: "motor_core_unit", 2: "f_palette"}
DRIVE = ["--eds", f"1={SPECS / 'epos_drive.eds'}"]


def out(capfd: pytest.CaptureFixture[str]) -> str:
    return capfd.readouterr().out.rstrip("\n")


def shown(text: str) -> str:
    """Return the text of a message box or of findings, in one line."""
    return " ".join(text.split())


@pytest.mark.parametrize(
    "arguments",
    [
        ["monitor"],
        ["record", "frames.log"],
        ["plot", "palette.Angle_reference", "-o", "a.csv"],
        ["send", "sync"],
        ["scan"],
        ["sdo", "read", "palette", "1018:1"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_bus_is_opened_with_the_bit_rate_of_its_file(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rates = []

    def refuse(address: BusAddress) -> NoReturn:
        rates.append(address.bitrate)
        raise LinkError("no such bus")

    bus_file = ["--interface", "virtual", "--bus", LINKED]
    monkeypatch.setattr(live_bus, "open_bus", refuse)
    monkeypatch.chdir(tmp_path)
    for more in ([], ["--bitrate", "125000"]):
        assert run(["can", *arguments, *bus_file, *more]) == 3
    assert rates == [500_000, 125_000]


# send


@pytest.mark.parametrize(
    ("frame", "sent"),
    [
        ("181#0102", "181#0102"),
        ("7FF#11.22.33", "7FF#112233"),
        ("080#", "080#"),
        ("701#R", "701#R"),
        ("01ABCDEF#ff", "01ABCDEF#ff"),
        ("sync", "080#"),
        ("sync 7", "080#07"),
        ("nmt start all", "000#0100"),
        ("nmt reset-node front_right", "000#8102"),
        ("NMT pre-operational 0x10", "000#8010"),
        ("front_left.rpdo1 Controlword=0x0F", "201#0f0000"),
        ("front_left.rpdo1 modes_of_operation=-3 Controlword=6", "201#0600fd"),
        ("rear_right.rpdo3 Target_velocity=-1.5", "404#24faffff"),
    ],
)
def test_frames_as_people_write_them(frame: str, sent: str) -> None:
    made = frame_of_text(frame, FOUR)
    digits = 8 if made.extended else 3
    data = "R" if made.remote else made.data.hex()
    assert f"{made.can_id:0{digits}X}#{data}" == sent


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        ("181", "is not a frame: write ID#HEX"),
        ("181#0", "hexadecimal digits"),
        ("FFF#00", "hexadecimal digits"),
        ("181#112233445566778899", "hexadecimal digits"),
        ("sync x", "not a counter"),
        ("sync 300", "not a counter"),
        ("nmt go all", "not an NMT command"),
        ("nmt start frnt_left", "did you mean front_left?"),
        ("front_left.rpdo9", "no valid rpdo9; there are"),
        ("front_left.rpdo1 Contrlword=1", "did you mean Controlword?"),
        ("front_left.rpdo1 Zzz=1", "it has Controlword"),
        ("front_left.rpdo1 Controlword", "not OBJECT=VALUE"),
        ("front_left.rpdo1 Controlword=x", "is not an integer (u16)"),
        ("front_left.rpdo1 Controlword=70000", "over 65535"),
        (
            "front_left.rpdo1 Controlword=1 controlword=2",
            "front_left.rpdo1: Controlword is given twice",
        ),
        ("9.rpdo1 Controlword=1", "9 is not described"),
    ],
)
def test_frames_that_are_none(frame: str, message: str) -> None:
    with pytest.raises(Refusal) as caught:
        frame_of_text(frame, FOUR)
    assert message in str(caught.value)


def test_a_frame_by_name(capfd: pytest.CaptureFixture[str]) -> None:
    with bus("names") as peer:
        send = ["send", "--bus", FOURX]
        assert command("names", *send, "rear_right.rpdo3 Target_velocity=-1.5") == 0
        assert texts(received(peer, 1)) == ["404#24faffff"]
        assert command("names", *send, "rear_rght.rpdo3 Target_velocity=-1.5") == 2
    assert "did you mean rear_right?" in shown(capfd.readouterr().err)


def test_again_and_again() -> None:
    with bus("cyclic") as peer:
        again = ["--every", "0.01", "--count", "3"]
        assert command("cyclic", "send", "080#", "181#01", *again) == 0
        assert texts(received(peer, 6)) == ["080#", "181#01"] * 3
        assert peer.recv(0) is None


def test_a_sequence(tmp_path: Path) -> None:
    path = tmp_path / "sequence.txt"
    path.write_text(
        "# switch the drive on\n"
        "nmt start front_left\n"
        "0.01 front_left.rpdo1 Controlword=6\n"
        "+0.01  201#0700.00\n"
        "\n"
        "  +0  sync\n"
    )
    with bus("sequence") as peer:
        whole = ["--file", str(path), "--bus", FOURX, "--count", "2"]
        assert command("sequence", "send", *whole) == 0
        once = ["000#0101", "201#060000", "201#070000", "080#"]
        assert texts(received(peer, 8)) == once * 2


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("080#\n1.0 081#\n0.5 082#\n", 2, "s.txt:3: 0.5 s is before the line above"),
        ("080#\nnonsense\n", 2, "s.txt:2: 'nonsense' is not a frame"),
        ("# nothing\n", 2, "there is no frame"),
    ],
)
def test_sequences_that_are_none(
    text: str,
    code: int,
    message: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / "s.txt"
    path.write_text(text)
    assert command("none", "send", "--file", str(path)) == code
    assert message in shown(capfd.readouterr().err)
    assert command("none", "send", "--file", str(tmp_path / "x")) == 3
    assert command("none", "send") == 2
    assert command("none", "send", "080#", "--file", str(path)) == 2


# sdo


def test_sdo_by_name_and_number(capfd: pytest.CaptureFixture[str]) -> None:
    near = ["--no-look", "--bus", LINKED]
    with nodes("sdo", PAIR):
        for name in ("Vendor_ID", "1018:1", "0x1018:01"):
            assert command("sdo", "sdo", "read", "motor", name, *near) == 0
            assert out(capfd) == "0xFFFF01"
        name = "Manufacturer_device_name"
        assert command("sdo", "sdo", "read", "palette", name, *near) == 0
        assert out(capfd) == "f-palette"
        time = "Producer_heartbeat_time"
        assert command("sdo", "sdo", "write", "1", time, "0", *near) == 0
        assert command("sdo", "sdo", "read", "1", time, "--json", *near) == 0
        assert valid(out(capfd), "can.schema.json", "sdo") == {
            "node": 1,
            "node_name": "motor",
            "object": "1017:0",
            "name": time,
            "value": 0,
        }


def test_sdo_has_factor_and_unit(capfd: pytest.CaptureFixture[str]) -> None:
    near = ["--no-look", "--bus", FOURX]
    with nodes("factor", {1: "ftmd"}) as made:
        assert command("factor", "sdo", "write", "1", "60FF", "-1.5", *near) == 0
        assert made[1].get(0x60FF) == -1500
        assert command("factor", "sdo", "read", "1", "60FF", *near) == 0
        assert out(capfd) == "-1.5 deg/s"
        assert command("factor", "sdo", "read", "1", "60FF", "--raw", *near) == 0
        assert out(capfd) == "-1500"
        raw = ["sdo", "write", "1", "60FF", "20", "--raw"]
        assert command("factor", *raw, *near) == 0
        assert made[1].get(0x60FF) == 20


def test_sdo_of_a_node_that_nobody_described(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with nodes("stranger", {9: "f_palette"}):
        base = ["stranger", "sdo", "read", "9"]
        assert command(*base, "1018:1", "--no-look") == 0
        assert out(capfd) == "01 ff ff 00"
        assert command(*base, "1018:1", "--no-look", "--type", "u32") == 0
        assert out(capfd) == "0xFFFF01"
        write = ["stranger", "sdo", "write", "9", "1017", "--no-look"]
        assert command(*write, "5") == 2
        assert "or set its --type" in shown(capfd.readouterr().err)
        assert command(*write, "0500", "--type", "u16") == 0
        assert command(*base, "Vendor_ID", "--no-look") == 2
        assert "give --bus or --eds" in shown(capfd.readouterr().err)


@contextmanager
def answering(channel: str, data: bytes) -> Iterator[None]:
    """Run a node 9 that gives one answer to each SDO request."""
    with can.Bus(interface="virtual", channel=channel) as bus:

        def answer(message: can.Message) -> None:
            if message.arbitration_id == 0x609:
                whole = data[:1] + message.data[1:4] + data[1:]
                bus.send(
                    can.Message(arbitration_id=0x589, data=whole, is_extended_id=False)
                )

        notifier = can.Notifier(bus, [answer])
        try:
            yield
        finally:
            notifier.stop()


def test_an_sdo_answer_that_is_not_valid(capfd: pytest.CaptureFixture[str]) -> None:
    """The node answers a read as if it were a write."""
    with answering("odd", bytes.fromhex("60 00 00 00 00")):
        read = ["odd", "sdo", "read", "9", "1000", "--type", "u32", "--no-look"]
        assert command(*read) == 1
    said = shown(capfd.readouterr().err)
    assert "the answer is not valid: 05040001h command specifier unknown" in said


@pytest.mark.parametrize(
    ("kind", "wanted"),
    [
        *[("u8", 1), ("i8", 1), ("bool", 1), ("u24", 3), ("u32", 4), ("i32", 4)],
        *[("r32", 4), ("u64", 8), ("r64", 8), ("time_of_day", 6)],
    ],
)
def test_an_sdo_answer_of_another_length(
    kind: str, wanted: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """The node answers with two octets, which are no value of the type."""
    with answering(f"short {kind}", bytes.fromhex("4b 12 34 00 00")):
        read = [f"short {kind}", "sdo", "read", "9", "2000", "--no-look", "--type"]
        assert command(*read, kind) == 1
        printed = capfd.readouterr()
        assert printed.out == ""
        problem = f"the answer is not valid: {kind} has {wanted} octets, not 2"
        assert problem in shown(printed.err)
        assert command(*read, "octets") == 0
        assert out(capfd) == "12 34"


def test_an_sdo_answer_with_half_a_character(capfd: pytest.CaptureFixture[str]) -> None:
    with answering("half", bytes.fromhex("47 12 34 56 00")):
        read = ["half", "sdo", "read", "9", "2000", "--no-look", "--type", "wstring"]
        assert command(*read) == 1
    said = shown(capfd.readouterr().err)
    assert "wstring has octets in pairs, not 3" in said


def test_an_sdo_answer_without_its_length(capfd: pytest.CaptureFixture[str]) -> None:
    """An expedited answer may leave out its length; it then has four octets."""
    with answering("open", bytes.fromhex("42 12 34 00 00")):
        read = ["open", "sdo", "read", "9", "2000", "--no-look", "--type", "u16"]
        assert command(*read) == 0
    assert out(capfd) == str(0x3412)


def test_sdo_refusals(capfd: pytest.CaptureFixture[str]) -> None:
    near = ["--no-look", "--bus", LINKED]
    with nodes("refusal", PAIR):
        write = ["refusal", "sdo", "write", "motor"]
        assert command(*write, "Vendor_ID", "1", *near) == 1
        assert (
            "motor 1018:1 Vendor_ID: the node refuses: 06010002h write of a read-only "
            "object" in shown(capfd.readouterr().err)
        )
        assert command(*write, "Producer_heartbeat_time", "70000", *near) == 2
        assert "over 65535" in shown(capfd.readouterr().err)
        assert command(*write, "Producer_heartbeat_time", "fast", *near) == 2
        assert "'fast' is not an integer" in shown(capfd.readouterr().err)
        assert command(*write, "Producer_heartbeat_tim", "1", *near) == 2
        assert "did you mean Producer_heartbeat_time?" in shown(capfd.readouterr().err)
        assert command(*write, "6060", *near) == 2
        read = ["refusal", "sdo", "read", "motor"]
        assert command(*read, "6060", "3", *near) == 2
        assert command(*read, "5FFF", "--type", "u8", *near) == 1
        assert "06020000h object does not exist" in shown(capfd.readouterr().err)
        silent = ["sdo", "read", "33", "1000", "--no-look", "--timeout", "0.02"]
        assert command("refusal", *silent) == 3
        assert "node 33 does not answer" in shown(capfd.readouterr().err)


def test_sdo_warns_of_a_manager(capfd: pytest.CaptureFixture[str]) -> None:
    def beat() -> None:
        until(lambda: listeners("managed") >= 3)
        peer.send(messages("77F#05")[0])

    with nodes("managed", PAIR), bus("managed") as peer, meanwhile(beat):
        assert command("managed", "sdo", "read", "motor", "1000", "--bus", LINKED) == 0
    captured = capfd.readouterr()
    assert captured.out.startswith("0x")
    assert "warning[ENV0002]: the manager (node 127) is on the bus" in captured.err


def test_sdo_of_files_by_blocks(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    source, target = tmp_path / "in.bin", tmp_path / "out.bin"
    source.write_bytes(bytes(i % 251 for i in range(3000)))
    name = f"{number_of('octets'):X}"
    link = open_link(RealClock(), "virtual", "files")
    node = DeviceNode(DEVICE, NODE_ID)
    with link.lock:
        link.attach(node)
        link.send(node.boot(link.now()), node)
    try:
        with bus("files") as peer:
            near = ["--no-look"]
            write = ["sdo", "write", "5", name, "--file", str(source)]
            assert command("files", *write, *near) == 0
            assert node.get(number_of("octets")) == source.read_bytes()
            read = ["sdo", "read", "5", name, "--file", str(target)]
            assert command("files", *read, *near) == 0
            assert target.read_bytes() == source.read_bytes()
            requests = iter(lambda: peer.recv(0), None)
            first = [m.data[0] for m in requests if m.arbitration_id == 0x605]
        assert first[0] & ~0x06 == 0xC0
        assert 0xA4 in first
    finally:
        link.detach(node)
    assert "3000 octets" in capfd.readouterr().err


def test_a_node_without_block_transfer_gets_segments(tmp_path: Path) -> None:
    canopen = pytest.importorskip("canopen", reason="the canopen package is missing")
    source, target = tmp_path / "in.bin", tmp_path / "out.bin"
    source.write_bytes(bytes(range(200)))
    network = canopen.Network()
    network.connect(interface="virtual", channel="segments")
    try:
        objects = canopen.ObjectDictionary()
        variable = canopen.objectdictionary.ODVariable("Text", 0x2000)
        variable.data_type = canopen.objectdictionary.DOMAIN
        objects.add_object(variable)
        network.add_node(canopen.LocalNode(5, objects))
        for action, path in (("write", source), ("read", target)):
            words = ["sdo", action, "5", "2000", "--no-look", "--file", str(path)]
            assert command("segments", *words) == 0
    finally:
        network.disconnect()
    assert target.read_bytes() == source.read_bytes()


# scan


def test_scan_tells_who_is_there(capfd: pytest.CaptureFixture[str]) -> None:
    wait = ["--for", "0.4"]
    with nodes("scan", {1: "motor_core_unit", 7: "epos_drive"}) as made:
        assert command("scan", "scan", "--no-lss", "--json", *wait) == 0
        listed = valid(out(capfd), "can.schema.json", "scan")["nodes"]
        assert [line["node"] for line in listed] == [1, 7]
        assert listed[1]["device"] == "Wheel drive 24/5 CiA 402 (drive)"
        assert listed[1]["product"] == 0x57443245
        assert listed[0]["state"] == "pre-operational"
        assert made[7].state.name == "PRE_OPERATIONAL"
        assert command("scan", "scan", "--no-lss", "--bus", LINKED, *wait) == 1
        lines = [line.split() for line in out(capfd).splitlines()]
    assert lines[1][:2] == ["1", "motor"]
    assert lines[1][-2:] == ["as", "described"]
    assert lines[2] == ["2", "palette", "missing"]
    assert lines[3][-2:] == ["not", "described"]


def test_scan_notices_another_device(capfd: pytest.CaptureFixture[str]) -> None:
    wait = ["--for", "0.4", "--no-lss"]
    with nodes("other", {1: "f_palette"}):
        assert command("other", "scan", *DRIVE, *wait) == 1
        assert "device type 0x" in out(capfd)


@pytest.mark.slow
def test_scan_finds_nodes_without_node_id(capfd: pytest.CaptureFixture[str]) -> None:
    def scanned() -> list[list[str]]:
        """Return the rows, if both are in time: the search of LSS waits for 50 ms each."""
        assert command("lss", "scan", "--for", "0.1") == 0
        captured = capfd.readouterr()
        lines = [line.split() for line in captured.out.splitlines()[1:]]
        is_whole = "0 nodes answer, 2 have no node-id" in captured.err
        return lines if is_whole else []

    with nodes("lss", {201: "epos_drive", 202: "epos_drive"}, serial=41) as made:
        lines = until(scanned)
        assert all(node.node_id == 255 for node in made.values())
    assert [line[-1] for line in lines] == ["41", "42"]
    assert lines[0][:5] == ["-", "no", "node-id", "vendor", "0xFFFF01"]


def test_a_search_whose_answer_was_late_is_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left, right = LssAddress(1, 2, 3, 4), LssAddress(1, 2, 3, 5)
    phantom = LssAddress(1, 2, 7, 4)
    outcomes = iter([None, left, None, phantom, None, right, None, None, None, left])

    def scan() -> Procedure[LssAddress | None]:
        return next(outcomes)
        yield

    def select(address: LssAddress) -> Procedure[bool]:
        return address in (left, right)
        yield

    monkeypatch.setattr(lss_scan, "scan", scan)
    monkeypatch.setattr(lss_scan, "select", select)
    found: list[LssAddress] = []

    def searched() -> Procedure[None]:
        found.extend((yield from lss_scan._all()))

    # A switch command before the scans, before each address is confirmed, and at the end.
    assert len(list(searched())) == 1 + 3 + 1
    assert found == [left, right]
    assert next(outcomes) == left


# plot and timing


def record(path: Path) -> Path:
    frames = [f"482#{(100 * place).to_bytes(4, 'little').hex()}" for place in range(5)]
    with can.Logger(path) as writer:
        for message in messages("080#", *frames, "281#0a00000000000000"):
            writer(message)
    return path


def test_plot_of_a_record(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = record(tmp_path / "a.log")
    outputs = [tmp_path / name for name in ("p.csv", "p.svg", "p.png")]
    arguments = [
        "Angle_reference",
        "motor.607A",
        "motor.6064",
        "--from",
        str(path),
        "--bus",
        LINKED,
    ]
    for output in outputs:
        arguments += ["-o", str(output)]
    assert run(["can", "plot", *arguments]) == 0
    rows = list(csv.reader(outputs[0].read_text().splitlines()))
    assert rows[0][0] == "t"
    assert set(rows[0][1:]) == {
        "motor.Target_position",
        "palette.Angle_reference",
        "motor.Position_actual_value",
    }
    column = rows[0].index("palette.Angle_reference")
    assert [(r[0], r[column]) for r in rows[1:] if r[column]] == [
        (f"{(place + 1) / 100:.6f}", f"{100 * place}") for place in range(5)
    ]
    column = rows[0].index("motor.Target_position")
    assert [r[column] for r in rows[1:] if r[column]][-1] == "400"
    assert outputs[1].read_text().startswith("<?xml")
    assert outputs[2].read_bytes().startswith(b"\x89PNG")
    assert "palette.Angle_reference: 5 values" in capfd.readouterr().err


def test_plot_live_and_refusals(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    target = str(tmp_path / "p.csv")

    def send() -> None:
        until(lambda: listeners("plot") >= 2)
        peer.send(messages("482#01000000")[0])

    base = ["plot", "palette.Angle_reference", "--bus", LINKED]
    with bus("plot") as peer, meanwhile(send):
        end = ["--count", "1", "--for", "10"]
        assert command("plot", *base, "-o", target, *end) == 0
    assert command("plot", *base, "-o", target, "--for", "0.01") == 1
    assert command("plot", *base, "-o", str(tmp_path / "p.txt")) == 2
    assert "the suffix is one of" in shown(capfd.readouterr().err)
    assert command("plot", *base, "--from", target, "-o", target) == 2
    assert "-o would overwrite" in shown(capfd.readouterr().err)
    missing = ["plot", "palette.Angle", "--bus", LINKED, "-o", target]
    assert command("plot", *missing) == 2
    monkeypatch.setattr("rtgen.tools.running.trajectory.find_spec", lambda name: None)
    assert command("plot", *base, "-o", str(tmp_path / "p.svg")) == 3
    assert ".[plot]" in shown(capfd.readouterr().err)


def test_timing(capfd: pytest.CaptureFixture[str]) -> None:
    path = str(SPECS / "rh3_beego.toml")
    assert run(["can", "timing", path, "--json"]) == 0
    report = valid(out(capfd), "can.schema.json", "timing")
    assert report["bit_rate"] == 1000
    frames = {(m["name"], m["id"], m["frame_ns"]) for m in report["messages"]}
    assert {("NMT", 0, 75_000), ("SYNC", 0x80, 55_000)} < frames
    assert run(["can", "timing", path]) == 0
    assert "Load: 11.5% at most" in out(capfd)
    assert run(["can", "timing", path, "--bit-rate", "10"]) == 1
    assert "no bound" in out(capfd)
    assert run(["can", "timing", "missing.toml"]) == 2
    assert "EDS0700" in capfd.readouterr().err


def test_a_command_without_its_extra(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "can", None)
    for words in (["scan"], ["send", "080#"], ["sdo", "read", "1", "1000"]):
        assert run(["can", *words, "--interface", "virtual"]) == 3
        assert (
            "pip install ./runtime '.[can]' in a clone of rtgen"
            in capfd.readouterr().err
        )


def test_the_commands_of_nmt_are_all_known() -> None:
    from rtgen.tools.can.parsing.frames import _COMMANDS

    assert set(_COMMANDS.values()) == set(NmtCommand)
