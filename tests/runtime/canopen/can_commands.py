"""Runs commands of `rtgen can` on a bus in this process."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import can
from can.interfaces.virtual import channels
from patience import PATIENCE

from rtgen.cli import run


def on(channel: str) -> list[str]:
    """Return the options for the virtual bus of a channel."""
    return ["--interface", "virtual", "--channel", channel]


def command(channel: str, *arguments: str) -> int:
    """Run `rtgen can ...` on a channel and return its exit code."""
    return run(["can", *arguments, *on(channel)])


@contextmanager
def bus(channel: str) -> Iterator[can.BusABC]:
    """Yield a peer on the channel."""
    with can.Bus(interface="virtual", channel=channel) as made:
        yield made


def listeners(channel: str) -> int:
    """Return the number of listeners on the channel."""
    return len(channels.get(channel, ()))


@contextmanager
def meanwhile(action: Callable[[], None]) -> Iterator[None]:
    """Run an action in a thread during the block; its exception is raised at the end."""
    failures: list[BaseException] = []

    def do() -> None:
        try:
            action()
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=do)
    thread.start()
    try:
        yield
    finally:
        thread.join(PATIENCE)
    assert not failures, failures
    assert not thread.is_alive()


def messages(*frames: str, start: float = 1_700_000_000.0) -> list[can.Message]:
    """Return messages of `ID#HEX` or `ID#R`, a hundredth of a second between them."""
    found = []
    for place, text in enumerate(frames):
        identifier, _, data = text.partition("#")
        remote = data == "R"
        found.append(
            can.Message(
                timestamp=round(start + place / 100, 6),
                arbitration_id=int(identifier, 16),
                is_extended_id=len(identifier) > 3,
                is_remote_frame=remote,
                data=None if remote else bytes.fromhex(data),
                channel=0,
            )
        )
    return found


def texts(found: list[can.Message]) -> list[str]:
    """Return messages as `ID#HEX`."""
    return [
        f"{m.arbitration_id:0{8 if m.is_extended_id else 3}X}#"
        + ("R" if m.is_remote_frame else m.data.hex())
        for m in found
    ]


def received(peer: can.BusABC, count: int) -> list[can.Message]:
    """Return the next messages of a bus."""
    found: list[can.Message] = []
    end = time.monotonic() + PATIENCE
    while len(found) < count and time.monotonic() < end:
        message = peer.recv(0.1)
        found += [message] if message is not None else []
    return found
