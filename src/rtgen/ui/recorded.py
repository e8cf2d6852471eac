"""A session that shows one recording, or compares two, without a running system."""

from __future__ import annotations

import itertools
import threading
import uuid
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.requests import Client, Request, Requests
from rtgen.ui.buses import DescriberOf
from rtgen.ui.errors import IMPOSSIBLE, CommandError
from rtgen.ui.history import History
from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind
from rtgen.ui.reading import MAX_OCTETS, Reading
from rtgen.ui.type_table import TypeTable


class _AtOnce(Requests):
    """Executes requests of clients at once, in the calling thread."""

    def __init__(self) -> None:
        super().__init__(1.0)
        self._lock = threading.Lock()

    def put(self, client: Client | None, request: Request) -> bool:
        """Execute a request."""
        with self._lock:
            request()
        return True


class AtOnce:
    """Executes requests at once, in the calling thread."""

    def __init__(self) -> None:
        self.requests = _AtOnce()

    def start(self) -> None:
        """Do nothing: no system runs."""

    def submit(self, request: Callable[[], None]) -> bool:
        """Execute a request."""
        return self.requests.put(None, request)


class Recorded:
    """A recording, and optionally a second one to compare. Times start with each run."""

    def __init__(
        self,
        files: Sequence[str],
        describer: DescriberOf,
        codec: Callable[[str], Codec | None] = lambda _: None,
        max_octets: int = MAX_OCTETS,
    ) -> None:
        """Raise ToolError if a file is not a recording or cannot be decoded."""
        self.name = uuid.uuid4().hex
        self.runner = AtOnce()
        self.history = History(max_octets)
        self._types = TypeTable()
        numbers = itertools.count(1)
        reading = Reading(self.history, self._types, numbers, describer, codec)
        for beside, file in enumerate(files):
            reading.read(file, beside=beside > 0)
        self._channels = frozenset(each.id for each in reading.channels)
        self.left_out = self.history.first > 0.0
        clock = ui.ClockState(
            kind=ui.ClockKind.CLOCK_RECORDING, speed=1.0, ended=True, past=True
        )
        self.history.begin(
            ui.SystemState(
                name=Path(files[0]).name,
                components=[*reading.components.values()],
                channels=reading.channels,
                time=clock,
                edits=ui.EditState(saved=True, file=files[0]),
                beside=Path(files[1]).name if len(files) > 1 else "",
            )
        )

    # Pages.

    def join(self, page: Outbox) -> None:
        """Send a new page the greeting and the beginning of the recording."""
        hello = ui.Hello(version=ui.VERSION, server=self.name, full=False)
        self._look(page, self.history.first, ui.Event.of_greeting(hello))

    def leave(self, page: Outbox) -> None:
        """Do nothing: pages have no state here."""

    def close(self) -> None:
        """Do nothing: no file is open."""

    def is_urgent(self, page: Outbox, message: ui.ClientMessage) -> bool:
        """Return False: nothing runs."""
        return False

    def execute(self, page: Outbox, message: ui.ClientMessage) -> None:
        """Execute a command and send the page its result."""
        result = ui.Result(request=message.request, done=True)
        value: Any = message.asked.value
        try:
            match message.asked.discriminator:
                case CommandKind.COMMAND_WATCH:
                    watched = self._channels.intersection(value)
                    added = watched - page.watched
                    page.watched = watched
                    past = self.history.last if page.past is None else page.past
                    page.show_more(self.history.samples(past, added))
                case CommandKind.COMMAND_LOOK:
                    self._look(page, self.history.last if value < 0 else value)
                case _:
                    raise CommandError(
                        IMPOSSIBLE,
                        "a recording cannot be changed",
                        "`rtgen ui SYSTEM` runs a system",
                    )
        except CommandError as error:
            result.done, result.code, result.hint = False, error.code, error.hint
            result.message = str(error)
        page.put(ui.Event.of_outcome(result))

    def _look(self, page: Outbox, time: float, *first: ui.Event) -> None:
        now = self.history.nearest(time)
        events = self.history.at(now, self._types.nodes, page.watched)
        page.show([*first, *events], now)
