"""The SDO servers of a device: the predefined one, and those of 1201h to 127Fh.

CiA 301, 7.5.2.33: each serves one client, and has two COB-IDs. It exists while both are valid.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from rtgen.facts.canopen import INVALID
from rtgen.facts.cob_ids import SDO_CLIENTS, SDO_SERVERS
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.object_dictionary import (
    DeviceDictionary,
    check_cob_id,
)
from rtgen.runtime.canopen.wire.frames import CobId, Frame, earliest
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

FURTHER_SERVERS: Final = SDO_SERVERS[1:]
_COB_IDS: Final = (1, 2)


class SdoServers:
    """All servers of a device, with one object dictionary."""

    def __init__(self, dictionary: DeviceDictionary) -> None:
        self._dictionary = dictionary
        self._node_id = 1
        self._first = SdoServer(1, dictionary)
        self._further: dict[int, SdoServer] = {}
        self._indices = [index for index in FURTHER_SERVERS if (index, 1) in dictionary]
        clients = [index for index in SDO_CLIENTS if (index, 1) in dictionary]
        dictionary.guard((*self._indices, *clients), self._check)

    @property
    def requests(self) -> frozenset[int]:
        """The CAN identifiers of requests."""
        return frozenset(server.request.can_id for server in self._all)

    @property
    def responses(self) -> frozenset[int]:
        """The CAN identifiers of responses, which only this node sends."""
        return frozenset(server.response.can_id for server in self._all)

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll`."""
        return earliest(*[server.deadline for server in self._all])

    def begin(self, node_id: int) -> None:
        """Serve as a node with this node-id; transfers in progress are dropped."""
        self._node_id = node_id
        self._first = SdoServer(node_id, self._dictionary)
        self._further.clear()
        self.configure()

    def configure(self) -> None:
        """Apply 1201h to 127Fh; servers that are unchanged continue their transfers."""
        for index in self._indices:
            cob_ids = self._cob_id(index, 1), self._cob_id(index, 2)
            if not all(cob_id.valid for cob_id in cob_ids):
                self._further.pop(index, None)
                continue
            server = self._further.get(index)
            if server is None or (server.request, server.response) != cob_ids:
                self._further[index] = SdoServer(
                    self._node_id, self._dictionary, cob_ids=cob_ids
                )

    def reset(self) -> None:
        """Drop all transfers without a message."""
        for server in self._all:
            server.reset()

    def receive(self, frame: Frame, now: int) -> list[Frame]:
        """Return the responses to a frame."""
        return [answer for server in self._all for answer in server.receive(frame, now)]

    def poll(self, now: int) -> list[Frame]:
        """Abort the transfers whose clients are silent for too long."""
        return [frame for server in self._all for frame in server.poll(now)]

    @property
    def _all(self) -> Iterable[SdoServer]:
        return (self._first, *self._further.values())

    def _cob_id(self, index: int, subindex: int) -> CobId:
        return CobId(self._dictionary.number((index, subindex), INVALID))

    def _check(self, number: ObjectNumber, value: ObjectValue) -> None:
        if number[1] not in _COB_IDS:
            return
        check_cob_id(self._cob_id(*number).value, value)
