"""The channels by which pages get the samples of OutPorts."""

from __future__ import annotations

from itertools import count
from typing import Any

from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.ui.protocol import ui


class Channels(dict[tuple[str, str], ui.Channel]):
    """The channels of OutPorts, by instance and port; `numbers` are those of further ones."""

    def __init__(self) -> None:
        super().__init__()
        self.numbers = count(1)

    def opened(self, instance: str, port: str, type_number: int) -> ui.Channel:
        """Return the channel of an OutPort, opening a new one."""
        key = instance, port
        if key not in self:
            address = ui.PortAddress(instance=instance, port=port)
            self[key] = ui.Channel(next(self.numbers), address, type_number)
        return self[key]

    def forget(self, instance: str) -> None:
        """Forget the channels of a removed component."""
        for key in [key for key in self if key[0] == instance]:
            del self[key]

    def source(self, connector: DataConnector[Any]) -> int | None:
        """Return the number of the channel of the OutPort of a connection."""
        port = connector.source
        channel = self.get((port.owner, port.name))
        return None if channel is None else channel.id
