"""Nodes of rclpy in an installation of ROS 2, each a process of its own (`rclpy_peer.py`)."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from patience import PATIENCE
from ros2_peers import Installation

SCRIPT = Path(__file__).with_name("rclpy_peer.py")


class Events:
    """The events that a node told."""

    def __init__(self) -> None:
        self.events: list[list[Any]] = []
        self._changed = threading.Condition()
        self._ended = False

    def tell(self, *event: Any) -> None:
        """Add an event."""
        with self._changed:
            self.events.append(list(event))
            self._changed.notify_all()

    def event(self, *start: Any) -> list[Any]:
        """Wait for the next event that begins so; return what follows its name.

        Events before it stay.
        """
        with self._changed:
            found = self._changed.wait_for(
                lambda: next(
                    (e for e in self.events if e[: len(start)] == list(start)),
                    self._ended,
                ),
                PATIENCE,
            )
            assert isinstance(found, list), f"no {start}: {self.events}"
            self.events.remove(found)
            return found[1:]


class Node(Events):
    """A node of rclpy."""

    def __init__(
        self,
        installation: Installation,
        name: str,
        namespace: str,
        domain: int,
        script: Path = SCRIPT,
    ) -> None:
        super().__init__()
        self._process = installation.start(script, name, namespace, domain=domain)
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()
        self.name = self.event("ready")[0]

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.tell(*json.loads(line))
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def do(self, command: str, *arguments: Any) -> None:
        """Tell the node to do something: a method of `rclpy_peer.Peer`."""
        assert self._process.stdin is not None
        print(json.dumps([command, *arguments]), file=self._process.stdin, flush=True)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(PATIENCE)
        self._reading.join()
        assert self._process.stdout is not None
        self._process.stdout.close()


@contextmanager
def node(
    installation: Installation,
    name: str,
    namespace: str = "/",
    *,
    domain: int,
    script: Path = SCRIPT,
) -> Iterator[Node]:
    """Yield a node, which ends afterwards; `script` is its program."""
    made = Node(installation, name, namespace, domain, script)
    try:
        yield made
    finally:
        made.close()
