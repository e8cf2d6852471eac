"""Media that transport data outside of connections: CAN buses, TCP and serial lines.

A component is attached to a medium by its configuration parameters, which the functions below
define. Parameters of a system's active configuration set override the defaults of the component's
definition.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from rtgen.compiler.backends.wiring.diagram import (
    Box,
    Diagram,
    Link,
    LinkStyle,
    Medium,
    Tab,
)
from rtgen.compiler.model import PortKind, System, SystemComponent
from rtgen.compiler.model.can_bus import Bus, PdoLink

_CAN = frozenset({"interface", "channel", "network"})
_ADDRESSES = ("ipaddr", "host")
_SELECTORS = ("type", "transport")
_UNSET = ("", "none")


@dataclass(frozen=True, slots=True)
class _Attachment:
    """A component on a medium; `key` is equal for all components on the same one."""

    key: tuple[str, ...]
    label: str
    node: str
    node_id: int | None = None


def with_media(
    diagram: Diagram,
    system: System,
    defaults: Mapping[str, Mapping[str, str]],
    buses: Sequence[Bus],
) -> Diagram:
    """Return the diagram with the media of the system and the PDO links of its CAN buses.

    Many unconnected ports are collapsed.

    `defaults` maps a component type to the defaults of its parameters.
    """
    boxes = {box.instance: box for box in diagram.boxes}
    networks = {bus.name: bus for bus in buses}
    media: dict[tuple[str, ...], Medium] = {}
    attached: dict[str, list[tuple[Box, int]]] = {}
    for component in system.components:
        values = {**defaults.get(component.type, {}), **_configured(component)}
        attachment = _attachment(values, networks)
        if attachment is None:
            continue
        box = boxes[component.instance]
        medium = media.setdefault(
            attachment.key, Medium(attachment.label, len(media), [])
        )
        medium.nodes.append((box, attachment.node))
        box.media.append((medium, attachment.node))
        if attachment.node_id is not None and not component.type.endswith("Proxy"):
            attached.setdefault(values["network"], []).append((box, attachment.node_id))
    links = [
        link
        for name, nodes in attached.items()
        if name in networks
        for link in _pdo_links(networks[name], nodes)
    ]
    for box in diagram.boxes:
        box.collapse()
    return Diagram(
        diagram.title, diagram.boxes, (*diagram.links, *links), tuple(media.values())
    )


def _configured(component: SystemComponent) -> dict[str, str]:
    return dict(dict(component.configuration).get(component.active_set, ()))


def _attachment(
    values: Mapping[str, str], networks: Mapping[str, Bus]
) -> _Attachment | None:
    if values.keys() >= _CAN:
        return _can(values, networks)
    selected = next((values[s] for s in _SELECTORS if s in values), "").lower()
    if selected == "tcp":
        host = next((values[a] for a in _ADDRESSES if a in values), "")
        label = f"TCP {host}:{values.get('port', '')}"
        return _Attachment(("tcp", label), label, label)
    if selected.startswith("seria"):
        names = [values.get(name, "") for name in ("device", "port")]
        device = next((name for name in names if name not in _UNSET), "")
        return _Attachment(("serial", device), f"Serial line {device}", "serial line")
    return None


def _can(values: Mapping[str, str], networks: Mapping[str, Bus]) -> _Attachment:
    channel, network = values["channel"], values["network"]
    label = f"CAN {channel}"
    bus = networks.get(network)
    if network not in _UNSET:
        label += f" · {network}"
    if bus is not None:
        label += f" · {bus.bit_rate} kbit/s"
    number = values.get("node_id", "")
    if not number.isdecimal():
        return _Attachment(("can", channel, network), label, "CAN manager")
    return _Attachment(
        ("can", channel, network), label, f"CAN node {number}", int(number)
    )


def _pdo_links(bus: Bus, nodes: Sequence[tuple[Box, int]]) -> Iterator[Link]:
    """Yield the PDOs sent by one node of the bus file and received by another one."""
    ids = {node.name: node.id for node in bus.nodes}
    for link in bus.links:
        ends = _ends(link, ids, nodes)
        if ends is None:
            continue
        source, target = ends
        source.connected = target.connected = True
        yield Link(source, target, LinkStyle.PDO, (("network", bus.name),))


def _ends(
    link: PdoLink, ids: Mapping[str, int], nodes: Sequence[tuple[Box, int]]
) -> tuple[Tab, Tab] | None:
    """Return the tabs of the two devices.

    Their proxies have the same ports, but do not send such frames.
    """
    (sender, sent), (taker, taken) = link.source, link.target
    source = _tab(nodes, ids.get(sender), PortKind.OUTPORT, f"tpdo{sent}")
    target = _tab(nodes, ids.get(taker), PortKind.INPORT, f"rpdo{taken}")
    return None if source is None or target is None else (source, target)


def _tab(
    nodes: Sequence[tuple[Box, int]], node_id: int | None, kind: PortKind, name: str
) -> Tab | None:
    for box, number in nodes:
        for tab in box.tabs:
            if number == node_id and tab.view.kind is kind and tab.view.name == name:
                return tab
    return None
