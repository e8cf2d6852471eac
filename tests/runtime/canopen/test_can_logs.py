"""Logs of CAN buses: what a file says is read, what it does not say is not made up."""

from __future__ import annotations

import struct
from pathlib import Path
from random import Random

import can
import pytest
from can_commands import bus, command, messages, received, texts
from seeds import cases

from rtgen.cli import run
from rtgen.tools.can.parsing import logs
from rtgen.tools.kit.exits import Refusal

FRAMES = ["181#0102030405060708", "081#", "702#05", "12345678#aabb", "181#R", "482#ff"]


def read(path: Path, *, only_certain: bool = False) -> tuple[list[str], list[str]]:
    """Return the frames of a log, and what is reported of it."""
    reports: list[str] = []
    found = logs.read(path, reports.append, only_certain=only_certain)
    return texts([*found]), reports


def written(path: Path, frames: list[can.Message]) -> bytes:
    with can.Logger(path) as writer:
        for message in frames:
            writer(message)
    return path.read_bytes()


def log(tmp_path: Path, *lines: str, name: str = "a.log") -> Path:
    path = tmp_path / name
    path.write_text("".join(f"{line}\n" for line in lines))
    return path


SCREEN = """\
  can0  181   [8]  01 02 03 04 05 06 07 08
 (1700000000.000000)  can0  181   [2]  37 02
 (2023-11-14 22:13:20.000000)  can0  12345678   [2]  AA BB   '..'
  can0  RX - -  702   [1]  05
  can0  081   [0]
  can0  181   [0]  remote request
  can0  \x1b[31m482\x1b[0m   [1]  FF
"""


def test_the_screen_output_of_candump_is_read(tmp_path: Path) -> None:
    frames, reports = read(log(tmp_path, SCREEN))
    assert frames == [
        "181#0102030405060708",
        "181#3702",
        "12345678#aabb",
        "702#05",
        "081#",
        "181#R",
        "482#ff",
    ]
    assert reports == []


ERRORS = [
    ("(1.0) can0 20000004#0004000000000000", "controller problem"),
    ("(1.0) can0 20000088#0000000000000000", "protocol violation, bus error"),
    ("(1.0) can0 20000040#0000000000000000", "bus off"),
    ("(1.0) can0 20000000#0000000000000000", ""),
    ("(1.0) can0 200001FF#", "controller restarted"),
    ("  can0  20000020   [8]  00 00 00 00 00 00 00 00   ERRORFRAME", "no acknowledge"),
]


@pytest.mark.parametrize(("line", "text"), ERRORS)
def test_error_frames_are_shown_as_such_and_not_sent(
    line: str, text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = log(tmp_path, line, "(2.0) can0 181#01")
    assert run(["can", "replay", str(path), "--decode"]) == 0
    shown = capfd.readouterr().out.splitlines()[0]
    assert "error frame" in shown
    assert text in shown
    with bus("errors") as peer:
        assert command("errors", "replay", str(path), "--at-once") == 0
        assert texts(received(peer, 1)) == ["181#01"]
        assert peer.recv(0) is None
    assert "1 frame of" in (err := capfd.readouterr().err)
    assert "1 cannot be sent" in err


def test_frames_of_can_fd_are_shown_as_such_and_not_sent(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = log(
        tmp_path,
        "(1.0) can0 181##1AABB",
        "  can0  181  [08]  01 02 03 04 05 06 07 08",
        "(1.0) can0 181##0" + "00" * 64,
    )
    assert run(["can", "replay", str(path), "--decode"]) == 0
    shown = capfd.readouterr().out.splitlines()
    assert ["no classical frame" in line for line in shown] == [True] * 3
    with bus("fd") as peer:
        assert command("fd", "replay", str(path), "--at-once") == 0
        assert peer.recv(0) is None


DAMAGED = [
    "(1.0) can0 181#012",
    "(1.0) can0 181#0",
    "(1.0) can0 18#01",
    "(1.0) can0 800#01",
    "(1.0) can0 40000181#01",
    "(1.0) can0 181#001122334455667788",
    "(1.0) can0 181#R9",
    "(1.0) can0 181",
    "(nan) can0 181#01",
    "(-1.0) can0 181#01",
    "(then) can0 181#01",
    "  can0  181   [8]  01 02 03",
    "  can0  181   [1]  0",
    "  can0  181   [2]  01 02 03",
    "  can0  181   [8]  00000001 00000010",
    "bash: candump: command not found",
]


@pytest.mark.parametrize("line", DAMAGED)
def test_a_line_that_is_no_frame_is_reported_and_the_rest_is_read(
    line: str, tmp_path: Path
) -> None:
    path = log(tmp_path, "(1.0) can0 181#01", line, "(2.0) can0 182#02")
    frames, reports = read(path)
    assert frames == ["181#01", "182#02"]
    [report] = reports
    assert report.startswith(f"{path}: line 2: ")
    with pytest.raises(Refusal, match="this is not a candump log"):
        read(log(tmp_path, line))


@pytest.mark.sampled(0)
@pytest.mark.parametrize("suffix", ["log", "asc", "trc"])
def test_what_has_no_end_is_not_read_to_its_end(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"zeros.{suffix}"
    with file.open("wb") as stream:
        stream.truncate(8 << 30)
    with pytest.raises(Refusal, match=r"this is not a .* file: line 1 has no end"):
        list(logs.read(file, print))
    frames = b"(1.0) can0 123#01\n"
    log = tmp_path / "text.log"
    log.write_bytes(frames + b"x\n" * 100_002 + frames)
    reported: list[str] = []
    assert len(list(logs.read(log, reported.append))) == 1
    assert "the rest after 100,000 places without a frame; left out" in reported[-2]
    log.write_bytes((b"x\n" * 90_000 + frames) * 3)
    assert len(list(logs.read(log, reported.append))) == 3


def test_many_damaged_lines_are_counted(tmp_path: Path) -> None:
    frames, reports = read(log(tmp_path, "(1.0) can0 181#01", *["?"] * 100))
    assert frames == ["181#01"]
    assert len(reports) == 4
    assert "97 further places" in reports[-1]


TRACES = {
    "1.0": """\
;   Start time: 01.01.2024
     1)      10  0181 2 01 02
     2)      20  FFFFFFFF 4 00 00 00 08 BUSHEAVY
     3)      30  12345678 1 AA
""",
    "1.1": """\
;$FILEVERSION=1.1
;$STARTTIME=45292.5
;
     1)      10.5  Rx  0181 2 01 02
     2)      20.1  Warng FFFFFFFF 4 00 00 00 08 BUSHEAVY
     3)      30.2  Tx  12345678 1 AA
     4)      40.2  Rx  0181 8 RTR
""",
    "1.3": """\
;$FILEVERSION=1.3
;$STARTTIME=45292.5
;
     1)      10.5 1  Rx  0181 - 2 01 02
     2)      20.1 1  Warng FFFFFFFF - 4 00 00 00 08
     3)      30.2 1  Tx  12345678 - 1 AA
""",
    "2.0": """\
;$FILEVERSION=2.0
;$STARTTIME=45292.5
;$COLUMNS=N,O,T,I,d,l,D
;
      1    10.5 DT 0181 Rx 2 01 02
      2    20.1 ST      Rx 4 00 00 00 08
      3    30.2 DT 12345678 Tx 1 AA
      4    40.2 ER      Rx 5 04 00 02 00 00
""",
    "2.1": """\
;$FILEVERSION=2.1
;$STARTTIME=45292.5
;$COLUMNS=N,O,T,B,I,d,R,L,D
;
      1    10.5 DT 1 0181 Rx - 2    01 02
      2    20.1 ST 1    - Rx - 4    00 00 00 08
      3    30.2 DT 1 12345678 Tx - 1    AA
""",
}


@pytest.mark.parametrize("version", TRACES)
def test_traces_of_peak_are_read(version: str, tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_text(TRACES[version])
    frames, reports = read(path)
    assert frames[:2] == ["181#0102", "12345678#aa"]
    assert frames[2:] == (["181#R"] if version == "1.1" else [])
    assert reports == []
    cut = TRACES[version].replace(" 01 02", " 01")
    path.write_text(cut)
    frames, reports = read(path)
    assert frames[0] == "12345678#aa"
    assert len(reports) == 1


def test_a_trace_of_another_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_text(TRACES["1.3"].replace("1.3", "1.2", 1))
    with pytest.raises(Refusal, match=r"version 1\.2 are not read"):
        read(path)


def test_a_damaged_line_of_a_vector_log_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    lines = written(path, messages(*FRAMES)).decode().splitlines(keepends=True)
    [number] = [n for n, line in enumerate(lines) if " 702 " in line]
    lines[number] = lines[number].replace(" 05", " 0G")
    path.write_text("".join(lines))
    frames, reports = read(path)
    assert frames == [text for text in FRAMES if text != "702#05"]
    assert f"line {number + 1}" in reports[0]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf"])
def test_a_log_that_is_cut_has_no_other_frames(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    whole = written(path, messages(*FRAMES * 3))
    all_frames, reports = read(path)
    assert all_frames == FRAMES * 3
    assert reports == []
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        try:
            frames, reports = read(path, only_certain=True)
            shown, _ = read(path)
        except Refusal:
            continue
        assert frames == all_frames[: len(frames)], length
        assert len(shown) - len(frames) in (0, 1)
        if suffix == ".blf":
            assert reports, length


def test_a_frame_in_a_line_without_an_end_is_shown_and_not_sent(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.log"
    path.write_text("(1.0) can0 181#01\n(1.0) can0 181#02")
    assert run(["can", "replay", str(path), "--decode"]) == 0
    captured = capfd.readouterr()
    assert len(captured.out.splitlines()) == 2
    assert "the last line has no end: it may be cut off" in captured.err
    with bus("open end") as peer:
        assert command("open end", "replay", str(path), "--at-once") == 0
        assert texts(received(peer, 1)) == ["181#01"]
        assert peer.recv(0) is None


class SmallContainers(can.BLFWriter):
    """A log with containers of some 85 frames."""

    max_container_size = 1 << 12


@pytest.mark.parametrize("seed", cases(20))
def test_a_flipped_bit_in_a_container_costs_at_most_its_frames(
    seed: int, tmp_path: Path
) -> None:
    chance = Random(seed)
    path = tmp_path / "a.blf"
    with SmallContainers(path) as writer:
        for number in range(400):
            data = chance.randbytes(8)
            message = can.Message(arbitration_id=number, data=data, timestamp=1.0)
            message.is_extended_id = False
            writer(message)
    whole = path.read_bytes()
    all_frames, _ = read(path)
    assert len(all_frames) == 400
    octets = bytearray(whole)
    begin = struct.unpack_from("<L", whole, 4)[0]
    octets[chance.randrange(begin, len(octets))] ^= 1 << chance.randrange(8)
    path.write_bytes(octets)
    frames, reports = read(path)
    assert set(frames) <= set(all_frames)
    assert len(frames) >= 200
    assert reports or frames == all_frames
