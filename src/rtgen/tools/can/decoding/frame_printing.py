"""Prints decoded frames, as one line of text or of JSON each."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from rtgen.runtime.canopen.bus.messages import frame_of
from rtgen.tools.can.decoding.decoder import Decoded, Decoder
from rtgen.tools.can.decoding.node_index import NodeIndex
from rtgen.tools.can.parsing.candump import ERROR_FLAG
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.rpc.values import Json

if TYPE_CHECKING:
    from can import Message


KINDS = (
    "nmt", "heartbeat", "guarding", "emcy", "sync", "time", "tpdo", "rpdo", "sdo", "lss",
    "failsafe", "frame", "error frame", "no classical frame",
)  # fmt: skip
"""The kinds of frames; those of PDOs are followed by a number."""

_ERROR_CLASSES = {
    0x001: "transmission timed out",
    0x002: "arbitration lost",
    0x004: "controller problem",
    0x008: "protocol violation",
    0x010: "transceiver status",
    0x020: "no acknowledgement",
    0x040: "bus off",
    0x080: "bus error",
    0x100: "controller restarted",
}

Write: TypeAlias = Callable[[str], object]


class MessageDecoder:
    """Decodes python-can messages, including error frames and CAN FD."""

    def __init__(self, node_index: NodeIndex) -> None:
        self._decoder = Decoder(node_index)

    def decode(self, message: Message) -> Decoded:
        """Decode the next message."""
        if message.is_error_frame:
            return Decoded("error frame", None, "", _error_text(message))
        frame = frame_of(message)
        if frame is None:
            return Decoded("no classical frame", None, "", message.data.hex(" "))
        return self._decoder.decode(frame)


class Wanted:
    """A filter of frames by nodes and kinds; matches all frames by default."""

    def __init__(
        self, node_index: NodeIndex, nodes: tuple[str, ...], kinds: tuple[str, ...]
    ) -> None:
        self._nodes = frozenset(node_index.node(text) for text in nodes)
        self._kinds = tuple(kind.lower() for kind in kinds)
        for kind in self._kinds:
            if not any(
                known_kind.startswith(kind.rstrip("0123456789")) for known_kind in KINDS
            ):
                raise Refusal(
                    f"no frame is of kind {kind!r}; kinds are {', '.join(KINDS)}"
                )

    def __call__(self, decoded: Decoded) -> bool:
        """Return whether a frame matches; a command to all nodes matches each of them."""
        if self._nodes and decoded.node != 0 and decoded.node not in self._nodes:
            return False
        return not self._kinds or decoded.kind.startswith(self._kinds)


def _error_text(message: Message) -> str:
    """Return the classes of an error, if its frame has those of SocketCAN (linux/can/error.h)."""
    classes = message.arbitration_id
    return ", ".join(text for bit, text in _ERROR_CLASSES.items() if classes & bit)


def identifier(message: Message) -> str:
    """Return the CAN identifier as candump writes it: 3 or 8 hexadecimal digits."""
    if message.is_error_frame:
        return f"{message.arbitration_id | ERROR_FLAG:08X}"
    digits = 8 if message.is_extended_id else 3
    return f"{message.arbitration_id:0{digits}X}"


class Printer:
    """Prints frames as they arrive, as lines of text or of JSON.

    Text has times in seconds since the first frame, JSON the time stamps of the bus or the log.
    """

    def __init__(
        self, node_index: NodeIndex, selection: Wanted, *, as_json: bool, write: Write
    ) -> None:
        self._decoder = MessageDecoder(node_index)
        self._selection = selection
        self._line = _json_line if as_json else self._text_line
        self._write = write
        self._start: float | None = None

    def take(self, message: Message) -> None:
        """Print a frame if it matches the filter."""
        if self._start is None:
            self._start = message.timestamp
        decoded = self._decoder.decode(message)
        if self._selection(decoded):
            self._write(f"{self._line(message, decoded)}\n")

    def _text_line(self, message: Message, decoded: Decoded) -> str:
        assert self._start is not None
        moment = message.timestamp - self._start
        data = "remote" if message.is_remote_frame else message.data.hex(" ")
        return (
            f"{moment:11.6f}  {identifier(message):>8}  {data:<23}  {decoded}".rstrip()
        )


def _json_line(message: Message, decoded: Decoded) -> str:
    frame: dict[str, Json] = {
        "time": round(message.timestamp, 6),
        "id": identifier(message),
    }
    if message.is_remote_frame:
        frame["remote"] = True
    else:
        frame["data"] = message.data.hex()
    return json.dumps(frame | decoded.to_json())
