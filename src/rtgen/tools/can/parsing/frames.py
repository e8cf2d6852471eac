"""Parses frames as users write them: `181#0102`, `nmt start left`, `left.rpdo1 Controlword=6`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

from rtgen.runtime.canopen.values import ObjectValueError, to_bits
from rtgen.runtime.canopen.wire.frames import SYNC, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, command_frame
from rtgen.tools.can.decoding.node_index import DescribedNode, NodeIndex
from rtgen.tools.can.decoding.pdo_fields import Route, routes
from rtgen.tools.can.parsing.values import parsed_value
from rtgen.tools.kit.exits import Refusal

FORMS = "ID#HEX, ID#R, sync, nmt COMMAND NODE, or NODE.rpdoN OBJECT=VALUE ..."

_RAW = re.compile(r"(?P<id>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?P<data>R|[0-9A-Fa-f.]*)")
_PDO = re.compile(r"(?P<node>.+)\.(?P<pdo>[tr]pdo[1-9]\d{0,2})", re.IGNORECASE)
_COMMANDS = {
    "start": NmtCommand.START,
    "stop": NmtCommand.STOP,
    "pre-operational": NmtCommand.ENTER_PRE_OPERATIONAL,
    "reset-node": NmtCommand.RESET_NODE,
    "reset-communication": NmtCommand.RESET_COMMUNICATION,
}


def frame_of_text(text: str, node_index: NodeIndex) -> Frame:
    """Parse one frame. Raises Refusal."""
    words = text.split()
    head = words[0] if words else ""
    if "#" in head and len(words) == 1:
        return _raw(head)
    if head.lower() == "sync" and len(words) <= 2:
        return _sync(words[1:])
    if head.lower() == "nmt" and len(words) == 3:
        return _command(words[1], words[2], node_index)
    if _PDO.fullmatch(head):
        return _pdo(head, words[1:], node_index)
    raise Refusal(f"{text!r} is not a frame: write {FORMS}")


def _raw(text: str) -> Frame:
    match = _RAW.fullmatch(text)
    try:
        if match is None:
            raise ValueError(text)
        can_id, extended = int(match["id"], 16), len(match["id"]) > 3
        if match["data"] == "R":
            return Frame(can_id, remote=True, extended=extended)
        return Frame(
            can_id, bytes.fromhex(match["data"].replace(".", "")), False, extended
        )
    except ValueError as error:
        raise Refusal(
            f"{text!r} is not a frame: ID is 3 or 8 hexadecimal digits (up to 7FF or 1FFFFFFF), "
            "the data are up to 8 octets in hex, or R"
        ) from error


def _sync(words: list[str]) -> Frame:
    if not words:
        return Frame(SYNC)
    try:
        return Frame(SYNC, int(words[0]).to_bytes(1, "little"))
    except (ValueError, OverflowError) as error:
        raise Refusal(f"{words[0]!r} is not a counter of SYNC (0 to 255)") from error


def _command(name: str, node: str, node_index: NodeIndex) -> Frame:
    command = _COMMANDS.get(name.lower())
    if command is None:
        raise Refusal(f"{name!r} is not an NMT command: {', '.join(_COMMANDS)}")
    return command_frame(command, 0 if node == "all" else node_index.node(node))


def _pdo(head: str, assignments: list[str], node_index: NodeIndex) -> Frame:
    name, _, pdo = head.rpartition(".")
    node = node_index.nodes.get(node_index.node(name))
    if node is None:
        raise Refusal(f"{name} is not described: give --bus or --eds, or write ID#HEX")
    routes_by_name = {
        route.pdo: (key, route) for key, route in routes(node, node.parameters)
    }
    if pdo.lower() not in routes_by_name:
        known_pdos = ", ".join(sorted(routes_by_name)) or "none"
        raise Refusal(f"{node.name} has no valid {pdo}; there are: {known_pdos}")
    (can_id, extended), route = routes_by_name[pdo.lower()]
    data = _packed(node, route, assignments)
    return Frame(can_id, data, extended=extended)


def _packed(node: DescribedNode, route: Route, assignments: Iterable[str]) -> bytes:
    """Return the data of a PDO; objects without an assignment are 0."""
    mapped = {s.thing.name.lower(): s for s in route.mapped}
    given: set[str] = set()
    whole = 0
    for text in assignments:
        name, equals, value = text.partition("=")
        if not equals:
            raise Refusal(f"{text!r} is not OBJECT=VALUE")
        entry = mapped.get(name.lower())
        if entry is None:
            close = get_close_matches(name.lower(), mapped, n=1)
            names = ", ".join(s.thing.name for s in route.mapped)
            hint = f"did you mean {mapped[close[0]].thing.name}?" if close else ""
            detail = hint or f"it has {names}"
            raise Refusal(f"{node.name}.{route.pdo} has no {name!r}; {detail}")
        thing = entry.thing
        if thing.name in given:
            raise Refusal(f"{node.name}.{route.pdo}: {thing.name} is given twice")
        given.add(thing.name)
        try:
            raw = to_bits(thing.kind, parsed_value(thing, value), entry.bits)
        except ObjectValueError as error:
            raise Refusal(f"{thing.name}: {error}") from error
        whole |= raw << entry.first
    return whole.to_bytes(route.octets, "little")
