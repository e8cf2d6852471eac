"""The offset in the data while the text of a decoder is written: a number, or a variable."""

from __future__ import annotations

from rtgen.runtime.marshalling.text import Body


class Position:
    """The body of a function that reads data, and the offset that it has reached.

    `_offset` is the offset as far as it is known when the text is written; None: it is in the
    variable `offset` of the function.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        self._offset: int | None = None

    def refuse(self, condition: str, message: str = "wrong length") -> None:
        """A statement that raises ValueError on a condition."""
        self.body.block(f"if {condition}:")
        self.body.add(f'raise ValueError("{message}")')
        self.body.end()

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
