"""`rtgen can monitor`, `record` and `replay`: live output equals that of a record."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import struct
import subprocess
import sys
import tracemalloc
import zlib
from pathlib import Path
from typing import Any

import can
import pytest
from can_commands import (
    bus,
    command,
    listeners,
    meanwhile,
    messages,
    on,
    received,
    texts,
)
from json_schemas import valid
from patience import PATIENCE, until
from rich.console import Console as Terminal

from rtgen.cli import run
from rtgen.tools.can.decoding.frame_printing import MessageDecoder, Wanted
from rtgen.tools.can.decoding.live_table import show
from rtgen.tools.can.decoding.node_index import NodeIndex, read_node_index
from rtgen.tools.can.parsing import logs
from rtgen.tools.kit.exits import Refusal

SPECS = Path(__file__).parents[3] / "specs" / "canopen"
LINKED = str(SPECS / "pdo_linking.toml")
TRAFFIC = [
    "000#0101",
    "080#",
    "482#e8030000",
    "181#370203",
    "601#4018100100000000",
    "581#431810010100ffff",
    "081#1082110102030405",
    "702#05",
    "181#R",
    "01234567#aa",
]
KINDS = ["nmt", "sync", "tpdo4", "tpdo1", "sdo", "sdo", "emcy", "heartbeat", "tpdo1"]


def lines(text: str) -> list[dict[str, Any]]:
    return [valid(line, "can.schema.json", "frame") for line in text.splitlines()]


def untimed(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{k: v for k, v in line.items() if k != "time"} for line in found]


def sent_when(channel: str, count: int, peer: can.BusABC) -> None:
    until(lambda: listeners(channel) >= count)
    for message in messages(*TRAFFIC):
        peer.send(message)


def recorded(path: Path, frames: list[can.Message]) -> Path:
    with can.Logger(path) as writer:
        for message in frames:
            writer(message)
    return path


@pytest.mark.sampled(1)
@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf"])
def test_a_record_shows_what_was_live(
    suffix: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path, channel = tmp_path / f"run{suffix}", f"live{suffix}"
    end = ["--count", str(len(TRAFFIC)), "--for", "10"]
    with bus(channel) as peer:
        with meanwhile(lambda: sent_when(channel, 2, peer)):
            assert command(channel, "monitor", "--json", "--bus", LINKED, *end) == 0
        live = lines(capfd.readouterr().out)
        with meanwhile(lambda: sent_when(channel, 2, peer)):
            assert command(channel, "record", str(path), *end) == 0
    assert f"10 frames in {path}" in capfd.readouterr().err
    with can.LogReader(path) as reader:
        assert texts(list(reader)) == [t[:4].upper() + t[4:] for t in TRAFFIC]
    assert run(["can", "replay", str(path), "--decode", "--json", "--bus", LINKED]) == 0
    again = lines(capfd.readouterr().out)
    assert untimed(again) == untimed(live)
    assert [line["kind"] for line in live] == [*KINDS, "frame"]
    assert live[2]["values"] == [
        {"object": "2100:0", "name": "Angle_reference", "value": 1000}
    ]


def test_lines_for_people(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = recorded(tmp_path / "a.log", messages(*TRAFFIC))
    assert run(["can", "replay", str(path), "--decode", "--bus", LINKED]) == 0
    shown = capfd.readouterr().out.splitlines()
    assert shown[0] == "   0.000000       000  01 01                    motor nmt start"
    assert shown[2].endswith("palette tpdo4 -> motor.rpdo2 Angle_reference=1000")
    assert shown[9].split() == ["0.090000", "01234567", "aa", "frame", "aa"]


def test_filters(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = recorded(tmp_path / "a.log", messages(*TRAFFIC))
    base = ["can", "replay", str(path), "--decode", "--json", "--bus", LINKED]
    assert run([*base, "--node", "palette"]) == 0
    assert [x["kind"] for x in lines(capfd.readouterr().out)] == ["tpdo4", "heartbeat"]
    assert run([*base, "--kind", "tpdo", "--node", "motor"]) == 0
    assert [x["id"] for x in lines(capfd.readouterr().out)] == ["181", "181"]
    assert run([*base, "--node", "moter"]) == 2
    assert "did you mean motor?" in capfd.readouterr().err


def test_replay_on_a_bus(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = recorded(tmp_path / "a.log", messages(*TRAFFIC))
    with can.Logger(path, append=True) as writer:
        writer(can.Message(is_error_frame=True, timestamp=1_700_000_001.0))
    with bus("replay") as peer:
        for way in (["--at-once"], ["--speed", "50"]):
            assert command("replay", "replay", str(path), *way) == 0
            found = received(peer, len(TRAFFIC))
            assert texts(found) == [t[:4].upper() + t[4:] for t in TRAFFIC]
            err = capfd.readouterr().err
            assert "10 frames of" in err
            assert "1 cannot be sent" in err
        assert peer.recv(0) is None


def test_the_rhythm_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    slept = []

    def sleep(seconds: float) -> None:
        slept.append(round(seconds, 6))
        now[0] += seconds

    monkeypatch.setattr("can.io.player.time.perf_counter", lambda: now[0])
    monkeypatch.setattr("can.io.player.time.sleep", sleep)
    path = recorded(tmp_path / "a.log", messages("181#01", "181#02", "181#03"))
    assert command("rhythm", "replay", str(path), "--speed", "0.5") == 0
    assert slept[:2] == [0.02, 0.02]


def shown_table(known: NodeIndex, *frames: str) -> str:
    screen = Terminal(
        file=io.StringIO(), width=120, height=40, force_terminal=True, color_system=None
    )
    wanted = Wanted(known, (), ())
    show(iter(messages(*frames)), MessageDecoder(known), wanted, "virtual", screen)
    assert isinstance(screen.file, io.StringIO)
    return screen.file.getvalue()


def test_the_table_has_a_row_for_each_identifier() -> None:
    known = read_node_index(Path(LINKED), [])
    shown = shown_table(known, *TRAFFIC[:4], "181#380203", "482#00000000")
    last = shown[shown.rindex("virtual: 6 frames") :]
    rows = {
        line.split()[0]: line.split()[1:] for line in last.splitlines() if line.strip()
    }
    assert rows["000"][:2] == ["motor", "nmt"]
    assert rows["181"][:4] == ["motor", "tpdo1", "2", "10.0"]
    assert rows["181"][4] == "Statusword=568"
    assert "Angle_reference=0" in last


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["monitor"], 2, "which bus? Give --interface"),
        (["monitor", "--interface", "sockets"], 3, "no interface 'sockets'"),
        (
            ["monitor", "--interface", "socketcand", "--option", "port=1"],
            3,
            "is `rtgen can hub` running?",
        ),
        (["monitor", "--option", "x"], 2, "not KEY=VALUE"),
        (
            ["monitor", "--interface", "socketcand", "--option", "prt=1"],
            3,
            "socketcand has no option 'prt'; known: host, port",
        ),
        (["monitor", "--eds", "300=a.eds"], 2, "not a node-id"),
        (["monitor", "--bus", "missing.toml"], 2, "EDS0700"),
        (["monitor", "--eds", "1=missing.eds"], 2, "missing.eds"),
        (["monitor", "--bus", "a.eds"], 2, "--eds NODE-ID=FILE"),
        (["monitor", "--eds", "1=a.toml"], 2, "looks like a bus file"),
        (["monitor", "--node", "left"], 2, "give its node-id, or --bus"),
        (["monitor", "--kind", "pdo"], 2, "no frame is of kind 'pdo'"),
        (["record", "a.txt"], 2, ".blf (Vector BLF)"),
        (["replay", "missing.log", "--decode"], 3, "cannot read missing.log"),
        (["replay", "missing.txt"], 2, "the suffix has to name a log format"),
        (["replay", "missing.log", "--json"], 2, "go with --decode"),
    ],
)
def test_what_cannot_be(
    arguments: list[str],
    code: int,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert run(["can", *arguments]) == code
    err = capfd.readouterr().err
    assert message in " ".join(err.split())
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("environment", "file", "message"),
    [
        ({"CAN_INTERFACE": "sockets"}, "", 'Unknown interface type "sockets"'),
        ({"CAN_CONFIG": "port=1"}, "", "Expecting value"),
        ({"CAN_CONFIG": "[1]"}, "", "is not valid"),
        (
            {"CAN_BITRATE": "fast", "CAN_INTERFACE": "virtual"},
            "",
            "'fast' is not a bit",
        ),
        ({}, "interface = virtual", "no section headers"),
        ({}, "[default]\ninterface = virtual\nport = x", "Port config"),
    ],
)
def test_a_configuration_of_python_can_that_is_not_valid(
    environment: dict[str, str],
    file: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / ".canrc").write_text(file)
    monkeypatch.setenv("HOME", str(tmp_path))
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert run(["can", "monitor", "--for", "0.1"]) == 3
    err = capfd.readouterr().err
    assert message in err
    assert "python-can's configuration is not valid" in err
    assert "internal error" not in err


@pytest.mark.parametrize("name", ["a.log", "a.blf", "a.asc"])
def test_files_that_are_no_records(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    path.write_bytes(b"this is not a record\n" * 20)
    code = run(["can", "replay", str(path), "--decode"])
    captured = capfd.readouterr()
    assert captured.out == ""
    if name != "a.asc":
        # python-can skips lines that are not messages in ASC.
        assert code == 2
        assert "this is no" in captured.err


def test_a_folder_that_cannot_be_made(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    path = tmp_path / "file" / "a.log"
    assert command("none", "record", str(path), "--for", "0.1") == 3
    assert "cannot write" in capfd.readouterr().err


def test_without_python_can(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "can", None)
    assert run(["can", "monitor", "--interface", "virtual"]) == 3
    assert (
        "pip install ./runtime '.[can]' in a clone of rtgen" in capfd.readouterr().err
    )


@pytest.mark.sampled(1)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_record_is_complete_when_it_is_ended(
    number: signal.Signals, tmp_path: Path
) -> None:
    path = tmp_path / "a.blf"
    process = subprocess.Popen(
        [sys.executable, "-m", "rtgen", "can", "record", path, *on("can0")],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert process.stderr is not None
    assert "recording" in process.stderr.readline()
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "0 frames in" in err
    with can.LogReader(path) as reader:
        assert list(reader) == []


@pytest.mark.parametrize("place", [4, 152], ids=["header", "object"])
def test_a_size_in_a_blf_file_takes_no_memory(place: int, tmp_path: Path) -> None:
    path = tmp_path / "large.blf"
    with logs.writer(path) as made:
        made.on_message_received(can.Message(arbitration_id=1, data=b"\1"))
    octets = bytearray(path.read_bytes())
    octets[place : place + 4] = (1 << 29).to_bytes(4, "little")
    path.write_bytes(octets)
    tracemalloc.start()
    try:
        with contextlib.suppress(Refusal):
            list(logs.read(path, str))
        assert tracemalloc.get_traced_memory()[1] < 1 << 26
    finally:
        tracemalloc.stop()


@pytest.mark.sampled(0)
def test_a_container_that_inflates_without_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.blf"
    with logs.writer(path) as made:
        made.on_message_received(can.Message(arbitration_id=1, data=b"\1"))
    head = path.read_bytes()[:144]
    data = struct.pack("<H6xL4x", 2, 0) + zlib.compress(bytes(1 << 27), 9)
    container = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(data), 10) + data
    path.write_bytes(head + container)
    tracemalloc.start()
    try:
        with pytest.raises(Refusal, match="a container of more than"):
            list(logs.read(path, str))
        assert tracemalloc.get_traced_memory()[1] < 1 << 27
    finally:
        tracemalloc.stop()
