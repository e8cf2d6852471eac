"""Pages of CANopen: devices with object dictionary and PDOs, buses with their load."""

from __future__ import annotations

from rtgen.compiler.backends.kit.quoting.markdown import Markdown, code, text
from rtgen.compiler.inspection.devices import value_of
from rtgen.compiler.layouts.can_messages import messages
from rtgen.compiler.layouts.can_timing import load, response_times
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import Device, Pdo, Variable
from rtgen.tools.docs.pages import Content, Page, counted
from rtgen.tools.docs.places import Kind


def _hexadecimal(number: object) -> str:
    return f"{number:X}h" if isinstance(number, int) else str(number or "")


def add_device(content: Content, page: Page, d: Device) -> None:
    """Fill the page of a device."""
    info = d.info
    page.summary = info.product_name
    page.description(d.file_info.description)
    page.table(
        ("property", "value"),
        [
            ("described by", code(d.key)),
            ("vendor", f"{info.vendor_name} ({_hexadecimal(d.vendor_id)})"),
            ("product", f"{info.product_name} ({_hexadecimal(d.product_code)})"),
            ("bit rates", ", ".join(f"{r} kbit/s" for r in info.bit_rates)),
            ("LSS", "yes" if info.lss else "no"),
        ],
    )
    names = {c: f"{d.name}{c}" for c in ("Proxy", "Device")}
    links = (content.places.link(Kind.COMPONENT, n, page.path) for n in names.values())
    page.add(f"Components: {', '.join(links)}.")
    page.heading(2, "PDOs")
    for pdo in d.pdos:
        _add_pdo(page, d, pdo)
    page.heading(2, "Object dictionary")
    for thing in d.objects:
        page.heading(3, f"{thing.index:04X}h {thing.name}", f"o{thing.index:04X}")
        head = ("sub", "name", "type", "access", "value", "range", "unit", "PDO")
        page.table(head, [_variable(d, v) for v in thing.variables])


def _variable(d: Device, v: Variable) -> tuple[object, ...]:
    limits = [value_of(x, d.node_id) for x in (v.low, v.high)]
    bounds = " to ".join("" if x is None else str(x) for x in limits)
    return (
        v.subindex,
        v.name,
        v.type_name,
        v.written_access,
        code("" if v.current is None else str(value_of(v.current, d.node_id))),
        bounds.strip() if any(x is not None for x in limits) else "",
        v.unit,
        "yes" if v.pdo_mappable else "",
    )


def _add_pdo(page: Page, d: Device, pdo: Pdo) -> None:
    page.heading(
        3, f"{pdo.direction.upper()} {pdo.number}", f"{pdo.direction}{pdo.number}"
    )
    cob_id = value_of(pdo.cob_id, d.node_id)
    facts = [f"COB-ID {code(_hexadecimal(cob_id))}"]
    if not pdo.valid:
        facts.append("not valid")
    for name, value, unit in (
        ("transmission type", pdo.transmission_type, ""),
        ("inhibit time", pdo.inhibit_time, " x 100 us"),
        ("event timer", pdo.event_timer, " ms"),
    ):
        if value is not None:
            facts.append(f"{name} {value}{unit}")
    page.add(", ".join(facts))
    rows = []
    cells: list[tuple[int, int, str]] = []
    for start, entry in pdo.places:
        found = None if entry.dummy else d.find(entry.index, entry.subindex)
        name = "gap" if found is None else found.name
        end = start + entry.bits
        number = f"{entry.index:04X}h:{entry.subindex:X}"
        unit = "" if found is None else found.unit
        rows.append((f"{start} to {end - 1}", code(number), name, entry.bits, unit))
        cells.append((start, end, name))
    page.table(("bits", "object", "name", "width", "unit"), rows)
    page.add(_bit_map(cells))


def _bit_map(fields: list[tuple[int, int, str]]) -> str:
    """Return the bits of a PDO as a table, a row for each octet: bit 7 on the left."""
    if not fields:
        return ""
    size = -(-fields[-1][1] // 8)
    if size > 8:
        return ""
    lines = [
        "<tr><th>octet</th>"
        + "".join(f"<th>{b}</th>" for b in range(7, -1, -1))
        + "</tr>"
    ]
    for octet in range(size):
        cells, bit = [], 8 * octet + 8
        for start, end, name in reversed(fields):
            low, high = max(start, 8 * octet), min(end, bit)
            if low >= high:
                continue
            if high < bit:
                cells.append(f'<td colspan="{bit - high}"></td>')
            part = (
                f" {low - start}"
                if high - low == 1
                else f" {high - start - 1} to {low - start}"
            )
            shown = text(name) + (part if end - start > high - low else "")
            cells.append(f'<td colspan="{high - low}">{shown}</td>')
            bit = low
        if bit > 8 * octet:
            cells.append(f'<td colspan="{bit - 8 * octet}"></td>')
        lines.append(f"<tr><th>{octet}</th>{''.join(cells)}</tr>")
    body = "\n".join(lines)
    return Markdown(f'<table class="bits">\n{body}\n</table>')


def add_bus(content: Content, page: Page, bus: Bus) -> None:
    """Fill the page of a bus."""
    sent = messages(bus)
    busy = f"{load(sent, bus.bit_rate):.1%}"
    nodes = counted(["node"] * len(bus.nodes))
    page.summary = f"{nodes}, {bus.bit_rate} kbit/s, load {busy}"
    page.add(f"Defined in {code(bus.key)}.")
    page.table(
        ("property", "value"),
        [
            ("bit rate", f"{bus.bit_rate} kbit/s"),
            ("load", busy),
            ("manager", f"node {bus.manager}"),
            ("SYNC", f"every {bus.sync:g} s" if bus.sync else "none"),
            ("heartbeat", f"every {bus.heartbeat:g} s" if bus.heartbeat else "none"),
        ],
    )
    page.heading(2, "Nodes")
    page.table(
        ("node", "name", "device", "written at start-up"),
        [
            (
                node.id,
                code(node.name),
                content.places.link(Kind.DEVICE, node.kind.module, page.path),
                Markdown(
                    "<br>".join(
                        code(f"{i:04X}h:{s:X} = {value_of(v, node.id)}")
                        for (i, s), v in node.values
                    )
                ),
            )
            for node in bus.nodes
        ],
    )
    if bus.links:
        page.heading(2, "PDO links")
        rows = [
            (
                f"{link.source[0]} TPDO {link.source[1]}",
                f"{link.target[0]} RPDO {link.target[1]}",
            )
            for link in bus.links
        ]
        page.table(("from", "to"), rows)
    page.heading(2, "Messages")
    page.table(
        ("identifier", "message", "octets", "period", "there within"),
        [
            (
                f"{t.message.identifier:03X}h",
                t.message.name,
                t.message.octets,
                f"{t.message.period / 1e6:g} ms",
                "no bound" if t.response is None else f"{t.response / 1e6:.3f} ms",
            )
            for t in response_times(sent, bus.bit_rate)
        ],
    )
