"""A hub client that speaks slcan over a pseudo-terminal."""

from __future__ import annotations

import asyncio
import os
import pty
import termios
import tty
from typing import Final

from rtgen.runtime.canopen.bus.hub import Carried, Hub, HubBus, Port
from rtgen.runtime.canopen.bus.hub_text import Lines, Malformed, slcan_frame

_CHUNK: Final = 65536
_OK, _WRONG, _SENT, _SENT_LONG = b"\r", b"\a", b"z\r", b"Z\r"
_ANSWERS: Final = {"V": b"V1013\r", "N": b"N0001\r"}
_SETTINGS: Final = ("S", "s", "Y", "Z", "M", "m", "U", "X", "Q")
"""Commands without effect on a hub: bit rate, filters, time stamps and others."""
_OFF: Final = b"F80\r"


class SlcanPty(Port):
    """The slcan adapter at the other end of `path`, which programs open like a serial line."""

    def __init__(self, hub: Hub, bus: HubBus) -> None:
        self._end, self._line = pty.openpty()
        # Kept open, so that programs can open and close the line.
        tty.setraw(self._line)
        os.set_blocking(self._end, False)
        self.path = os.ttyname(self._line)
        super().__init__(f"{self.path} ({bus.channel})", hub.settings, hub.report_event)
        self.bus = bus
        self._lines = Lines()
        self._open = False
        self._listens = False
        self._unsent = bytearray()
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._end, self._readable)

    def close(self) -> None:
        """Remove the pseudo-terminal."""
        self._loop.remove_reader(self._end)
        self._loop.remove_writer(self._end)
        os.close(self._end)
        os.close(self._line)

    def text_of(self, carried: Carried) -> bytes | None:
        return carried.line

    def give_error(self, kind: int) -> None:
        """slcan has no error frames; the command F reports bus-off."""

    def flush(self) -> None:
        if self._queue and not self._unsent:
            self._unsent += b"".join(self._queue)
            self._queue.clear()
            self._writable()

    def cut_off(self, why: str) -> None:
        self._report_event(f"{self.name}: cut off, {why}")
        self._leave()
        self._unsent.clear()
        self._loop.remove_writer(self._end)
        termios.tcflush(self._line, termios.TCIFLUSH)

    def read_on(self) -> None:
        assert self.bus is not None
        while self.bus.has_room(self):
            try:
                line = self._lines.take()
            except Malformed as error:
                self._refuse(error)
                self._answer(_WRONG)
                continue
            if line is None:
                self._loop.add_reader(self._end, self._readable)
                return
            self._answer(self._obey(line))
        self._loop.remove_reader(self._end)

    def _readable(self) -> None:
        self._lines.feed(os.read(self._end, _CHUNK))
        self.read_on()

    def _obey(self, line: str) -> bytes:
        assert self.bus is not None
        command = line[:1]
        if command in ("t", "T", "r", "R"):
            try:
                frame = slcan_frame(line)
            except Malformed as error:
                self._refuse(error)
                return _WRONG
            if not self._open or self._listens:
                return _WRONG
            self.bus.put(self, frame)
            if self._queue or self._unsent:
                # A program that only sends need not read acknowledgements.
                return b""
            return _SENT_LONG if frame.extended else _SENT
        if line in ("O", "L"):
            self._listens = line == "L"
            if not self._open:
                self._open = True
                self.bus.join(self)
            return _OK
        if line == "C":
            self._leave()
            return _OK
        if line == "F":
            return _OFF if self.bus.off else b"F00\r"
        if line in _ANSWERS:
            return _ANSWERS[line]
        if not line or command in _SETTINGS:
            return _OK
        self._refuse(line)
        return _WRONG

    def _leave(self) -> None:
        assert self.bus is not None
        self._open = False
        self._queue.clear()
        self.bus.leave(self)

    def _answer(self, text: bytes) -> None:
        if text:
            self._append(text)
            self.flush()

    def _writable(self) -> None:
        try:
            del self._unsent[: os.write(self._end, self._unsent)]
        except BlockingIOError:
            self._loop.add_writer(self._end, self._writable)
            return
        if self._unsent:
            self._loop.add_writer(self._end, self._writable)
        else:
            self._loop.remove_writer(self._end)
            self.flush()
