"""Doors for CAN: SDO, PDO, EMCY, LSS, whole nodes, and the text protocols of hubs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from random import Random

import frames
from fuzzing import ViolationError

from doors import Door
from doors.definitions import of_target
from doors.mixing import mixing
from refrobots.motorcoreunit import DESCRIPTION as MOTOR
from rtgen.runtime.canopen.bus.hub_text import (
    Elements,
    Lines,
    Malformed,
    error_text,
    frame_text,
    received_error,
    received_frame,
    send_text,
    sent_frame,
    slcan_frame,
    slcan_text,
)
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire import lss_master, sdo
from rtgen.runtime.canopen.wire.emergency import (
    DEFAULT_STOPS,
    EmergencyPolicy,
    emergency_in,
)
from rtgen.runtime.canopen.wire.frames import (
    LSS_REQUEST,
    LSS_RESPONSE,
    MILLISECOND,
    Frame,
)
from rtgen.runtime.canopen.wire.lss import LssAddress, LssCommand
from rtgen.runtime.canopen.wire.lss_slave import LssSlave
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

NODE = 1
_MAX_ANSWERS = 300
"""Maximum number of frames in a response: a block of segments and other frames that may be due."""


def _messages(data: bytes, size: int = 8) -> Iterator[tuple[int, bytes]]:
    """Yield the messages; an octet before each has its length, and whether time passes."""
    for at in range(0, len(data), size + 1):
        yield data[at], data[at + 1 : at + 1 + size]


def _of_frames(
    can_ids: tuple[int, ...], chance: Random, heads: bytes = b"\0\0\0\1\x80"
) -> bytes:
    """Return messages of other stations with these identifiers."""
    parts: list[bytes] = []
    while len(parts) < 40 and (not parts or chance.random() < 0.95):
        strange = frames.strange(chance)
        if strange.frame.can_id in can_ids:
            head = bytes((chance.choice(heads),))
            parts.append(head + strange.frame.data.ljust(8, b"\0"))
    return b"".join(parts)


def _few(found: list[Frame]) -> list[Frame]:
    if len(found) > _MAX_ANSWERS:
        raise ViolationError(f"{len(found)} frames at once")
    return found


class _Objects:
    """Objects of any size; some numbers are refused."""

    def __init__(self) -> None:
        self.values: dict[tuple[int, int], bytes] = {}

    def read(self, index: int, subindex: int) -> bytes:
        if subindex == 0xFF:
            raise SdoAbort(sdo.WRITE_ONLY)
        default = bytes((index + subindex) % 2000)
        return self.values.get((index, subindex), default)

    def writable_size(self, index: int, subindex: int) -> int:
        if subindex == 0xFE:
            raise SdoAbort(sdo.READ_ONLY)
        return 4 if index % 2 else sdo.MAX_SIZE

    def write(self, index: int, subindex: int, value: bytes) -> None:
        if len(value) > self.writable_size(index, subindex):
            raise ViolationError(f"{len(value)} octets are written")
        self.values[index, subindex] = value


def _sdo_server(_folder: Path) -> Door:
    """Return the door for messages of a client; an odd octet before one means a time-out."""

    def enter(data: bytes) -> bool:
        objects = _Objects()
        server = SdoServer(NODE, objects)
        now, answered = 0, False
        for head, message in _messages(data):
            if head & 1:
                now += sdo.TIMEOUT
                _few(server.poll(now))
            size = 8 if head < 0x80 else head % 8
            frame = Frame(0x600 + NODE, message[:size])
            answers = _few(server.receive(frame, now))
            answered |= any(answer.data[0] != sdo.ABORT for answer in answers)
        return answered

    return Door(enter, partial(_of_frames, (0x600 + NODE,)))


def _sdo_client(_folder: Path) -> Door:
    """Return the door for messages of a server; the first octet selects the transfer."""

    def enter(data: bytes) -> bool:
        client = SdoClient(NODE, timeout=MILLISECOND)
        way = data[0] if data else 0
        block = bool(way & 2)
        if way & 1:
            _few(client.upload(0x2000, 1, 0, block=block))
        else:
            value = bytes(way * 4)
            _few(client.download(0x2000, 1, value, 0, block=block))
        now = 0
        for head, message in _messages(data[1:]):
            if head & 1:
                now += MILLISECOND
                _few(client.poll(now))
            if head & 4:
                message = message[:1] + b"\0\x20\1" + message[4:]
            size = 8 if head < 0x80 else head % 8
            _few(client.receive(Frame(0x580 + NODE, message[:size]), now))
        for _ in range(20):
            if client.deadline is None:
                break
            now = max(now, client.deadline)
            _few(client.poll(now))
        if client.busy or not client.ready:
            raise ViolationError("the transfer does not end")
        try:
            client.result()
        except SdoAbort:
            return False
        return True

    def make(chance: Random) -> bytes:
        return chance.randbytes(1) + _of_frames(
            (0x580 + NODE,), chance, b"\4\4\4\0\5\x80"
        )

    return Door(enter, make)


_PDOS = tuple(base + node for base in range(0x180, 0x580, 0x80) for node in (1, 2))


def _pdo(_folder: Path) -> Door:
    """Return the door for valid and invalid PDOs, for an operational node and for a decoder."""
    decoder = frames.Decoder(frames._known())

    def enter(data: bytes) -> bool:
        node = DeviceNode(MOTOR, NODE)
        list(node.boot(0))
        list(node.receive(Frame(0x000, b"\1\0"), 0))
        decoded = False
        for head, message in _messages(data):
            size = head >> 4 & 0xF
            frame = Frame(_PDOS[head % 16], message[: min(size, 8)])
            _few(list(node.receive(frame, 0)))
            found = decoder.decode(frame)
            str(found)
            found.to_json()
            decoded |= found.kind[1:4] == "pdo"
        return decoded

    def make(chance: Random) -> bytes:
        return b"".join(
            bytes((chance.choice((0x80, 0x80, 0x40, 0x10)) | chance.randrange(16),))
            + chance.randbytes(8)
            for _ in range(chance.randrange(1, 12))
        )

    return Door(enter, make)


def _emcy(_folder: Path) -> Door:
    policy = EmergencyPolicy(DEFAULT_STOPS)

    def enter(data: bytes) -> bool:
        if data[:1] == b"p":
            try:
                EmergencyPolicy(data[1:].decode("latin-1"))
            except ValueError:
                return False
            return True
        node_id = 1 + data[0] % 0x7F if data else 1
        frame = Frame(0x080 + node_id, data[1:9])
        emergency = emergency_in(frame)
        if emergency is None:
            return False
        policy.stops(emergency)
        str(emergency)
        if emergency.frame(node_id) != frame:
            raise ViolationError(f"{frame} became {emergency.frame(node_id)}")
        return True

    def make(chance: Random) -> bytes:
        if chance.random() < 0.1:
            parts = chance.choices(("xxxx", "-82xx", "23XX", "-", ",", "8", " "), k=4)
            return b"p" + ",".join(parts).encode()
        return chance.randbytes(chance.choice((1, 9, 9, 9, 8)))

    return Door(enter, make)


def _lss_slave(_folder: Path) -> Door:
    """Return the door for messages of a master; stored settings of the slave stay valid."""
    address = LssAddress(1, 2, 3, 4)

    def enter(data: bytes) -> bool:
        slave = LssSlave(lambda: address)
        answered = False
        for head, message in _messages(data):
            size = 8 if head < 0x80 else head % 8
            answered |= bool(_few(slave.receive(Frame(LSS_REQUEST, message[:size]))))
            if head & 1:
                slave.take_over(stored=bool(head & 2))
            if not (1 <= slave.active <= 127 or slave.active == 255):
                raise ViolationError(f"node-id {slave.active}")
        return answered

    return Door(enter, partial(_of_frames, (LSS_REQUEST,)))


def _lss_master(_folder: Path) -> Door:
    """Return the door for messages of slaves; every procedure ends, with a result or LssError."""
    wanted = (1, 2, None, None)

    def enter(data: bytes) -> bool:
        procedures = (
            lambda: lss_master.find(wanted),
            lambda: lss_master.assign(wanted, 5),
            lambda: lss_master.inquire(LssCommand.INQUIRE_NODE_ID),
            lambda: lss_master.store(),
            lambda: lss_master.set_bit_rate(wanted, 125),
        )
        master = lss_master.LssMaster()
        outcomes: list[object] = []
        procedure = procedures[(data[0] if data else 0) % len(procedures)]()
        master.submit(procedure, outcomes.append, 0)
        now = 0
        for head, message in _messages(data[1:]):
            answer = message
            if head & 4:
                # The answer of the slave with this address.
                answer = bytes((master._request.answer or 0,)) + message[1:]
            size = 8 if head < 0x80 else head % 8
            master.receive(Frame(LSS_RESPONSE, answer[:size]), now)
            if head & 1 and master.deadline is not None:
                now = max(now, master.deadline)
                master.poll(now)
        for _ in range(1000):
            if master.deadline is None:
                break
            now = max(now, master.deadline)
            master.poll(now)
        if len(outcomes) != 1:
            raise ViolationError(f"{len(outcomes)} outcomes")
        return not isinstance(outcomes[0], lss_master.LssError)

    def make(chance: Random) -> bytes:
        answers = (
            bytes(
                (
                    chance.choice((0, 1, 4, 5, 5, 4)),
                    chance.choice((0x4F, 0x44, 0x11, 0x13)),
                )
            )
            + chance.choice((bytes(7), b"\1" + bytes(6), chance.randbytes(7)))
            for _ in range(chance.randrange(1, 140))
        )
        return chance.randbytes(1) + b"".join(answers)

    return Door(enter, make)


_CLIENT = (b"< send 123 2 11 22 >", b"< open can0 >", b"< rawmode >", b"< echo >")
_HUB = (
    *(
        b"< frame 123 23.424242 1122 >",
        b"< error 004 23.424242 >",
        b"< hi >",
        b"< ok >",
    ),
    b"< frame 12345678 1.5 >",
)


def _socketcand(_folder: Path) -> Door:
    """Return the door for both ends of socketcand's protocol; parsed frames are written again."""

    def enter(data: bytes) -> bool:
        stream, read = Elements(), False
        # In two pieces, as a network may deliver them.
        for part in (data[: len(data) // 2], data[len(data) // 2 :]):
            stream.feed(part)
            while True:
                waiting = stream.waiting
                try:
                    words = stream.take()
                except Malformed:
                    if stream.waiting >= waiting:
                        raise ViolationError("nothing was dropped") from None
                    continue
                if words is None:
                    break
                read |= _element(words)
        return read

    return Door(enter, mixing([*_CLIENT, *_HUB, b"".join(_CLIENT), b"".join(_HUB)]))


def _words(text: bytes) -> str:
    """Return the content of the only element of a text."""
    stream = Elements()
    stream.feed(text)
    words = stream.take()
    if words is None or stream.waiting:
        raise ViolationError(f"{text!r} is not an element")
    return words


def _element(words: str) -> bool:
    for parse in (sent_frame, received_frame, received_error):
        try:
            found = parse(words)
        except Malformed:
            continue
        if isinstance(found, Frame):
            again: object = sent_frame(_words(send_text(found)))
        elif isinstance(found[0], Frame):
            text = frame_text(found[0], round(found[1] * 10**9))
            again = received_frame(_words(text))[0]
            found = found[0]
        else:
            text = error_text(found[0], round(found[1] * 10**9))
            again = received_error(_words(text))[0]
            found = found[0]
        if again != found:
            raise ViolationError(f"{found} became {again}")
        return True
    return False


def _slcan(_folder: Path) -> Door:
    def enter(data: bytes) -> bool:
        stream, read = Lines(), False
        stream.feed(data)
        while True:
            try:
                line = stream.take()
                if line is None:
                    return read
                frame = slcan_frame(line)
            except Malformed:
                continue
            read = True
            if slcan_frame(slcan_text(frame)[:-1].decode()) != frame:
                raise ViolationError(f"{frame} became another one")

    seeds = [
        b"t12321122\r",
        b"T1234567881122334455667788\r",
        b"r1230\rR000000018\rO\rS6\r",
    ]
    return Door(enter, mixing(seeds), seeds)


DOORS: dict[str, Callable[[Path], Door]] = {
    "sdo-server": _sdo_server,
    "sdo-client": _sdo_client,
    "pdo": _pdo,
    "emcy": _emcy,
    "lss-slave": _lss_slave,
    "lss-master": _lss_master,
    "node": lambda folder: of_target(frames.NodeTarget(folder)),
    "socketcand": _socketcand,
    "slcan": _slcan,
}
