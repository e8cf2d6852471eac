"""Names in CORBA naming services."""

from __future__ import annotations

import os
import socket
import threading
from typing import Any

import CosNaming
from omniORB import CORBA

from .properties import Properties
from .values import split, toBool


class CorbaNaming:
    """A naming service; names are texts: `context.kind/name.kind`."""

    def __init__(self, orb: Any, name_server: str) -> None:
        """Initialize; raises CORBA's exceptions if there is no answer at `host:port`."""
        host, _, port = name_server.partition(":")
        place = f"corbaloc:iiop:{host}:{port or 2809}/NameService"
        self._root = orb.string_to_object(place)._narrow(CosNaming.NamingContext)

    def getRootContext(self) -> Any:
        return self._root

    def toName(self, text: str) -> list[Any]:
        parts = [each.rpartition(".") for each in text.split("/")]
        return [
            CosNaming.NameComponent(name if dot else kind, kind if dot else "")
            for name, dot, kind in parts
        ]

    def resolve(self, name: Any) -> Any:
        return self._root.resolve(self.toName(name) if isinstance(name, str) else name)

    def rebindByString(self, text: str, reference: Any) -> None:
        """Bind a name; missing contexts are created."""
        name = self.toName(text)
        context = self._root
        for step in name[:-1]:
            try:
                context = context.bind_new_context([step])
            except CosNaming.NamingContext.AlreadyBound:
                context = context.resolve([step])._narrow(CosNaming.NamingContext)
        context.rebind(name[-1:], reference)

    def unbind(self, name: Any) -> None:
        self._root.unbind(self.toName(name) if isinstance(name, str) else name)


class NamingManager:
    """Keeps the components of a manager bound in all its naming services."""

    def __init__(self, orb: Any, config: Properties) -> None:
        self._orb = orb
        self._bound: dict[str, Any] = {}
        self._lock = threading.Lock()
        enabled = toBool(config.getProperty("naming.enable"), "YES", "NO", True)
        servers = config.getProperty("corba.nameservers", "localhost")
        self._servers = split(servers) if enabled else []
        self._ended = threading.Event()
        if self._servers and toBool(
            config.getProperty("naming.update.enable"), "YES", "NO", True
        ):
            interval = float(config.getProperty("naming.update.interval", "10"))
            self._thread = threading.Thread(
                target=self._update, args=(interval,), daemon=True
            )
            self._thread.start()

    def bindObject(self, name: str, reference: Any) -> None:
        with self._lock:
            self._bound[name] = reference
        self._everywhere(lambda naming: naming.rebindByString(name, reference))

    def unbindObject(self, name: str) -> None:
        with self._lock:
            self._bound.pop(name, None)
        self._everywhere(lambda naming: naming.unbind(name))

    def close(self) -> None:
        self._ended.set()

    def _everywhere(self, act: Any) -> None:
        """Apply a function to all servers; one without an answer is skipped until the update."""
        for server in self._servers:
            try:
                act(CorbaNaming(self._orb, server))
            except (CORBA.Exception, AttributeError):
                continue

    def _update(self, interval: float) -> None:
        while not self._ended.wait(interval):
            with self._lock:
                bound = dict(self._bound)
            for name, reference in bound.items():
                self._everywhere(
                    lambda naming, n=name, r=reference: naming.rebindByString(n, r)
                )


def formatted(pattern: str, properties: Properties, manager: str) -> str:
    """Return a pattern of `naming.formats` for a component."""
    for mark, text in (
        ("%n", properties.getProperty("instance_name")),
        ("%t", properties.getProperty("type_name")),
        ("%m", properties.getProperty("type_name")),
        ("%v", properties.getProperty("version")),
        ("%V", properties.getProperty("vendor")),
        ("%c", properties.getProperty("category")),
        ("%h", socket.gethostname()),
        ("%M", manager),
        ("%p", str(os.getpid())),
    ):
        pattern = pattern.replace(mark, text)
    return pattern
