"""The pages of a session, and what they are sent."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui


class Pages:
    """The outboxes of the pages. `sent_types` of the type table are known to all of them."""

    def __init__(self) -> None:
        self.sent_types = 0
        self._lock = threading.Lock()
        self._pages: tuple[Outbox, ...] = ()
        self._watched: frozenset[int] = frozenset()

    def __iter__(self) -> Iterator[Outbox]:
        return iter(self._pages)

    def __bool__(self) -> bool:
        return bool(self._pages)

    def add(self, page: Outbox) -> None:
        """Add a page; from any thread."""
        with self._lock:
            self._pages = (*self._pages, page)

    def remove(self, page: Outbox) -> None:
        """Forget a page; from any thread."""
        with self._lock:
            self._pages = tuple(each for each in self._pages if each is not page)

    def watched_now(self) -> frozenset[int]:
        """Return the channels that pages watch, after a change."""
        self._watched = frozenset().union(*(page.watched for page in self._pages))
        return self._watched

    def put(self, types: Sequence[ui.TypeNode], events: Sequence[ui.Event]) -> None:
        """Put events into each outbox, after types of the table that are new."""
        if len(types) > self.sent_types:
            first, self.sent_types = self.sent_types, len(types)
            added = ui.AddedTypes(first=first, nodes=[*types[first:]])
            self.put_in_all(ui.Event.of_types(added))
        self.put_in_all(*events)

    def put_in_all(self, *events: ui.Event) -> None:
        """Put events without types into each outbox."""
        for page in self._pages:
            page.put(*events)

    def sample(self, sample: ui.Sample) -> None:
        """Send a sample to the pages that watch its channel; from any thread."""
        if sample.channel not in self._watched:
            return
        for page in self._pages:
            if sample.channel in page.watched:
                page.sample(sample)
