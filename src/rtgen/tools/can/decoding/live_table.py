"""The live table of `rtgen can monitor`: one row for each identifier, with its latest frame."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console as Terminal
from rich.live import Live
from rich.table import Table

from rtgen.tools.can.decoding.decoder import Decoded
from rtgen.tools.can.decoding.frame_printing import MessageDecoder, Wanted, identifier

if TYPE_CHECKING:
    from can import Message

_REFRESH = 0.2
"""Seconds between two updates of the screen."""
_MAX_ROWS = 4096
"""Maximum number of rows; frames of further identifiers are only counted."""


class Row:
    """Count, period and latest frame of one identifier."""

    def __init__(self) -> None:
        self.count = 0
        self.period: float | None = None
        self._last = 0.0
        self.message: Message
        self.decoded: Decoded

    def take(self, message: Message, decoded: Decoded) -> None:
        """Update the row with a frame."""
        if self.count:
            self.period = message.timestamp - self._last
        self._last = message.timestamp
        self.count += 1
        self.message, self.decoded = message, decoded


class Rows:
    """The rows by identifier."""

    def __init__(self) -> None:
        self._rows: dict[tuple[int, bool], Row] = {}
        self.total = 0
        self.left_out = 0

    def take(self, message: Message, decoded: Decoded) -> None:
        """Update the row of a frame's identifier."""
        self.total += 1
        key = message.arbitration_id, message.is_extended_id
        row = self._rows.get(key)
        if row is None:
            if len(self._rows) == _MAX_ROWS:
                self.left_out += 1
                return
            row = self._rows[key] = Row()
        row.take(message, decoded)

    def table(self, title: str) -> Table:
        """Return the current rows as a table, sorted by identifier."""
        left_out = f", {self.left_out} not shown" if self.left_out else ""
        table = Table(
            title=f"{title}: {self.total} frames{left_out}",
            box=box.SIMPLE_HEAD,
            expand=True,
        )
        for name in ("id", "node", "kind"):
            table.add_column(name, no_wrap=True)
        for name in ("count", "ms"):
            table.add_column(name, justify="right", no_wrap=True)
        table.add_column("last", ratio=1, overflow="fold")
        for _, row in sorted(self._rows.items()):
            decoded, period = row.decoded, row.period
            table.add_row(
                identifier(row.message),
                decoded.name,
                decoded.kind,
                str(row.count),
                "" if period is None else f"{1000 * period:.1f}",
                decoded.text,
            )
        return table


def show(
    received: Iterator[Message | None],
    decoder: MessageDecoder,
    selection: Wanted,
    title: str,
    terminal: Terminal | None = None,
) -> None:
    """Show the table until the frames end."""
    rows = Rows()
    with Live(
        rows.table(title),
        console=terminal or Terminal(),
        auto_refresh=False,
        vertical_overflow="ellipsis",
    ) as live:
        due = time.monotonic()
        for message in received:
            if message is not None:
                decoded = decoder.decode(message)
                if selection(decoded):
                    rows.take(message, decoded)
            if time.monotonic() >= due:
                live.update(rows.table(title), refresh=True)
                due = time.monotonic() + _REFRESH
        live.update(rows.table(title), refresh=True)
