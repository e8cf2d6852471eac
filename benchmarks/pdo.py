"""PDOs: the generated codec compared with the `canopen` package, a proxy with python-can.

    python benchmarks/pdo.py

First the coding of four INTEGER16, then of eight BOOLEAN and a 24-bit integer, against the
package's access to PDO variables: the median of a call in nanoseconds, with its ratio to ours.

Then frames of four INTEGER16 from another process, over python-can's interface `socketcand`: how
many a second a loop around `recv` receives, and how many reach a port connected with the OutPort of
a generated proxy, in the same run. Rounds are interleaved.
"""

from __future__ import annotations

import importlib
import logging
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import can
import canopen
from tables import Arguments, Results

from rtgen.cli import run
from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.pdo_codec import Codecs, PdoCodec
from rtgen.compiler.backends.kit.python_module import python_module
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.pdo import Mapped, layout
from rtgen.compiler.model.canopen import DataType
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    RealClock,
    ReturnCode_t,
    System,
)

SECONDS_PER_ROUND = 0.004
MAPPINGS: dict[str, tuple[list[Mapped], tuple[int, ...]]] = {
    "four INTEGER16": (
        [Mapped(f"f{n}", DataType.INTEGER16, 16) for n in range(4)],
        (-32768, -1, 0, 32767),
    ),
    "eight BOOLEAN, one UNSIGNED24": (
        [
            *(Mapped(f"f{n}", DataType.BOOLEAN, 1) for n in range(8)),
            Mapped("f8", DataType.UNSIGNED24, 24),
        ],
        (True, False, True, True, False, False, True, False, 0x123456),
    ),
}


def ours(mapped: Sequence[Mapped], values: tuple[int, ...]) -> list[Callable[[], Any]]:
    """Return encoding and decoding with the generated codec."""
    module = ModuleType("codec")
    codecs = [PdoCodec("tpdo1", "TPDO 1", layout(mapped))]
    body = render("canopen/pdo_codecs.py.j2", codecs=Codecs(codecs, codecs))
    options = Options("codec", "codec", "1")
    text = python_module("codec.py", options, (), "Codecs.", body=body).text
    exec(compile(text, "codec", "exec"), module.__dict__)
    encode, decode = module.encode_tpdo1, module.decode_tpdo1
    data = encode(*values)
    assert decode(data) == values
    return [lambda: encode(*values), lambda: decode(data)]


def theirs(
    mapped: Sequence[Mapped], values: tuple[int, ...]
) -> list[Callable[[], Any]]:
    """Return the same through a PdoMap of the package."""
    node = canopen.RemoteNode(1, canopen.ObjectDictionary())
    canopen.Network().add_node(node)
    pdo = canopen.pdo.base.PdoMap(node.tpdo, None, None)
    for number, entry in enumerate(mapped):
        variable = canopen.objectdictionary.ODVariable(entry.name, 0x2000 + number)
        variable.data_type = int(entry.data_type)
        node.object_dictionary.add_object(variable)
        pdo.add_variable(0x2000 + number, 0, entry.bits)

    def encode() -> bytes:
        for field, value in zip(pdo.map, values, strict=True):
            field.raw = value
        return bytes(pdo.data)

    def decode() -> tuple[int, ...]:
        return tuple(field.raw for field in pdo.map)

    encode()
    assert decode() == values
    return [encode, decode]


def seconds_per_call(task: Callable[[], object]) -> float:
    """Return the time of a call, over a round."""
    calls, start = 0, time.perf_counter()
    while (taken := time.perf_counter() - start) < SECONDS_PER_ROUND:
        for _ in range(20):
            task()
        calls += 20
    return taken / calls


FRAMES = 20_000
CHUNK = 1_000
CHUNKS_AHEAD = 3
"""Chunks that may be under way: fewer frames than a proxy's queue holds, so none is lost."""
TIMEOUT = 10.0
"""Time-out of all steps [s]."""


@contextmanager
def peer() -> Iterator[tuple[int, Callable[[int], None]]]:
    """Start a process that sends PDOs; yield its port, and a function that requests frames."""
    program = Path(__file__).with_name("pdo_peer.py")
    with subprocess.Popen(
        [sys.executable, str(program), "serve"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        told = process.stdin

        def send(count: int) -> None:
            told.write(f"{count}\n")
            told.flush()

        try:
            yield int(process.stdout.readline()), send
        finally:
            process.kill()


class Feed:
    """Requests frames a few chunks ahead of the received ones; the same for both readers."""

    def __init__(self, send: Callable[[int], None]) -> None:
        self._send = send
        self._sent = CHUNKS_AHEAD * CHUNK
        send(self._sent)

    def taken(self, count: int) -> None:
        """Set the number of received frames."""
        while self._sent < min(FRAMES, count + (CHUNKS_AHEAD - 1) * CHUNK + 1):
            self._send(CHUNK)
            self._sent += CHUNK


def bare(port: int, send: Callable[[int], None]) -> float:
    """Return frames per second of a loop around `recv`."""
    bus = can.Bus(
        interface="socketcand",
        host="127.0.0.1",
        port=port,
        channel="can0",
        tcp_tune=True,
    )
    try:
        time.sleep(0.1)
        feed = Feed(send)
        assert bus.recv(TIMEOUT) is not None
        start = time.perf_counter()
        for number in range(2, FRAMES + 1):
            assert bus.recv(TIMEOUT) is not None
            if not number % CHUNK:
                feed.taken(number)
        return (FRAMES - 1) / (time.perf_counter() - start)
    finally:
        bus.shutdown()


class Sink(Component):
    """Counts the samples that its port receives."""

    profile = ComponentProfile("Sink", rate=1000.0)

    def __init__(self) -> None:
        super().__init__("sink")
        self.count = 0
        self.feed: Feed | None = None
        self.first = self.last = 0.0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        port = self.in_ports["samples"]
        while port.is_new():
            port.read()
            self.last = time.perf_counter()
            self.count += 1
            if self.count == 1:
                self.first = self.last
            if not self.count % CHUNK and self.feed is not None:
                self.feed.taken(self.count)
        return RTC_OK


def generated(folder: Path) -> type[Component]:
    """Return the proxy of a device with one TPDO of four INTEGER16."""
    shutil.copy(Path(__file__).with_name("pdo_meter.eds"), folder / "meter.eds")
    text = '[sources]\npaths = ["meter.eds"]\n[output]\npackage = "metered"\n'
    (folder / "rtgen.toml").write_text(text, encoding="utf-8")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert run(["generate", "--no-cache", "--quiet"]) == 0
    finally:
        os.chdir(before)
    sys.path.insert(0, str(folder / "generated"))
    proxy: type[Component] = importlib.import_module(
        "metered.components.meter_proxy"
    ).MeterProxy
    return proxy


def proxied(proxy: Component, port: int, send: Callable[[int], None]) -> float:
    """Return frames per second that reach a port connected with the OutPort of a proxy."""
    sink = Sink()
    sink.add_in_port("samples", proxy.out_ports["tpdo1"].type)
    settings = {
        "interface": "socketcand",
        "options": f"host=127.0.0.1,port={port},tcp_tune=true",
        "node_id": "5",
        "master": "1",
    }
    for name, value in settings.items():
        proxy.configuration_sets.set(name, value)
    system = System(RealClock())
    try:
        system.add(proxy, 1000.0)
        system.add(sink, 1000.0)
        long = {"dataport.buffer.length": str(FRAMES)}
        system.connect((proxy.instance_name, "tpdo1"), ("sink", "samples"), long)
        for name in (proxy.instance_name, "sink"):
            system.activate(name)
        wait(system, lambda: proxy.is_active and sink.is_active, proxy)
        sink.feed = Feed(send)
        wait(system, lambda: sink.count + proxy.lost + sink.lost >= FRAMES, proxy)
        assert proxy.lost == sink.lost == 0
        return (FRAMES - 1) / (sink.last - sink.first)
    finally:
        system.close()


def wait(system: System, until: Callable[[], bool], proxy: Component) -> None:
    """Run the system until the condition holds."""
    end = time.monotonic() + TIMEOUT
    while not until():
        if time.monotonic() > end:
            raise SystemExit(f"it does not come to that: {proxy.reason}")
        system.run(system.time + 5_000_000)


def main() -> None:
    """Print times of coding, then frames per second, bare and through a proxy."""
    chosen = Arguments(__doc__, rounds=7).parse_args()
    with Results(__file__, chosen) as results:
        figures = ("rtgen [ns]", ".0f"), ("canopen [ns]", ".0f"), ("ratio", ".1f")
        table = results.table("codecs", "mapping", *figures)
        for name, (mapped, values) in MAPPINGS.items():
            tasks = zip(ours(mapped, values), theirs(mapped, values), strict=True)
            for what, pair in zip(("encode", "decode"), tasks, strict=True):
                rounds = [
                    [*map(seconds_per_call, pair)] for _ in range(4 * chosen.rounds)
                ]
                mine, other = map(statistics.median, zip(*rounds, strict=True))
                table.add(f"{name}, {what}", mine * 1e9, other * 1e9, other / mine)
        rates = ("recv [1/s]", ",.0f"), ("proxy [1/s]", ",.0f"), ("ratio", ".2f")
        table = results.table("frames", "frames over", *rates)
        # python-can warns whenever a frame arrives in two pieces.
        logging.getLogger("can").setLevel(logging.ERROR)
        with tempfile.TemporaryDirectory() as folder, peer() as (port, send):
            type_ = generated(Path(folder))
            rounds = [
                [bare(port, send), proxied(type_("meter"), port, send)]
                for _ in range(chosen.rounds)
            ]
        plain, through = map(statistics.median, zip(*rounds, strict=True))
        table.add("socketcand", plain, through, through / plain)


if __name__ == "__main__":
    main()
