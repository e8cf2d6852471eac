"""The command `rtgen can scan`: finds the nodes of a bus and compares them with a bus file."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import click

from rtgen.cli.can.node_file import (
    NodeFileOptions,
    describe_node,
    node_to_read,
    with_node_file,
)
from rtgen.cli.can.options import with_bus, with_nodes
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import table
from rtgen.runtime.canopen.wire.lss import LssAddress
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.decoding.node_index import NodeIndex
from rtgen.tools.can.live.bus_session import BusSession
from rtgen.tools.can.live.live_bus import opened
from rtgen.tools.can.live.lss_scan import unconfigured
from rtgen.tools.can.live.scanning import Found, scanned
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK


@dataclass(slots=True)
class _Row:
    """The output line of one node-id."""

    node: int
    name: str
    state: str
    device: str
    verdict: str
    identity: tuple[int | None, ...] = field(default=())


@command("scan")
@click.option(
    "--for",
    "seconds",
    type=FiniteRange(min=0.01),
    default=1.0,
    show_default=True,
    metavar="SECONDS",
    help="Time to wait for heartbeats and responses.",
)
@click.option(
    "--no-lss", is_flag=True, help="Do not search for nodes without a node-id."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@with_node_file
@with_nodes
@with_bus
@with_console
def scan_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    reading: NodeFileOptions,
    seconds: float,
    no_lss: bool,
    as_json: bool,
) -> int:
    """Find the nodes of a bus, and compare them with a bus file.

    The device type of each node-id is read by SDO, then identity and name of nodes that respond;
    heartbeats reveal nodes that do not serve SDO now. LSS fastscan finds nodes without a node-id,
    and does not change them. Exit code 1: with --bus or --eds, a node is missing or different.

    --eds NODE reads the objects of a node without a description into an EDS: it writes nothing to
    the node, takes the EDS that the node has stored, and marks what is a guess. Ctrl-C leaves a
    partial file, which says so.
    """
    node, node_files = node_to_read(node_files)
    if node is not None:
        return describe_node(console, access, node_files, node, seconds, reading)
    node_index = node_files.read(console)
    with opened(access.on(node_index)) as bus:
        nodes, strangers = scanned(bus, seconds), list[LssAddress]()
        if not no_lss:
            strangers = unconfigured(BusSession(bus))
    lines = [
        _line(node_index, nodes.get(node_id), node_id)
        for node_id in _ids(node_index, nodes)
    ]
    wrong = any(line.verdict not in ("", "as described") for line in lines)
    if as_json:
        document = {
            "nodes": [_json(line) for line in lines],
            "unconfigured": [address._asdict() for address in strangers],
        }
        write_out(f"{json.dumps(document)}\n")
    else:
        _print(lines, strangers)
        console.say(
            f"{len(nodes)} nodes answer, {len(strangers)} have no node-id"
            if not no_lss
            else f"{len(nodes)} nodes answer"
        )
    return NO if wrong and node_index.nodes else OK


def _ids(node_index: NodeIndex, nodes: dict[int, Found]) -> list[int]:
    return sorted({*node_index.nodes, *nodes})


def _line(node_index: NodeIndex, node: Found | None, node_id: int) -> _Row:
    name = node_index.name(node_id)
    if node is None:
        return _Row(node_id, name, "", "", "missing")
    return _Row(
        node_id,
        name,
        node.state_text,
        node.device_text,
        _verdict(node_index, node, node_id),
        node.identity,
    )


def _verdict(node_index: NodeIndex, answers: Found, node_id: int) -> str:
    """Return how the node differs from its description; empty if there is none to compare."""
    node = node_index.nodes.get(node_id)
    if node is None:
        if not node_index.nodes or node_id == node_index.manager:
            return ""
        return "not described"
    if answers.identity[0] is None:
        return "no identity"
    parts = ("device type", "vendor", "product", "revision")
    for part, expected, actual in zip(
        parts, node.identity, answers.identity, strict=False
    ):
        if part == "revision" and expected is not None and actual is not None:
            # Devices of the same major revision behave identically (CiA 301, 7.5.2.21).
            expected, actual = expected >> 16, actual >> 16
        if expected is not None and actual is not None and expected != actual:
            return f"{part} 0x{actual:X}, described is 0x{expected:X}"
    return "as described"


def _json(line: _Row) -> dict[str, object]:
    parts = ("device_type", "vendor", "product", "revision", "serial")
    result: dict[str, object] = {"node": line.node, "name": line.name}
    if line.state:
        result["state"] = line.state
    result |= dict(zip(parts, line.identity, strict=False))
    if line.device:
        result["device"] = line.device
    if line.verdict:
        result["verdict"] = line.verdict
    return result


def _print(lines: list[_Row], strangers: list[LssAddress]) -> None:
    if not lines and not strangers:
        return
    rows = [("id", *map(translated_word, ("node", "state", "device")), "")]
    rows += [
        (f"{x.node}", x.name, x.state, x.device, translated_word(x.verdict))
        for x in lines
    ]
    for address in strangers:
        numbers = (
            f"vendor 0x{address.vendor:X} product 0x{address.product:X} "
            f"revision 0x{address.revision:X} serial {address.serial}"
        )
        rows.append(("-", "", translated("no node-id"), numbers, ""))
    for line in table(rows):
        write_out(f"{line}\n")
