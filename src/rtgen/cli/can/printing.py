"""Decoded frames as they are printed: a line of text or of JSON for each."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from rtgen.cli.can.decoding import Decoded, Decoder
from rtgen.cli.can.known import KnownBus
from rtgen.cli.common import Refusal
from rtgen.cli.rpc.values import Json
from rtgen.runtime.canopen.python_can import frame_of

if TYPE_CHECKING:
    from can import Message


KINDS = (
    "nmt", "heartbeat", "guarding", "emcy", "sync", "time", "tpdo", "rpdo", "sdo", "lss",
    "failsafe", "frame", "error frame", "no classical frame",
)  # fmt: skip
"""The kinds of frames; PDOs have their number behind."""

Write: TypeAlias = Callable[[str], object]


class MessageDecoder:
    """Decodes python-can messages, of which some are not CANopen's frames."""

    def __init__(self, known: KnownBus) -> None:
        self._decoder = Decoder(known)

    def decode(self, message: Message) -> Decoded:
        """The message in words."""
        if message.is_error_frame:
            return Decoded("error frame", None, "", "")
        frame = frame_of(message)
        if frame is None:
            return Decoded("no classical frame", None, "", message.data.hex(" "))
        return self._decoder.decode(frame)


class Wanted:
    """Which frames are of interest: those of some nodes, and of some kinds; by default all."""

    def __init__(
        self, known: KnownBus, nodes: tuple[str, ...], kinds: tuple[str, ...]
    ) -> None:
        self._nodes = frozenset(known.node(text) for text in nodes)
        self._kinds = tuple(kind.lower() for kind in kinds)
        for kind in self._kinds:
            if not any(
                known_kind.startswith(kind.rstrip("0123456789")) for known_kind in KINDS
            ):
                raise Refusal(
                    f"no frame is of kind {kind!r}; kinds are {', '.join(KINDS)}"
                )

    def __call__(self, told: Decoded) -> bool:
        """Whether a frame is; a command to all nodes is one to each of them."""
        if self._nodes and told.node != 0 and told.node not in self._nodes:
            return False
        return not self._kinds or told.kind.startswith(self._kinds)


def identifier(message: Message) -> str:
    """The CAN identifier as candump writes it: 3 or 8 hexadecimal digits."""
    digits = 8 if message.is_extended_id else 3
    return f"{message.arbitration_id:0{digits}X}"


class Printer:
    """Prints frames as they come: lines of text, or of JSON.

    Times in text are in seconds since the first frame, those in JSON as the bus or the record has
    them.
    """

    def __init__(
        self, known: KnownBus, wanted: Wanted, *, as_json: bool, write: Write
    ) -> None:
        self._decoder = MessageDecoder(known)
        self._wanted = wanted
        self._line = _json_line if as_json else self._text_line
        self._write = write
        self._start: float | None = None

    def take(self, message: Message) -> None:
        """Prints a frame, if it is wanted."""
        if self._start is None:
            self._start = message.timestamp
        told = self._decoder.decode(message)
        if self._wanted(told):
            self._write(f"{self._line(message, told)}\n")

    def _text_line(self, message: Message, told: Decoded) -> str:
        assert self._start is not None
        moment = message.timestamp - self._start
        data = "remote" if message.is_remote_frame else message.data.hex(" ")
        return f"{moment:11.6f}  {identifier(message):>8}  {data:<23}  {told}".rstrip()


def _json_line(message: Message, told: Decoded) -> str:
    frame: dict[str, Json] = {
        "time": round(message.timestamp, 6),
        "id": identifier(message),
    }
    if message.is_remote_frame:
        frame["remote"] = True
    else:
        frame["data"] = message.data.hex()
    return json.dumps(frame | told.to_json())
