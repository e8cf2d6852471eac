"""Truncated, damaged or empty files: complete chunks are read, nothing else."""

from __future__ import annotations

import contextlib
import json
import struct
import subprocess
import sys
import tracemalloc
import zlib
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path

import lz4.frame
import pytest
import seeds
import zstandard
from recorded_runs import record

from rtgen.cli import run
from rtgen.tools.recording import mcap_writer
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_reader import MAGIC, McapFile

HERE = Path(__file__).parent


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    return [(m.channel.topic, m.time, m.data) for m in McapFile(path).messages()]


@pytest.fixture
def recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording of many small chunks."""
    monkeypatch.setattr(mcap_writer, "CHUNK", 1 << 11)
    path = tmp_path / "a.mcap"
    record(path, 200)
    return path


def chunks(data: bytes) -> list[tuple[int, int]]:
    """Return the positions of the chunks of a file."""
    found, at = [], len(MAGIC)
    while at < len(data) - len(MAGIC):
        opcode, length = struct.unpack_from("<BQ", data, at)
        if opcode == 6:
            found.append((at, at + 9 + length))
        at += 9 + length
    return found


def test_a_file_cut_anywhere_is_read_up_to_its_last_whole_chunk(
    recorded: Path, tmp_path: Path
) -> None:
    data = recorded.read_bytes()
    whole = messages(recorded)
    ends = [end for _, end in chunks(data)]
    assert len(ends) > 8
    path = tmp_path / "cut.mcap"
    counts = {}
    edges = {end + offset for end in (*ends, len(data)) for offset in range(-9, 10)}
    sizes = {*edges, *range(len(MAGIC), len(data), 131)}
    for size in sorted(size for size in sizes if len(MAGIC) <= size < len(data)):
        path.write_bytes(data[:size])
        found = messages(path)
        assert found == whole[: len(found)]
        before = sum(end <= size for end in ends)
        assert counts.setdefault(before, len(found)) == len(found)
        assert not McapFile(path).is_whole
    assert sorted(counts.values()) == [*counts.values()]
    assert counts[len(ends)] == len(whole)
    assert len(set(counts.values())) == len(ends) + 1


def test_a_damaged_chunk_is_left_out(recorded: Path, tmp_path: Path) -> None:
    data = bytearray(recorded.read_bytes())
    begin, end = chunks(data)[3]
    for at in range(begin + 60, end, 97):
        changed = bytearray(data)
        changed[at] ^= 0x55
        path = tmp_path / "damaged.mcap"
        path.write_bytes(changed)
        file = McapFile(path)
        found = [
            (m.topic, t) for m, t in ((m.channel, m.time) for m in file.messages())
        ]
        assert file.damaged == 1
        assert len(found) < len(messages(recorded))


def in_a_log(head: Mapping[str, str]) -> bool:
    return head["event"] in ("sample", "state")


READERS = [
    ["log", "info", "FILE"],
    ["log", "cat", "FILE"],
    ["log", "csv", "FILE", "Counter0.count"],
    ["log", "plot", "FILE", "Counter0.count", "-o", "FILE.svg"],
    ["log", "diff", "FILE", "FILE"],
    ["replay", "FILE"],
]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("command", READERS, ids=lambda words: "-".join(words[:2]))
def test_each_command_says_what_is_missing_of_a_recording(
    command: list[str],
    recorded: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    data = bytearray(recorded.read_bytes())
    (_, _), (begin, end) = chunks(data)[3], chunks(data)[4]
    damaged = data[: begin + 80] + b"\x55" + data[begin + 81 :]
    events = [json.dumps(event) + "\n" for event in Log(recorded).events(in_a_log)]
    log = "".join(events).encode()
    cases: list[tuple[str, bytes, list[str]]] = [
        ("whole.mcap", data, []),
        ("cut.mcap", data[: end - 10], ["cut off"]),
        ("damaged.mcap", damaged, ["1 damaged chunk left out"]),
        ("both.mcap", damaged[:-20], ["cut off", "1 damaged chunk left out"]),
        ("whole.log", log, []),
        ("cut.log", log[:-10], ["cut off"]),
    ]
    for name, octets, losses in cases:
        path = tmp_path / name
        path.write_bytes(octets)
        assert run([word.replace("FILE", str(path)) for word in command]) == 0
        captured = capfd.readouterr()
        said = captured.out if command[1] == "info" else captured.err
        assert all(loss in said for loss in losses), name
        assert ("cut off" in said or "left out" in said) == bool(losses), name


def claimed(length: int) -> bytes:
    return MAGIC + struct.pack("<BQ", 6, length) + bytes(100)


def bomb() -> bytes:
    """Return a chunk that is a gigabyte of zeros once it is unpacked."""
    import zstandard

    zeros = zstandard.ZstdCompressor().compress(bytes(1 << 24))
    head = struct.pack("<QQQI", 0, 0, 1 << 10, zlib.crc32(b""))
    body = head + struct.pack("<I", 4) + b"zstd" + struct.pack("<Q", len(zeros)) + zeros
    return MAGIC + struct.pack("<BQ", 6, len(body)) + body


@pytest.mark.parametrize(
    "data",
    [MAGIC, MAGIC + b"\x06", claimed(1 << 62), claimed(50), claimed(3), bomb()],
    ids=["empty", "opcode", "huge", "zeros", "short", "bomb"],
)
def test_garbage_has_no_messages(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(data)
    assert messages(path) == []


@pytest.mark.random
def test_random_damage_never_gives_a_traceback(recorded: Path, tmp_path: Path) -> None:
    import random

    data = recorded.read_bytes()
    whole = len(messages(recorded))
    for case in seeds.cases(60):
        draw = random.Random(case)
        changed = bytearray(data[: draw.randrange(len(MAGIC) + 1, len(data))])
        for _ in range(draw.randrange(1, 9)):
            changed[draw.randrange(len(MAGIC), len(changed))] = draw.randrange(256)
        path = tmp_path / "a.mcap"
        path.write_bytes(changed)
        with contextlib.suppress(RecordingError):
            assert sum(1 for _ in Log(path).events()) <= whole


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", None),
        (b"hello", "neither MCAP nor JSON lines"),
        (b'{"t": 1}\n', ":1: no line of a log"),
        (b'{"t": 1, "event": "state"}\n{]\n', ":2: no JSON"),
        (b'{"t": 1, "event": "state"}\n{"t": 2, "ev', None),
    ],
)
def test_logs_of_lines(tmp_path: Path, content: bytes, what: str | None) -> None:
    path = tmp_path / "log"
    path.write_bytes(content)

    def read() -> list[object]:
        return [*Log(path).events()]

    check: Callable[[], object] = read
    if what is None:
        assert len(read()) == content.count(b"\n")
    else:
        with pytest.raises(RecordingError, match=what):
            check()


@pytest.mark.parametrize("content", [b"", b"{", MAGIC[:-1]])
def test_a_file_without_the_magic_of_its_suffix(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    what = "is not MCAP, as its suffix says" if content else "is empty"
    with pytest.raises(RecordingError, match=what) as error:
        Log(path)
    assert error.value.hint


def test_a_writer_that_is_killed_leaves_whole_chunks(tmp_path: Path) -> None:
    """50 writers, each killed at a random moment; all in one process that forks them."""
    count = seeds.budget(50)
    command = [sys.executable, str(HERE / "killed_writers.py"), str(tmp_path)]
    arguments = [str(count), str(seeds.seed())]
    subprocess.run([*command, *arguments], check=True, timeout=600)
    lengths = []
    for number in range(count):
        found = [
            (int.from_bytes(data[-4:], "little"), time)
            for topic, time, data in messages(tmp_path / f"{number}.mcap")
            if topic == "/Counter0/count"
        ]
        assert found == [(n + 1, n * 1_000_000) for n in range(len(found))]
        lengths.append(len(found))
    assert len(set(lengths)) > count // 10
    assert max(lengths) > 1000


def test_values_nested_too_deep_are_an_error(tmp_path: Path) -> None:
    lines = tmp_path / "deep.jsonl"
    lines.write_text('{"t": 0, "event": ' + "[" * 200_000 + "\n", encoding="utf-8")
    with pytest.raises(RecordingError, match="nested too deep"):
        [*Log(lines).events()]
    path = tmp_path / "deep.mcap"
    with mcap_writer.McapWriter(path) as writer:
        writer.message(writer.channel("/a", "json", 0, {}), 0, b"[" * 200_000)
    with pytest.raises(RecordingError, match="/a: a value is nested too deep"):
        [*Log(path).events()]


@pytest.mark.sampled(0)
def test_a_chunk_of_very_many_records_is_read_in_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb.mcap"
    size = 9 << 17
    with mcap_writer.McapWriter(path) as writer:
        channel = writer.channel("/a", "json", 0, {})
        writer._chunk += struct.pack("<BQ", 0x80, 0) * (1 << 17)
        writer.message(channel, 0, b"1")
    assert path.stat().st_size < 10_000
    tracemalloc.start()
    try:
        [message] = McapFile(path).messages()
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert message.data == b"1"
    assert peak < 4 * size


def packed(content: bytes, compression: str = "zstd", size: int | None = None) -> bytes:
    """Return a chunk."""
    pack = {"zstd": zstandard.compress, "lz4": lz4.frame.compress, "": bytes}
    data = pack[compression](content)
    name = compression.encode()
    head = struct.pack("<QQQII", 0, 1, size or len(content), 0, len(name)) + name
    body = head + struct.pack("<Q", len(data)) + data
    return struct.pack("<BQ", 6, len(body)) + body


CHANNEL = struct.pack("<BQHHI2sI4sI", 4, 22, 1, 0, 2, b"/a", 4, b"json", 0)
MESSAGE = struct.pack("<BQHIQQ", 5, 23, 1, 0, 7, 7) + b"1"
MEGABYTE = 1 << 20


@pytest.mark.parametrize("inside", [False, True])
def test_octets_without_an_opcode_end_the_records(tmp_path: Path, inside: bool) -> None:
    """A file system can leave zeros at the end of a file whose writer was killed."""
    path = tmp_path / "a.mcap"
    records = CHANNEL + MESSAGE + bytes(9 * MEGABYTE) + MESSAGE
    path.write_bytes(MAGIC + (packed(records) if inside else records))
    assert messages(path) == [("/a", 7, b"1")]
    with path.open("r+b") as stream:
        stream.truncate(8 << 30)
    assert messages(path) == [("/a", 7, b"1")]
    assert not McapFile(path).is_whole


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "content",
    [bytes(16 * MEGABYTE), struct.pack("<BQ", 0x80, 0) * MEGABYTE, MESSAGE * MEGABYTE],
    ids=["zeros", "empty records", "messages"],
)
def test_work_is_limited_by_the_octets_of_the_file(
    tmp_path: Path, content: bytes
) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(MAGIC + CHANNEL + 64 * packed(content))
    with pytest.raises(RecordingError, match="than a recording of its size"):
        deque(McapFile(path).messages(), maxlen=0)


def test_chunks_whose_size_is_a_lie_are_damaged(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    chunk = packed(CHANNEL + MESSAGE)
    lies = packed(bytes(64 * MEGABYTE), size=100), packed(b"", size=1 << 60)
    path.write_bytes(MAGIC + b"".join(lies) + chunk)
    file = McapFile(path)
    assert [m.data for m in file.messages()] == [b"1"]
    assert file.damaged == 2


@pytest.mark.sampled(0)
def text(octets: bytes) -> bytes:
    """Return octets after their size."""
    return struct.pack("<I", len(octets)) + octets


def framed(opcode: int, head: bytes, *texts: bytes) -> bytes:
    """Return a record."""
    body = head + b"".join(map(text, texts))
    return struct.pack("<BQ", opcode, len(body)) + body


LONG = bytes(5 * MEGABYTE)
DESCRIPTIONS = {
    "schemas": lambda id_: framed(3, struct.pack("<H", id_), b"A", b"", LONG),
    "topics": lambda id_: framed(4, struct.pack("<HH", id_, 0), LONG, b"", b""),
    "metadata": lambda id_: framed(
        *(4, struct.pack("<HH", id_, 0), b"/a", b"", text(b"") + text(LONG))
    ),
}


@pytest.mark.parametrize("what", DESCRIPTIONS)
def test_topics_and_schemas_stay_in_memory_up_to_a_size(
    what: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.mcap"
    chunks = [packed(DESCRIPTIONS[what](number)) for number in range(1, 41)]
    path.write_bytes(MAGIC + b"".join(chunks) + MAGIC)
    assert path.stat().st_size < 1 << 17
    with pytest.raises(RecordingError, match="topics and schemas have over"):
        messages(path)


def test_a_schema_may_be_in_each_chunk(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(MAGIC + packed(DESCRIPTIONS["schemas"](1)) * 40 + MAGIC)
    assert messages(path) == []


def test_a_recording_that_compresses_well_is_read(tmp_path: Path) -> None:
    """Images that are black for a minute, with the numbers and times of messages."""
    path = tmp_path / "a.mcap"
    with mcap_writer.McapWriter(path) as writer:
        channel = writer.channel("/a", "json", 0, {})
        for number in range(600):
            writer.message(channel, 100_000_000 * number, bytes(MEGABYTE))
    assert path.stat().st_size < 2 * MEGABYTE
    assert len(messages(path)) == 600
