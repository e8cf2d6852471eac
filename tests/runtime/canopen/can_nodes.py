"""Complete slaves of the devices in `specs/canopen`, on a virtual bus of this process."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.objects_module import objects_module
from rtgen.compiler.frontends import eds
from rtgen.compiler.model.can_bus import kind_of
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.description import DeviceDescription
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.timing.clocks import RealClock

OPTIONS = Options("devices", "", "0")
SPECS = Path(__file__).parents[3] / "specs" / "canopen"


@cache
def description(name: str | Path) -> DeviceDescription:
    """Return the generated description of a file, or of `specs/canopen/<name>.eds`."""
    path = name if isinstance(name, Path) else SPECS / f"{name}.eds"
    (device,) = eds.load([path], root=path.parent).model.devices
    made: dict[str, Any] = {"__name__": path.stem}
    exec(
        objects_module("d.py", DevicePorts(device, kind_of(device)), OPTIONS).text, made
    )
    found = made["DESCRIPTION"]
    assert isinstance(found, DeviceDescription)
    return found


@contextmanager
def nodes(
    channel: str | Link, names: Mapping[int, str | Path], serial: int = 0
) -> Iterator[dict[int, DeviceNode]]:
    """Yield booted slaves by node-id, on a virtual channel or a link.

    Node-ids above 200 stand for nodes without one; serial numbers are consecutive.
    """
    link = (
        open_link(RealClock(), "virtual", channel)
        if isinstance(channel, str)
        else channel
    )
    made = {}
    for place, (node_id, name) in enumerate(names.items()):
        node = DeviceNode(
            description(name),
            node_id if node_id <= 127 else 255,
            serial_number=serial + place,
        )
        with link.lock:
            link.attach(node)
            link.send(node.boot(link.now()), node)
            link.refresh(node)
        made[node_id] = node
    try:
        yield made
    finally:
        for node in made.values():
            link.detach(node)
