"""The offset in the data while a decoder is generated: a number, or a variable."""

from __future__ import annotations

from rtgen.runtime.marshalling.layouts.headers import Lengths
from rtgen.runtime.marshalling.source.text import Body


class Position:
    """A function under construction that reads data, with the current offset.

    `_offset` is the offset if it is known when the text is generated; None: it is in the function's
    variable `offset`.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        self._offset: int | None = None

    def refuse(self, condition: str, message: str = "wrong length") -> None:
        """Generate a statement that raises ValueError on a condition."""
        self.body.block(f"if {condition}:")
        self.body.add(f'raise ValueError("{message}")')
        self.body.end()

    def enclose(self) -> None:
        """Let the data end at the offset in the variable `end`."""
        self.refuse("end > len(data)", "a length beyond the end")
        self.body.add("data = memoryview(data)[:end]")

    def take_length(self, end: str) -> None:
        """Generate the end of a delimited value, from its DHEADER."""
        self._settle()
        body = self.body
        body.choose("get", "get", Lengths, "get")
        body.add("offset += -offset & 3")
        body.add("(size,) = get(data, offset)")
        body.add("offset += 4")
        body.add(f"{end} = offset + size")

    def _place(self) -> str:
        return "offset" if self._offset is None else str(self._offset)

    def _advance(self, size: int) -> None:
        if self._offset is None:
            self.body.add(f"offset += {size}")
        else:
            self._offset += size

    def _settle(self) -> None:
        """Keep the offset in a variable from here on."""
        if self._offset is not None:
            self.body.add(f"offset = {self._offset}")
            self._offset = None
