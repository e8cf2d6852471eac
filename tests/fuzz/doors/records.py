"""Doors for recordings: MCAP files, also for a replay, and logs of CAN frames."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random

import can
from fuzzing import log_uniform

from doors import Door
from doors.mixing import mixing
from refrobots.rtc import TimedLong
from rtgen.runtime import RTC_OK, Component, ComponentProfile, ReturnCode_t, System
from rtgen.tools.can.parsing import logs
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_reader import McapFile
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.recording.replay import course_of


class _Counter(Component):
    """Writes numbers."""

    profile = ComponentProfile("Counter")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.count = self.add_out_port("count", TimedLong)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.count.write(TimedLong(data=1))
        return RTC_OK


def _recorded(path: Path, compression: str) -> bytes:
    with McapWriter(path, compression) as writer, System() as system:
        system.add(_Counter("Counter0"), 100.0)
        system.activate("Counter0")
        recorder = Recorder(system, writer)
        system.run(50_000_000)
        recorder.end(through=True)
    return path.read_bytes()


def _mcap_seeds(folder: Path) -> list[bytes]:
    return [_recorded(folder / f"{kind or 'none'}.mcap", kind) for kind in ("", "zstd")]


def _changed(seeds: list[bytes], chance: Random) -> bytes:
    data = bytearray(chance.choice(seeds))
    for _ in range(log_uniform(1, 12, chance.random())):
        at = chance.randrange(len(data) + 1)
        match chance.randrange(5):
            case 0:
                del data[at : at + log_uniform(1, 60, chance.random())]
            case 1:
                data[at : at + 1] = chance.randbytes(1)
            case 2:
                data[at : at + 8] = chance.choice(
                    (bytes(8), b"\xff" * 8, b"\1" + bytes(7))
                )
            case 3:
                other = chance.randrange(len(data) + 1)
                data[at:at] = data[other : other + log_uniform(1, 300, chance.random())]
            case _:
                del data[at:]
                data += chance.choice((b"", b"\x89MCAP0\r\n"))
    return bytes(data)


def _mcap(folder: Path) -> Door:
    seeds, path = _mcap_seeds(folder), folder / "input.mcap"

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        try:
            file = McapFile(path)
            found = bool(file.metadata) and file.is_whole
            for message in file.messages():
                message.channel.get("kind")
        except RecordingError:
            return False
        return found

    return Door(enter, partial(_changed, seeds), seeds)


def _replay(folder: Path) -> Door:
    """Return the replay of a recording of one component for the others."""
    seeds, path = _mcap_seeds(folder), folder / "input.mcap"

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        try:
            course_of(McapFile(path))
        except RecordingError:
            return False
        return True

    return Door(enter, partial(_changed, seeds), seeds)


def _log(folder: Path) -> Door:
    """Return the input of `rtgen log`: recordings with their values, and JSON lines."""
    path = folder / "input.log"
    seeds = _mcap_seeds(folder)
    lines = [
        b'{"t":0,"event":"begin","end":null}\n',
        b'{"t":5,"event":"sample","instance":"A0","port":"out","value":{"data":1.5}}\n',
        b'{"t":7,"event":"state","instance":"A0","state":"ACTIVE","reason":"x"}\n',
    ]
    text = mixing([b"".join(lines), *lines])

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        try:
            for event in Log(path).events():
                json.dumps(event)
        except RecordingError:
            return False
        return True

    def make(chance: Random) -> bytes:
        return text(chance) if chance.random() < 0.5 else _changed(seeds, chance)

    return Door(enter, make, (*seeds, b"".join(lines)))


_CAN_LOGS = (
    b"(1436509052.249713) vcan0 044#2A366C2BBA\n(1436509052.449847) vcan0 0F6#R\n",
    b"date Tue Jan 5 10:00:00 am 2021\nbase hex timestamps absolute\n"
    b" 0.015991 1 18EBFF00x Rx d 8 01 A0 0F A6 60 3B D1 40 Length = 0\n",
    b";$FILEVERSION=2.0\n;$STARTTIME=45292.5\n;$COLUMNS=N,O,T,I,d,l,D\n;\n"
    b" 1 10.5 DT 0181 Rx 2 01 02\n 2 20.1 ST Rx 4 00 00 00 08\n",
    b"(1.0)  vcan0  044   [3]  2A 36 6C\n(2.0) vcan0 20000004#0004000000000000\n",
)


def _can_log(folder: Path) -> Door:
    paths = {suffix: folder / f"input{suffix}" for suffix in logs.READ}
    with logs.writer(folder / "seed.blf") as blf:
        for number in range(3):
            blf.on_message_received(can.Message(arbitration_id=number, data=b"\1\2"))
    seeds = [*_CAN_LOGS, (folder / "seed.blf").read_bytes()]

    suffixes = {b"L": ".blf", b"(": ".log", b";": ".trc"}

    def enter(data: bytes) -> bool:
        suffix = suffixes.get(data[:1], ".asc")
        paths[suffix].write_bytes(data)
        try:
            return sum(1 for _ in logs.read(paths[suffix], str)) > 0
        except Refusal:
            return False

    text = mixing(_CAN_LOGS)

    def make(chance: Random) -> bytes:
        return text(chance) if chance.random() < 0.7 else _changed(seeds[-1:], chance)

    return Door(enter, make, seeds)


DOORS: dict[str, Callable[[Path], Door]] = {
    "mcap": _mcap,
    "replay": _replay,
    "log": _log,
    "can-log": _can_log,
}
