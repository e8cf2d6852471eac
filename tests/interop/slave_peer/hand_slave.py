"""A hand-written CANopen slave, of struct and python-can alone, without rtgen and `canopen`.

    python canopen_slave_peer.py NODE INTERFACE CHANNEL [KEY=VALUE...]

It knows NMT, boot-up, heartbeat (1017h), EMCY, and an SDO server for expedited, segmented and block
transfers with CRC. Its PDOs are these:

  TPDO 1: counter UNSIGNED32 (2001h), position INTEGER32 (2002h)
  RPDO 1: target INTEGER32 (2003h), mode UNSIGNED8 (2004h)

The position is the last target. TPDO 1 is sent at every SYNC (type 1) or by the event timer.
Further objects: 2000h is a DOMAIN of up to 100,000 octets, a write of 2005h sends an EMCY of that
code, 1 in 2006h makes the node mute from then on.
"""

from __future__ import annotations

import struct
import sys
import time

import can

INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
NO_OBJECT, NO_SUB = 0x06020000, 0x06090011
READ_ONLY, WRITE_ONLY, LENGTH = 0x06010002, 0x06010001, 0x06070010
TOGGLE, COMMAND, CRC, SEQUENCE = 0x05030000, 0x05040001, 0x05040004, 0x05040003
TOO_LONG, MEMORY = 0x06070012, 0x05040005
INVALID = 1 << 31
MAX_OCTETS = 100_000


class Abort(Exception):  # noqa: N818
    """The transfer is aborted."""


def crc16(data: bytes) -> int:
    """Return the CRC (CCITT), computed bit by bit."""
    register = 0
    for octet in data:
        register ^= octet << 8
        for _ in range(8):
            carry = register & 0x8000
            register = register << 1 & 0xFFFF
            if carry:
                register ^= 0x1021
    return register


def table(node: int) -> dict[tuple[int, int], list]:
    """Return the objects by index and sub-index: access, struct format ("" for octets), value."""
    return {
        (0x1000, 0): ["ro", "<I", 0x00000191],
        (0x1001, 0): ["ro", "<B", 0],
        (0x1008, 0): ["const", "", b"A slave that was written by hand"],
        (0x1017, 0): ["rw", "<H", 0],
        (0x1018, 0): ["const", "<B", 4],
        (0x1018, 1): ["ro", "<I", 0x00FFFF02],
        (0x1018, 2): ["ro", "<I", 0x00C0FFEE],
        (0x1018, 3): ["ro", "<I", 0x00010003],
        (0x1018, 4): ["ro", "<I", 4711],
        (0x1400, 0): ["const", "<B", 2],
        (0x1400, 1): ["rw", "<I", 0x200 + node],
        (0x1400, 2): ["rw", "<B", 255],
        (0x1600, 0): ["const", "<B", 2],
        (0x1600, 1): ["const", "<I", 0x20030020],
        (0x1600, 2): ["const", "<I", 0x20040008],
        (0x1800, 0): ["const", "<B", 5],
        (0x1800, 1): ["rw", "<I", 0x40000180 + node],
        (0x1800, 2): ["rw", "<B", 255],
        (0x1800, 3): ["rw", "<H", 0],
        (0x1800, 5): ["rw", "<H", 50],
        (0x1A00, 0): ["const", "<B", 2],
        (0x1A00, 1): ["const", "<I", 0x20010020],
        (0x1A00, 2): ["const", "<I", 0x20020020],
        (0x2000, 0): ["rw", "", b"nothing"],
        (0x2001, 0): ["ro", "<I", 0],
        (0x2002, 0): ["ro", "<i", 0],
        (0x2003, 0): ["rw", "<i", 0],
        (0x2004, 0): ["rw", "<B", 0],
        (0x2005, 0): ["wo", "<H", 0],
        (0x2006, 0): ["rw", "<B", 0],
    }


class Slave:
    def __init__(self, bus: can.BusABC, node: int) -> None:
        self.bus, self.node = bus, node
        self.state = INITIALISING
        self.objects = table(node)
        self.next_beat: float | None = None
        self.next_pdo: float | None = None
        self.transfer = None
        self.target = bytes(3)
        self.in_segments = False
        """Whether segments of a block are being received, whose first octet may be anything."""

    # The bus

    def send(self, can_id: int, data: bytes) -> None:
        if not self.number(0x2006):
            self.bus.send(
                can.Message(arbitration_id=can_id, data=data, is_extended_id=False)
            )

    def run(self) -> None:
        self.reset()
        while True:
            self.step()

    def step(self) -> None:
        """Process a frame if there is one, and run what is due."""
        due = [when for when in (self.next_beat, self.next_pdo) if when is not None]
        wait = min([0.05, *(when - time.monotonic() for when in due)])
        message = self.bus.recv(max(0.0, wait))
        if message is not None and not message.is_error_frame:
            self.take(message)
        self.tick()

    def tick(self) -> None:
        now = time.monotonic()
        if self.next_beat is not None and now >= self.next_beat:
            self.next_beat = now + self.number(0x1017) / 1000
            self.send(0x700 + self.node, bytes((self.state,)))
        if self.next_pdo is not None and now >= self.next_pdo:
            self.next_pdo = now + self.number(0x1800, 5) / 1000
            self.send_pdo()

    def take(self, message: can.Message) -> None:
        can_id, data = message.arbitration_id, bytes(message.data)
        if message.is_extended_id or message.is_remote_frame:
            return
        if can_id == 0 and len(data) == 2 and data[1] in (0, self.node):
            self.obey(data[0])
        elif can_id == 0x600 + self.node and len(data) == 8:
            if self.state in (OPERATIONAL, PRE_OPERATIONAL):
                self.serve(data)
        elif self.state == OPERATIONAL:
            if can_id == 0x80 and self.number(0x1800, 2) == 1:
                self.send_pdo()
            elif can_id == self.number(0x1400, 1) and len(data) >= 5:
                self.set(0x2003, struct.unpack_from("<i", data)[0])
                self.set(0x2004, data[4])
                self.set(0x2002, self.number(0x2003))

    # NMT

    def obey(self, command: int) -> None:
        if command in (0x81, 0x82):
            self.reset(keep=0x2000 if command == 0x82 else 0)
        elif command in (1, 2, 0x80):
            self.enter({1: OPERATIONAL, 2: STOPPED, 0x80: PRE_OPERATIONAL}[command])

    def reset(self, keep: int = 0) -> None:
        """Reset to the defaults; those of the application only if `keep` is not set."""
        fresh = table(self.node)
        for number, entry in self.objects.items():
            if keep and number[0] >= keep:
                fresh[number] = entry
        self.objects, self.transfer = fresh, None
        self.next_beat = None
        self.send(0x700 + self.node, b"\0")
        self.enter(PRE_OPERATIONAL)

    def enter(self, state: int) -> None:
        self.state = state
        self.transfer = None
        self.settle()

    def settle(self) -> None:
        """Set the timers by the objects and the state."""
        now = time.monotonic()
        beat = self.number(0x1017) / 1000
        self.next_beat = now + beat if beat else None
        event = self.number(0x1800, 5) / 1000
        timed = self.number(0x1800, 2) >= 254 and event > 0
        self.next_pdo = now if timed and self.state == OPERATIONAL else None

    def send_pdo(self) -> None:
        cob_id = self.number(0x1800, 1)
        if cob_id & INVALID:
            return
        self.set(0x2001, (self.number(0x2001) + 1) & 0xFFFFFFFF)
        data = struct.pack("<Ii", self.number(0x2001), self.number(0x2002))
        self.send(cob_id & 0x7FF, data)

    # Objects

    def number(self, index: int, sub: int = 0) -> int:
        return self.objects[index, sub][2]

    def set(self, index: int, value: int) -> None:
        self.objects[index, 0][2] = value

    def entry(self, index: int, sub: int) -> list:
        found = self.objects.get((index, sub))
        if found is None:
            known = any(other == index for other, _ in self.objects)
            raise Abort(NO_SUB if known else NO_OBJECT)
        return found

    def read(self, index: int, sub: int) -> bytes:
        access, form, value = self.entry(index, sub)
        if access == "wo":
            raise Abort(WRITE_ONLY)
        return struct.pack(form, value) if form else value

    def check(self, index: int, sub: int, size: int | None) -> None:
        access, form, _ = self.entry(index, sub)
        if access in ("ro", "const"):
            raise Abort(READ_ONLY)
        if size is not None and form and size != struct.calcsize(form):
            raise Abort(LENGTH)
        if size is not None and size > MAX_OCTETS:
            raise Abort(MEMORY)

    def write(self, index: int, sub: int, value: bytes) -> None:
        self.check(index, sub, len(value))
        entry = self.entry(index, sub)
        entry[2] = struct.unpack(entry[1], value)[0] if entry[1] else value
        if index == 0x2005:
            code = struct.pack("<HB", entry[2], 1 if entry[2] else 0)
            self.send(0x80 + self.node, code + bytes(5))
        if index in (0x1017, 0x1800):
            self.settle()

    # SDO. A transfer is a generator: it yields answers and gets the next request.

    def serve(self, data: bytes) -> None:
        command = data[0]
        if command == 0x80:
            self.transfer = None
            return
        in_blocks = command & 0xE1 == 0xC0 or command & 0xE3 == 0xA0
        begins = command >> 5 in (1, 2) or in_blocks
        if begins and not (self.transfer is not None and self.in_segments):
            self.transfer = self.begin(data)
            request = None
        elif self.transfer is None:
            self.abort(data[1:4], COMMAND)
            return
        else:
            request = data
        if request is None:
            self.target = data[1:4]
        try:
            answers = self.transfer.send(request)
        except StopIteration as end:
            answers, self.transfer = end.value, None
        except Abort as abort:
            self.transfer = None
            self.abort(self.target, abort.args[0])
            return
        for answer in answers:
            self.send(0x580 + self.node, answer.ljust(8, b"\0"))

    def abort(self, target: bytes, code: int) -> None:
        answer = b"\x80" + target + struct.pack("<I", code)
        self.send(0x580 + self.node, answer)

    def begin(self, data: bytes):
        self.in_segments = False
        command, index, sub = struct.unpack_from("<BHB", data)
        head = data[1:4]
        if command >> 5 == 2:
            return self.upload(index, sub, head)
        if command >> 5 == 1:
            return self.download(command, index, sub, head, data)
        if command & 0xE0 == 0xC0:
            return self.block_download(command, index, sub, head, data)
        return self.block_upload(command, index, sub, head, data[4])

    def upload(self, index: int, sub: int, head: bytes):
        value = self.read(index, sub)
        if 1 <= len(value) <= 4:
            return [bytes((0x43 | 4 - len(value) << 2,)) + head + value]
        request = yield [b"\x41" + head + struct.pack("<I", len(value))]
        toggle, at = 0, 0
        while True:
            if request[0] & 0xE0 != 0x60:
                raise Abort(COMMAND)
            if request[0] & 0x10 != toggle:
                raise Abort(TOGGLE)
            part = value[at : at + 7]
            at += 7
            last = at >= len(value)
            answer = bytes((toggle | 7 - len(part) << 1 | last,)) + part
            toggle ^= 0x10
            if last:
                return [answer]
            request = yield [answer]

    def download(self, command: int, index: int, sub: int, head: bytes, data: bytes):
        done = b"\x60" + head
        if command & 2:
            size = 4 - (command >> 2 & 3) if command & 1 else None
            if size is None:
                form = self.entry(index, sub)[1]
                size = struct.calcsize(form) if form else 4
            self.write(index, sub, data[4 : 4 + size])
            return [done]
        size = struct.unpack_from("<I", data, 4)[0] if command & 1 else None
        self.check(index, sub, size)
        value, toggle = b"", 0
        request = yield [done]
        while True:
            if request[0] & 0xE0:
                raise Abort(COMMAND)
            if request[0] & 0x10 != toggle:
                raise Abort(TOGGLE)
            value += request[1 : 8 - (request[0] >> 1 & 7)]
            if len(value) > (MAX_OCTETS if size is None else size):
                raise Abort(TOO_LONG)
            answer = bytes((0x20 | toggle,))
            toggle ^= 0x10
            if request[0] & 1:
                self.write(index, sub, value)
                return [answer]
            request = yield [answer]

    def block_download(
        self, command: int, index: int, sub: int, head: bytes, data: bytes
    ):
        size = struct.unpack_from("<I", data, 4)[0] if command & 2 else None
        self.check(index, sub, size)
        with_crc, most = bool(command & 4), 21
        value, last = b"", False
        request = yield [b"\xa4" + head + bytes((most,))]
        while not last:
            self.in_segments = True
            got = 0
            for _ in range(most):
                number, last_here = request[0] & 0x7F, bool(request[0] & 0x80)
                if number == got + 1:
                    got += 1
                    value += request[1:]
                    last = last_here
                if last_here or number == most:
                    break
                request = yield []
            if len(value) > MAX_OCTETS + 7:
                raise Abort(MEMORY)
            self.in_segments = not last
            request = yield [bytes((0xA2, got, most))]
        if request[0] & 0xE3 != 0xC1:
            raise Abort(COMMAND)
        value = value[: len(value) - (request[0] >> 2 & 7)]
        if with_crc and struct.unpack_from("<H", request, 1)[0] != crc16(value):
            raise Abort(CRC)
        if size is not None and len(value) != size:
            raise Abort(LENGTH)
        self.write(index, sub, value)
        return [b"\xa1"]

    def block_upload(self, command: int, index: int, sub: int, head: bytes, most: int):
        value = self.read(index, sub)
        check = crc16(value) if command & 4 else 0
        request = yield [b"\xc6" + head + struct.pack("<I", len(value))]
        if request[0] != 0xA3:
            raise Abort(COMMAND)
        at = 0
        while True:
            parts = [value[at : at + 7] for at in range(at, len(value), 7)] or [b""]
            ends = len(parts) <= most
            parts = parts[:most]
            frames = [
                bytes((number | (0x80 if ends and number == len(parts) else 0),))
                + part.ljust(7, b"\0")
                for number, part in enumerate(parts, 1)
            ]
            request = yield frames
            if request[0] != 0xA2:
                raise Abort(COMMAND)
            if request[1] > len(parts):
                raise Abort(SEQUENCE)
            at += 7 * request[1]
            most = request[2]
            if ends and request[1] == len(parts):
                break
        unused = -len(value) % 7 if value else 7
        request = yield [bytes((0xC1 | unused << 2,)) + struct.pack("<H", check)]
        if request[0] != 0xA1:
            raise Abort(COMMAND)
        return []


def argument(text: str) -> object:
    """Return a number or a truth if it looks like one."""
    if text in ("true", "false"):
        return text == "true"
    return int(text) if text.isdecimal() else text


def main() -> None:
    """Serve until killed."""
    node, interface, channel, *rest = sys.argv[1:]
    options = {key: argument(value) for key, value in (x.split("=") for x in rest)}
    with can.Bus(interface=interface, channel=channel, **options) as bus:
        print("ready", flush=True)
        Slave(bus, int(node)).run()


if __name__ == "__main__":
    main()
