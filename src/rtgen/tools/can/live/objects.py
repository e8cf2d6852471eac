"""Objects of nodes: which one is meant, by which server, and who else uses it."""

from __future__ import annotations

from dataclasses import replace

from rtgen.compiler.model.canopen import Access
from rtgen.compiler.project_rules import SUPERVISED
from rtgen.facts.canopen import INVALID
from rtgen.facts.cob_ids import SDO_SERVERS
from rtgen.runtime.canopen.description import Kind
from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, CobId, Frame, sdo_cob_ids
from rtgen.tools.can.decoding.node_index import DescribedObject, NodeIndex, number_of
from rtgen.tools.can.live.bus_session import BusSession
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal

_DEFAULT_WATCH = 0.3
"""Seconds to watch for a manager if no bus file gives its heartbeat period."""


_MAX_WATCH = 2.0


def server_cob_ids(
    node_index: NodeIndex, node_id: int, server: int
) -> tuple[CobId, CobId]:
    """Return the COB-IDs of an SDO server of a node. Raises Refusal for one that is not valid."""
    if server == 1:
        return sdo_cob_ids(node_id)
    node, index = node_index.nodes.get(node_id), SDO_SERVERS[server - 1]
    parameters = {} if node is None else node.parameters
    request, response = (
        CobId(parameters.get((index, sub), INVALID) & 0xFFFFFFFF) for sub in (1, 2)
    )
    if not (request.valid and response.valid):
        raise Refusal(
            f"{node_index.name(node_id)} has no SDO server {server}: its description gives "
            f"{index:04X}h no two valid COB-IDs"
        )
    return request, response


def requested_object(
    node_index: NodeIndex, node_id: int, name: str, kind: Kind | None, *, raw: bool
) -> DescribedObject:
    """Return the object; for a node without a description, an unnamed one of the requested kind."""
    node = node_index.nodes.get(node_id)
    if node is not None:
        try:
            thing = node.object(name)
        except Refusal:
            # Devices have objects that their descriptions omit.
            if kind is None or number_of(name) is None:
                raise
        else:
            return _as(thing, kind, raw=raw)
    number = number_of(name)
    if number is None:
        raise Refusal(
            f"{node_index.name(node_id)} is not described, so {name!r} is not known: give --bus or "
            "--eds, or write the number, such as 6401:1"
        )
    return DescribedObject(number, "", kind or "octets", Access.RW)


def _as(thing: DescribedObject, kind: Kind | None, *, raw: bool) -> DescribedObject:
    """Return the object with another kind, or without factor and its unit."""
    if kind is None and not raw:
        return thing
    unit = "" if thing.factor is not None else thing.unit
    return replace(thing, kind=kind or thing.kind, factor=None, unit=unit)


class OtherClientWatch:
    """Detects another SDO client of the node's server; the manager is one if it `is_shared`."""

    def __init__(
        self, node_index: NodeIndex, node_id: int, requests: CobId, *, is_shared: bool
    ) -> None:
        self._manager = ERROR_CONTROL + node_index.manager if is_shared else None
        self._requests = requests
        period = node_index.bus.heartbeat if node_index.bus else 0.0
        self.seconds = min(2.5 * period, _MAX_WATCH) or _DEFAULT_WATCH
        self._name = node_index.name(node_id)
        self._by = f"the manager (node {node_index.manager})"
        self.found = ""

    def __call__(self, frame: Frame) -> None:
        if frame.remote:
            return
        if frame.can_id == self._manager and not frame.extended:
            self.found = f"{self._by} is on the bus, and supervises {self._name}"
        elif self._requests.carries(frame):
            self.found = f"somebody else reads and writes objects of {self._name}"


def warn_of_other_client(
    console: Console, watch: OtherClientWatch, session: BusSession
) -> None:
    """Warn if the node already has an SDO client."""
    session.listen(watch.seconds, lambda: bool(watch.found))
    if watch.found:
        hint = "use the SDO port of its proxy, or the manager"
        console.findings([SUPERVISED.at(None, watch.found, hint=hint)])
