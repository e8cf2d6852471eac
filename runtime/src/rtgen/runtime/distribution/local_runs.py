"""Runs of this machine that programs of the same user find: sockets, and their messages.

A message is a length of four octets, big-endian, and a `msgspec` struct as MessagePack. The run
begins with `Hello`.
"""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec

from rtgen.facts.messages import from_msgpack
from rtgen.runtime.system.latency import Latency
from rtgen.runtime.timing.traffic import BoardCall, BusFrame

MAX_CLIENTS: Final = 8
MESSAGES: Final = 2
"""Version of the messages; programs attach to runs that have the same one."""
FOLDER: Final = "RTGEN_RUN_DIR"
"""The environment variable that names the folder."""
SUFFIX: Final = ".sock"
MAX_LENGTH: Final = 64 << 20
"""Maximum length of a message [octets]; samples such as clouds of points fit."""
_LENGTH: Final = 4
_PATIENCE: Final = 2.0
"""Time in which a run sends its `Hello` [s]."""
_T = TypeVar("_T")


class Planned(msgspec.Struct, frozen=True):
    """An event of the timeline at a time [ns]; ends of a connection to be made, else empty."""

    time: int
    kind: str
    text: str
    source: tuple[str, str] = ("", "")
    target: tuple[str, str] = ("", "")


class Hello(msgspec.Struct, frozen=True, tag="hello"):
    """What a run says of itself: system, RtsProfile, command line, and time of its start.

    `time` is in seconds since 1970, `plan` the timeline in order, `doc` what the system is. A run
    that serves as many programs as it can is `full`, and hangs up. Members are added only, with
    defaults, so that runs of other versions are listed.
    """

    name: str
    pid: int
    file: str
    command: str
    simulated: bool
    time: float
    version: str = ""
    """Of rtgen."""
    messages: int = 0
    """See `MESSAGES`."""
    plan: tuple[Planned, ...] = ()
    doc: str = ""
    full: bool = False


class Ask(msgspec.Struct, frozen=True, tag="ask"):
    """A request to the control service of an instance (`control`); answered by `Answer`."""

    id: int
    instance: str
    octets: bytes


class Listen(msgspec.Struct, frozen=True, tag="listen"):
    """Begins or ends to send the samples of an OutPort."""

    instance: str
    port: str
    on: bool


class Give(msgspec.Struct, frozen=True, tag="give"):
    """A sample for an InPort; answered by `Answer` with the reason of a refusal."""

    id: int
    instance: str
    port: str
    octets: bytes


class Do(msgspec.Struct, frozen=True, tag="do"):
    """A request to the program that runs the system; answered by a `Done` in an `Answer`."""

    id: int
    what: str
    octets: bytes


class Done(msgspec.Struct, frozen=True):
    """The outcome of a `Do`: an error, or octets."""

    error: str = ""
    octets: bytes = b""


class Answer(msgspec.Struct, frozen=True, tag="answer"):
    """The answer to the request of a number."""

    id: int
    octets: bytes


class Value(msgspec.Struct, frozen=True, tag="value"):
    """A sample of an OutPort; `time` in ns since the start."""

    instance: str
    port: str
    time: int
    octets: bytes


class Changed(msgspec.Struct, frozen=True, tag="changed"):
    """A component has changed its state at a time [ns]; see `records.StateRecord`."""

    time: int
    instance: str
    ec_id: int
    before: str
    after: str
    reason: str


class OnBus(msgspec.Struct, frozen=True, tag="frame"):
    """A frame on a bus at a time [ns]."""

    time: int
    frame: BusFrame


class OnBoard(msgspec.Struct, frozen=True, tag="call"):
    """A call to a board, at a time [ns]."""

    time: int
    call: BoardCall


class Noted(msgspec.Struct, frozen=True, tag="noted"):
    """What else has happened, at a time [ns]."""

    time: int
    kind: str
    instance: str
    text: str


class Wire(msgspec.Struct, frozen=True):
    """A connection; samples that its OutPort writes in a second of the run, and lost ones.

    `rate` is negative while it is not known, and for services.
    """

    name: str
    source: tuple[str, str]
    target: tuple[str, str]
    properties: dict[str, str]
    rate: float
    losses: dict[str, int]


class Status(msgspec.Struct, frozen=True, tag="status"):
    """The state of the run; None: as before. `dropped` samples, frames and calls were not sent."""

    time: int
    instances: list[str] | None
    wires: list[Wire] | None
    dropped: int
    chains: list[Latency] | None = None


class End(msgspec.Struct, frozen=True, tag="end"):
    """The run is over at a time [ns], for a reason."""

    time: int
    reason: str


Request = Ask | Listen | Give | Do
Event = Changed | OnBus | OnBoard | Noted
Report = Hello | Answer | Value | Status | End | Changed | OnBus | OnBoard | Noted


def folder() -> Path:
    """Return the folder of the sockets, which only the user can enter. Raises OSError."""
    named = os.environ.get(FOLDER)
    own = os.environ.get("XDG_RUNTIME_DIR")
    if named:
        path = Path(named)
    elif own:
        path = Path(own, "rtgen")
    else:
        import tempfile  # it takes time to load

        path = Path(tempfile.gettempdir(), f"rtgen-{os.getuid()}")
    with suppress(FileExistsError):
        path.mkdir(mode=0o700)
    status = path.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        raise OSError(f"{path} is not a folder of this user")
    if status.st_mode & 0o077:
        raise OSError(f"{path} can be read by other users: chmod 700 {path}")
    return path


def is_supported() -> bool:
    """Return whether this machine has sockets that one user alone can open."""
    return hasattr(socket, "AF_UNIX") and hasattr(os, "getuid")


def runs() -> list[tuple[Path, Hello]]:
    """Return the sockets of all runs with what they say, the latest first. Raises OSError."""
    found = [(path, hello) for path, hello in _greetings() if hello is not None]
    return sorted(found, key=lambda each: each[1].time, reverse=True)


def _greetings() -> Iterator[tuple[Path, Hello | None]]:
    for path in sorted(folder().glob(f"*{SUFFIX}")):
        try:
            stream, hello = connect(path)
        except ConnectionRefusedError:
            # The process has been killed.
            with suppress(OSError):
                path.unlink()
        except OSError:
            continue  # It is ending, or starting.
        else:
            stream.close()
            yield path, hello


def connect(path: Path) -> tuple[socket.socket, Hello]:
    """Connect to a run. Raises OSError."""
    stream = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        stream.settimeout(_PATIENCE)
        stream.connect(str(path))
        hello = receive(stream, Hello)
        if hello is None:
            raise ConnectionResetError(f"{path}: the run has ended")
        stream.settimeout(None)
    except (TimeoutError, ValueError) as error:
        stream.close()
        raise OSError(f"{path}: no answer: {error}") from error
    except OSError:
        stream.close()
        raise
    return stream, hello


def packed(message: Any) -> bytes:
    """Return a message with its length. Raises ValueError if it is too long."""
    data = msgspec.msgpack.encode(message)
    if len(data) > MAX_LENGTH:
        raise ValueError(
            f"a message of {len(data)} octets; at most {MAX_LENGTH} are sent"
        )
    return len(data).to_bytes(_LENGTH, "big") + data


def receive(stream: socket.socket, type_: type[_T] | Any) -> _T | None:
    """Return the next message; None at the end. Raises OSError, ValueError for another one."""
    head = _octets(stream, _LENGTH)
    if head is None:
        return None
    length = int.from_bytes(head, "big")
    if length > MAX_LENGTH:
        raise ValueError(f"a message of {length} octets")
    data = _octets(stream, length)
    if data is None:
        return None
    message: _T = from_msgpack(data, type_)
    return message


def _octets(stream: socket.socket, length: int) -> bytes | None:
    parts = []
    while length:
        part = stream.recv(min(length, 1 << 16))
        if not part:
            return None
        parts.append(part)
        length -= len(part)
    return b"".join(parts)
