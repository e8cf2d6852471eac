"""Floods of requests from outside during a run in real time, beside a run without.

    python benchmarks/floods.py [--seconds S] [KIND...]

A system with components of 1 kHz behind `rtgen ui`, Foxglove's server, remote control over Zenoh,
or CORBA; clients in processes of their own that send as fast as they are answered or their requests
taken; and an operator, with full rights on the page, who deactivates a component now and then. Each
row has the ticks of a component of 1 kHz per second, their part of those of the control before it,
the longest time between two ticks, the longest answer to `deactivate`, and the messages that the
clients got.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from socket import create_connection, socket
from typing import Any, NamedTuple

from tables import Arguments, Results

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [
    str(ROOT / each) for each in ("benchmarks", "generated", "src", "tests")
]

from websockets.sync.client import connect  # noqa: E402

from rtgen import runtime  # noqa: E402
from rtgen.ui.protocol import ui  # noqa: E402

SYSTEM = ROOT / "specs/navigation/rh3_goal.xml"
INSTANCE, PORT, STEERED = "PathFollower0", "velocity", "Odometry0"
WARM_UP = 1.0
_PORT = ui.PortAddress(INSTANCE, PORT)
_CALL = ui.Call(ui.PortAddress("RefHardRh30", "InventGUIRefHard"), "RefHard", "Stop")

KINDS: dict[str, ui.Command | bytes | None] = {
    "ends": ui.Command.of_ends(_PORT),
    "look": ui.Command.of_looked(0.5),
    "live": ui.Command.of_looked(-1.0),
    "watch": ui.Command.of_channels([*range(1, 100)]),
    "watch 1e5": ui.Command.of_channels([*range(100_000)]),
    "refused": ui.Command.of_deactivated([]),
    "garbage": b"\xff" * 100,
    "large": b"\xff" * (3 << 20),
    "calls": ui.Command.of_called(_CALL),
    "join": None,
}
"""What clients send; None: they open and close sockets."""
OTHERS = (
    "foxglove parameters",
    "foxglove calls",
    "foxglove unread",
    "foxglove subscriptions",
    "foxglove garbage",
    "foxglove joins",
    "can frames",
    "ctl state",
    "ctl describe",
    "zenoh calls",
    "corba profile",
    "corba state",
    "corba calls",
)
"""Kinds whose doors `flood_doors` has."""
_FULL = ("calls",)
"""Kinds that need full rights."""


def flood(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Send requests as fast as they are taken, in a process of its own."""
    command = KINDS[kind]
    host, _, path = address.removeprefix("ws://").partition("/")
    place = host.partition(":")
    opening = (
        f"GET /{path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    ).encode()
    while not end.is_set():
        with suppress(OSError), create_connection((place[0], int(place[2]))) as raw:
            raw.sendall(opening)
            raw.recv(1 << 16)
            ready.set()
            if command is None:
                answers.value += 1
                continue
            data = command
            if not isinstance(command, bytes):
                data = ui.ClientMessage(request=1, asked=command).to_cdr()
            frames = frame(data) * max(1, (1 << 16) // len(data))
            reader = threading.Thread(target=count, args=(raw, answers), daemon=True)
            reader.start()
            while not end.is_set():
                raw.sendall(frames)


def frame(data: bytes) -> bytes:
    """Return a frame of a client, masked by zeros (RFC 6455, 5.2)."""
    if len(data) < 126:
        head = struct.pack(">BB", 0x82, 0x80 | len(data))
    elif len(data) < 1 << 16:
        head = struct.pack(">BBH", 0x82, 0xFE, len(data))
    else:
        head = struct.pack(">BBQ", 0x82, 0xFF, len(data))
    return head + bytes(4) + data


def count(raw: socket, answers: Any) -> None:
    """Read and count the frames of the server."""
    with suppress(OSError), raw.makefile("rb") as stream:
        while head := stream.read(2):
            length = head[1]
            if length == 126:
                length = int.from_bytes(stream.read(2), "big")
            elif length == 127:
                length = int.from_bytes(stream.read(8), "big")
            stream.read(length)
            answers.value += 1


def operate(address: str, ready: Any, end: Any, longest: Any, refused: Any) -> None:
    """Deactivate and activate a component as an operator, in a process of its own."""
    with connect(address, max_size=None) as page:
        answer = _answers(page)
        number = 0
        while not end.wait(0.3):
            for branch in ("deactivated", "activated"):
                number += 1
                asked = getattr(ui.Command, f"of_{branch}")([STEERED])
                begun = time.perf_counter()
                page.send(ui.ClientMessage(request=number, asked=asked).to_cdr())
                result = answer(number)
                passed = time.perf_counter() - begun
                if branch == "deactivated":
                    longest.value = max(longest.value, passed)
                if not result.done and "wait" in result.message:
                    refused.value += 1
                time.sleep(0.05)
            if number > 4:
                ready.set()


def _answers(page: Any) -> Callable[[int], ui.Result]:
    def answer(number: int) -> ui.Result:
        while True:
            message = ui.ServerMessage.from_cdr(page.recv(60))
            for event in message.events:
                is_result = event.discriminator is ui.EventKind.EVENT_RESULT
                if is_result and event.outcome.request == number:
                    return event.outcome

    return answer


class Gaps:
    """The times of the ticks of a component."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Begin to measure."""
        self.ticks = 0
        self.longest = 0.0
        self._last = self._begun = time.perf_counter()

    def tick(self, _: object = None) -> None:
        """Enter a tick."""
        now = time.perf_counter()
        self.longest = max(self.longest, now - self._last)
        self.ticks += 1
        self._last = now

    @property
    def rate(self) -> float:
        """The ticks per second."""
        return self.ticks / (time.perf_counter() - self._begun)


@contextmanager
def served() -> Iterator[tuple[Callable[[bool], str], Gaps]]:
    """Run the system behind a server; yield its addresses, by whether they give full rights."""
    from rtgen.tools.kit.console import Console
    from rtgen.ui.project_systems import CommandProject
    from rtgen.ui.serving import Server
    from rtgen.ui.session import Session

    console = Console("text", False, True)
    session = Session(
        CommandProject(console, [str(SYSTEM)]), str(SYSTEM), runtime.RealClock
    )
    gaps = Gaps()
    session.system.watch_port(INSTANCE, PORT, gaps.tick)
    server = Server(session, "127.0.0.1", 0)
    ready = threading.Event()
    serving = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    serving.start()
    ready.wait()
    session.runner.submit(session.runner.play)

    def address(full: bool) -> str:
        found = server.address(full=full).replace("http:", "ws:")
        return str(found.replace("/?", "/socket?"))

    try:
        yield address, gaps
    finally:
        server.stop()
        serving.join()


class Door(NamedTuple):
    """A place where requests enter: a system behind it, clients that flood it, an operator."""

    served: Callable[[], AbstractContextManager[tuple[Callable[[bool], str], Gaps]]]
    flood: Callable[..., None]
    operate: Callable[..., None]


def door_of(kind: str) -> Door:
    """Return the door of a kind of flood."""
    if kind in KINDS:
        return Door(served, flood, operate)
    import flood_doors

    return flood_doors.DOORS[kind]


def measure(kind: str, clients: int, seconds: float) -> dict[str, Any]:
    """Return the figures of a run with these clients; without any if `clients` is 0."""
    spawning = multiprocessing.get_context("spawn")
    door = door_of(kind)
    with door.served() as (address, gaps):
        end, longest = spawning.Event(), spawning.Value("d", 0.0)
        refused = spawning.Value("i", 0)
        answers = [spawning.Value("i", 0) for _ in range(clients)]
        begun, *readies = [spawning.Event() for _ in range(1 + clients)]
        processes = [
            spawning.Process(
                target=door.operate,
                args=(address(True), begun, end, longest, refused),
            ),
            *(
                spawning.Process(
                    target=door.flood,
                    args=(address(kind in _FULL), kind, ready, end, answer),
                )
                for ready, answer in zip(readies, answers, strict=True)
            ),
        ]
        for process in processes:
            process.start()
        for ready in (begun, *readies):
            ready.wait(30)
        time.sleep(WARM_UP)
        longest.value = 0.0
        gaps.begin()
        time.sleep(seconds)
        row = {
            "rate": gaps.rate,
            "longest": gaps.longest,
            "deactivate": longest.value,
            "refused": refused.value,
            "answers": sum(answer.value for answer in answers),
        }
        end.set()
        processes[0].join(10)
        for process in processes:
            process.terminate()  # it may wait for the server to read
            process.join()
    return row


def main() -> None:
    """Print a row for each kind and number of clients, each beside its control."""
    parser = Arguments(__doc__, rounds=1)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("kinds", nargs="*")
    chosen = parser.parse_args()
    kinds = chosen.kinds or [*KINDS, *OTHERS]
    if chosen.smallest:
        kinds, chosen.seconds = kinds[:1], 0.5
    with Results(__file__, chosen) as results:
        table = results.table(
            "floods",
            "flood, clients",
            ("ticks/s", ".0f"),
            ("control", ".0f"),
            ("part", ".2f"),
            ("longest gap [ms]", ".0f"),
            ("control [ms]", ".0f"),
            ("deactivate [ms]", ".0f"),
            ("control [ms]", ".0f"),
            ("refused", ",d"),
            ("answers/s", ",.0f"),
        )
        for kind in kinds:
            for clients in (1,) if chosen.smallest else (1, 4):
                control = measure(kind, 0, chosen.seconds)
                found = measure(kind, clients, chosen.seconds)
                pairs = [
                    1e3 * each[key]
                    for key in ("longest", "deactivate")
                    for each in (found, control)
                ]
                rates = found["rate"], control["rate"], found["rate"] / control["rate"]
                answers = found["answers"] / chosen.seconds
                title = f"{kind}, {clients}"
                table.add(title, *rates, *pairs, found["refused"], answers)


if __name__ == "__main__":
    main()
