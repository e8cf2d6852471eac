"""Presence as instances of a keyed topic, alive or not (DDS 1.4, 2.2.2.5.1.3)."""

from __future__ import annotations

import os
import threading
from collections import Counter
from collections.abc import Callable
from typing import Any, ClassVar

from cyclonedds import _clayer
from cyclonedds.core import InstanceState

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, CdrError
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.entities import Entities
from rtgen.runtime.distribution.medium import OnChange, Qos, representation
from rtgen.runtime.xcdr import deserialize, serialize

_TOPIC = "rtgen/presence"
_QOS = Qos(depth=1, durable=True)


class Presence(Aggregated):
    """The key of a presence: the name, and the process that announces it."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Presence",
        name=idl.member(idl.string(255), key=True),
        holder=idl.member(idl.array(idl.OCTET, 16), key=True),
    )

    name: str = ""
    holder: bytes = bytes(16)


class Presences:
    """Announcements of this process, and presences of all processes."""

    def __init__(self, factory: Entities, dispatcher: Dispatcher) -> None:
        self._holder = os.urandom(16)
        self._lock = threading.RLock()
        self._announced: Counter[str] = Counter()
        self._names: dict[int, str] = {}
        self._present: Counter[str] = Counter()
        self._watches: list[tuple[str, OnChange]] = []
        self._writer = factory.writer(_TOPIC, Presence, _QOS)
        self._reader = factory.reader(_TOPIC, Presence, _QOS)
        self._condition = entities.condition(self._reader)
        self._entry = dispatcher.add(self._condition, self._take)

    def announce(self, name: str) -> Callable[[], None]:
        """Announce a name; the returned function ends it."""
        with self._lock:
            self._announced[name] += 1
            if self._announced[name] == 1:
                entities.write(self._writer, self._sample(name))

        def end() -> None:
            with self._lock:
                self._announced[name] -= 1
                if not self._announced[name]:
                    del self._announced[name]
                    _clayer.ddspy_dispose(self._writer._ref, self._sample(name))

        return end

    def watch(self, prefix: str, on_change: OnChange) -> Callable[[], None]:
        """Call `on_change` for changes of names; the returned function ends it."""
        entry = prefix, on_change
        with self._lock:
            for name in self._present:
                if name.startswith(prefix):
                    on_change(name, True)
            self._watches.append(entry)

        def end() -> None:
            with self._lock:
                self._watches.remove(entry)

        return end

    def close(self) -> None:
        """Close the reader and the writer."""
        self._entry.close()
        for entity in (self._condition, self._reader, self._writer):
            entities.delete(entity)

    def _sample(self, name: str) -> bytes:
        return serialize(Presence(name, self._holder), representation(Presence))

    def _take(self) -> None:
        with self._lock:
            for octets, info in entities.taken(self._reader):
                self._received(octets, info)

    def _received(self, octets: bytes, info: Any) -> None:
        handle = info.instance_handle
        alive = info.instance_state == InstanceState.Alive
        if alive and info.valid_data and handle not in self._names:
            try:
                name = deserialize(Presence, octets).name
            except CdrError:
                return  # Not a presence of rtgen.
            self._names[handle] = name
            self._present[name] += 1
            if self._present[name] == 1:
                self._notify(name, True)
        elif not alive and handle in self._names:
            name = self._names.pop(handle)
            self._present[name] -= 1
            if not self._present[name]:
                del self._present[name]
                self._notify(name, False)

    def _notify(self, name: str, present: bool) -> None:
        for prefix, on_change in list(self._watches):
            if name.startswith(prefix):
                on_change(name, present)
