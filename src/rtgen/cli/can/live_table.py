"""The table that `rtgen can monitor` shows: a row for each identifier, as it is on the bus now."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console as Terminal
from rich.live import Live
from rich.table import Table

from rtgen.cli.can.decoding import Decoded
from rtgen.cli.can.printing import MessageDecoder, Wanted, identifier

if TYPE_CHECKING:
    from can import Message

_REFRESH = 0.2
"""Seconds between two pictures."""
_MAX_ROWS = 4096
"""A table has no more rows; further identifiers are counted."""


class Row:
    """What is known of one identifier."""

    def __init__(self) -> None:
        self.count = 0
        self.period: float | None = None
        self._last = 0.0
        self.message: Message
        self.told: Decoded

    def take(self, message: Message, told: Decoded) -> None:
        """Takes a frame of it."""
        if self.count:
            self.period = message.timestamp - self._last
        self._last = message.timestamp
        self.count += 1
        self.message, self.told = message, told


class Rows:
    """The rows, by identifier."""

    def __init__(self) -> None:
        self._rows: dict[tuple[int, bool], Row] = {}
        self.total = 0
        self.left_out = 0

    def take(self, message: Message, told: Decoded) -> None:
        """Takes a frame."""
        self.total += 1
        key = message.arbitration_id, message.is_extended_id
        row = self._rows.get(key)
        if row is None:
            if len(self._rows) == _MAX_ROWS:
                self.left_out += 1
                return
            row = self._rows[key] = Row()
        row.take(message, told)

    def table(self, title: str) -> Table:
        """The rows as they are now, by identifier."""
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
            told, period = row.told, row.period
            table.add_row(
                identifier(row.message),
                told.name,
                told.kind,
                str(row.count),
                "" if period is None else f"{1000 * period:.1f}",
                told.text,
            )
        return table


def show(
    coming: Iterator[Message | None],
    decoder: MessageDecoder,
    wanted: Wanted,
    title: str,
    terminal: Terminal | None = None,
) -> None:
    """Shows the table until no more frames come."""
    rows = Rows()
    with Live(
        rows.table(title),
        console=terminal or Terminal(),
        auto_refresh=False,
        vertical_overflow="ellipsis",
    ) as live:
        due = time.monotonic()
        for message in coming:
            if message is not None:
                told = decoder.decode(message)
                if wanted(told):
                    rows.take(message, told)
            if time.monotonic() >= due:
                live.update(rows.table(title), refresh=True)
                due = time.monotonic() + _REFRESH
        live.update(rows.table(title), refresh=True)
