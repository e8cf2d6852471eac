"""`rtgen can hub` compared with python-can's virtual bus and with TCP without a hub.

    python benchmarks/can_hub.py

First the round trip of a frame of eight octets to another process that sends it back, over the hub:
by rtgen's client, and by python-can's interface `socketcand`; beside it a ping-pong of the same
texts over TCP, and python-can's `virtual` to a thread. Then frames per second from another process:
to a client that only reads text, to python-can over the hub, to python-can from a server that sends
it the texts without a hub, and over `virtual`. Medians of interleaved rounds, with ratios. All
processes are on one processor, so that wake-up times do not vary.
"""

from __future__ import annotations

import logging
import os
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import can
from tables import Arguments, Results

from rtgen.runtime.canopen.bus.python_can import BusAddress, OpenBus, open_bus
from rtgen.runtime.canopen.wire.frames import Frame

TRIPS = 400
FRAMES = 10_000
HOST = "127.0.0.1"
SENT = b"< send 123 8 1 2 3 4 5 6 7 8 >"
CARRIED = b"< frame 123 1700000000.000000 0102030405060708 >"


def connected(port: int, channel: str) -> socket.socket:
    """Return a connection to a hub in raw mode."""
    end = socket.create_connection((HOST, port))
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    end.recv(256)
    for command in (f"< open {channel} >", "< rawmode >"):
        end.sendall(command.encode())
        end.recv(256)
    return end


def link_of(port: int, channel: str) -> OpenBus:
    """Return rtgen's client."""
    options = (("host", HOST), ("port", port))
    return open_bus(BusAddress("socketcand", channel, options=options))


def bus_of(port: int, channel: str) -> can.BusABC:
    """Return python-can's client."""
    return can.Bus(
        interface="socketcand", channel=channel, host=HOST, port=port, tcp_tune=True
    )


# Programs of other processes.


def echo(port: int) -> None:
    """Send every frame back."""
    bus = bus_of(port, "trip")
    print("ready", flush=True)
    while True:
        if (message := bus.recv(10)) is not None:
            bus.send(message)


def echo_frames(port: int) -> None:
    """Send every frame back, by rtgen's client."""
    bus = link_of(port, "frames")
    print("ready", flush=True)
    while True:
        for frame in bus.receive_events(10, 1):
            assert isinstance(frame, Frame)
            bus.send(frame)


def ping_pong() -> None:
    """Send the text of a frame back for that of another."""
    with socket.create_server((HOST, 0)) as server:
        print(server.getsockname()[1], flush=True)
        end, _ = server.accept()
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while end.recv(256):
            end.sendall(CARRIED)


def flood(port: int) -> None:
    """Send as many frames as each line of standard input says."""
    with connected(port, "flood") as end:
        print("ready", flush=True)
        for line in sys.stdin:
            end.sendall(SENT * int(line))


def serve_texts() -> None:
    """Send texts of frames, as a hub without other work would."""
    with socket.create_server((HOST, 0)) as server:
        print(server.getsockname()[1], flush=True)
        end, _ = server.accept()
        end.sendall(b"< hi >")
        for _ in range(2):
            end.recv(256)
            end.sendall(b"< ok >")
        for line in sys.stdin:
            end.sendall(CARRIED * int(line))


PROGRAMS = {f.__name__: f for f in (echo, echo_frames, ping_pong, flood, serve_texts)}


@contextmanager
def process(*command: str) -> Iterator[tuple[str, Callable[[int], None]]]:
    """Start a program; yield its first line, and a function that writes a number to it."""
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdin is not None
        assert program.stdout is not None
        told = program.stdin

        def tell(number: int) -> None:
            told.write(f"{number}\n")
            told.flush()

        try:
            yield program.stdout.readline().strip(), tell
        finally:
            program.kill()


def own(name: str, *arguments: object) -> tuple[str, ...]:
    """Return the command for a program of this file."""
    return (sys.executable, __file__, name, *map(str, arguments))


# Round trips, in seconds.


def over_the_hub(bus: can.BusABC) -> float:
    message = can.Message(arbitration_id=0x123, data=range(1, 9), is_extended_id=False)
    start = time.perf_counter()
    for _ in range(TRIPS):
        bus.send(message)
        assert bus.recv(10) is not None
    return (time.perf_counter() - start) / TRIPS


def between_links(bus: OpenBus) -> float:
    frame = Frame(0x123, bytes(range(1, 9)))
    start = time.perf_counter()
    for _ in range(TRIPS):
        bus.send(frame)
        assert bus.receive_events(10, 1) == [frame]
    return (time.perf_counter() - start) / TRIPS


def over_tcp(end: socket.socket) -> float:
    start = time.perf_counter()
    for _ in range(TRIPS):
        end.sendall(SENT)
        assert end.recv(256) == CARRIED
    return (time.perf_counter() - start) / TRIPS


# Frames per second.


def as_text(end: socket.socket, tell: Callable[[int], None]) -> float:
    left = FRAMES
    start = time.perf_counter()
    tell(FRAMES)
    while left > 0:
        left -= end.recv(1 << 16).count(b">")
    return FRAMES / (time.perf_counter() - start)


def by_python_can(bus: can.BusABC, tell: Callable[[int], None]) -> float:
    start = time.perf_counter()
    tell(FRAMES)
    for _ in range(FRAMES):
        assert bus.recv(10) is not None
    return FRAMES / (time.perf_counter() - start)


def virtual_flood(sender: can.BusABC, count: int) -> None:
    message = can.Message(arbitration_id=0x123, data=range(1, 9), is_extended_id=False)

    def send() -> None:
        for _ in range(count):
            sender.send(message)

    threading.Thread(target=send, daemon=True).start()


def virtual_echo(bus: can.BusABC) -> None:
    while True:
        if (message := bus.recv(10)) is not None:
            bus.send(message)


def median_of(cases: dict[str, Callable[[], float]], rounds: int) -> dict[str, float]:
    """Return the median of each case; rounds are interleaved."""
    found: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, case in cases.items():
            found[name].append(case())
    return {name: statistics.median(values) for name, values in found.items()}


def main(results: Results, rounds: int) -> None:
    """Print both tables."""
    logging.getLogger("can").setLevel(logging.CRITICAL)
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with ExitStack() as stack:

        def begun(*command: str) -> tuple[str, Callable[[int], None]]:
            return stack.enter_context(process(*command))

        hub, _ = begun(
            *(sys.executable, "-m", "rtgen", "can", "hub", "--port", "0"),
            *("--queue", "1000000"),
        )
        port = int(hub.rpartition(":")[2])
        begun(*own("echo", port))
        trip = stack.enter_context(bus_of(port, "trip"))
        begun(*own("echo_frames", port))
        link = link_of(port, "frames")
        stack.callback(link.close)
        tcp_port, _ = begun(*own("ping_pong"))
        tcp = stack.enter_context(socket.create_connection((HOST, int(tcp_port))))
        tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        _, flood_hub = begun(*own("flood", port))
        reader = stack.enter_context(connected(port, "flood"))
        time.sleep(0.1)
        text_port, flood_direct = begun(*own("serve_texts"))
        direct = stack.enter_context(bus_of(int(text_port), "direct"))
        near, far, sender, listener = (
            stack.enter_context(can.Bus(interface="virtual", channel=channel))
            for channel in ("trip", "trip", "flood", "flood")
        )
        threading.Thread(target=virtual_echo, args=(far,), daemon=True).start()

        trips = median_of(
            {
                "hub, rtgen": lambda: between_links(link),
                "hub, python-can": lambda: over_the_hub(trip),
                "TCP ping-pong": lambda: over_tcp(tcp),
                "virtual, a thread": lambda: over_the_hub(near),
            },
            rounds,
        )
        rates = median_of(
            {
                "hub, text only": lambda: as_text(reader, flood_hub),
                "no hub, python-can": lambda: by_python_can(direct, flood_direct),
                "virtual": lambda: by_python_can(
                    listener, lambda count: virtual_flood(sender, count)
                ),
            },
            rounds,
        )
        reader.close()
        bus = stack.enter_context(bus_of(port, "flood"))
        time.sleep(0.1)
        last = {"hub, python-can": lambda: by_python_can(bus, flood_hub)}
        rates |= median_of(last, rounds)
    columns = ("round trip [µs]", ".0f"), ("ratio to TCP", ".2f")
    table = results.table("trips", "way", *columns)
    for name, seconds in trips.items():
        table.add(name, seconds * 1e6, seconds / trips["TCP ping-pong"])
    columns = ("frames/s", ",.0f"), ("ratio to python-can without a hub", ".2f")
    table = results.table("frames", "way", *columns)
    for name, rate in rates.items():
        table.add(name, rate, rate / rates["no hub, python-can"])


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1] in PROGRAMS:
        PROGRAMS[sys.argv[1]](*map(int, sys.argv[2:]))
    else:
        with Results(
            __file__, chosen := Arguments(__doc__, rounds=9).parse_args()
        ) as r:
            main(r, chosen.rounds)
