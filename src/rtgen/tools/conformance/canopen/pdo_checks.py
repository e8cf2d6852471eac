"""Checks of PDOs (CiA 301, 7.2.2)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from rtgen.compiler.model.canopen import Pdo, PdoDirection
from rtgen.runtime.canopen.wire.emergency import PDO_TOO_SHORT
from rtgen.runtime.canopen.wire.frames import MAX_DATA, MILLISECOND, CobId, Frame
from rtgen.tools.can.decoding.node_index import DescribedObject
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.canopen.pdo_changes import present_entries, whole_objects
from rtgen.tools.conformance.check import ACTUATE, Problems, check

_MAX_SYNCHRONOUS: Final = 240
_EVENT_DRIVEN: Final = 254
_QUIET: Final = 100 * MILLISECOND
"""Time-out after which a PDO counts as not sent."""


@check("pdo.parameters", "PDO parameters as described", "CiA 301, 7.5.2.35 to 38")
def parameters(node: NodeUnderTest) -> Problems:
    """Check that identifiers, transmission types and mappings match the description."""
    for pdo in node.described.device.pdos:
        for index in (pdo.communication, pdo.mapping):
            for number, octets in node.values.items():
                if number[0] != index:
                    continue
                values = node.described_values(number)
                expected = [value for value in values if isinstance(value, int)]
                if expected:
                    got = int.from_bytes(octets, "little")
                    choices = " or ".join(f"{value:X}h" for value in expected)
                    thing = node.described.objects[number]
                    yield (
                        None
                        if got in expected
                        else f"{thing} is {got:X}h, described is {choices}"
                    )


def _communication(node: NodeUnderTest, pdo: Pdo) -> tuple[int, CobId]:
    """Return the transmission type and the COB-ID that the node has for a PDO."""
    words = (node.values.get((pdo.communication, sub), b"") for sub in (2, 1))
    kind, cob_id = (int.from_bytes(word, "little") for word in words)
    return kind, CobId(cob_id)


@check("pdo.synchronous", "synchronous TPDOs follow SYNC", "CiA 301, 7.5.2.37", ACTUATE)
def synchronous(node: NodeUnderTest) -> Problems:
    """Check that a TPDO of transmission type n is sent every n-th SYNC, with its length."""
    problems = []
    for pdo in node.described.device.pdos:
        kind, cob_id = _communication(node, pdo)
        if (
            pdo.direction == "tpdo"
            and 1 <= kind <= _MAX_SYNCHRONOUS
            and present_entries(node, pdo)
            and cob_id.valid
        ):
            problems.append((pdo, kind, cob_id.can_id))
    with node.operational():
        for pdo, kind, can_id in problems:
            counted = 0
            bits = sum(entry.bits for entry in present_entries(node, pdo))
            for _ in range(2 * kind):
                node.synchronise()
                frame = node.await_frame(can_id, 20 * MILLISECOND)
                counted += frame is not None
                if frame is not None and 8 * len(frame.data) != (bits + 7) // 8 * 8:
                    yield f"tpdo{pdo.number}: {len(frame.data)} octets for {bits} bits"
            yield (
                None
                if counted == 2
                else f"tpdo{pdo.number}: {counted} after {2 * kind} SYNCs"
            )


def receptions(
    node: NodeUnderTest,
) -> Iterator[tuple[Pdo, int, list[DescribedObject]]]:
    """Yield the asynchronous RPDOs of whole octets, with identifiers and mapped objects."""
    for pdo in node.described.device.pdos:
        kind, cob_id = _communication(node, pdo)
        mapped = whole_objects(node, pdo)
        is_reception = pdo.direction is PdoDirection.RPDO and kind >= _EVENT_DRIVEN
        if is_reception and cob_id.valid and mapped:
            yield pdo, cob_id.can_id, mapped


@check(
    "pdo.reception", "objects get the values of an RPDO", "CiA 301, 7.2.2.2", ACTUATE
)
def reception(node: NodeUnderTest) -> Problems:
    """Check that the data of an RPDO are in its objects afterwards."""
    acting = list(receptions(node))
    with node.operational():
        for pdo, can_id, mapped in acting:
            before = [node.upload(thing.number) for thing in mapped]
            # The lowest bit of each value is inverted, and restored.
            other = [bytes((value[0] ^ 1,)) + value[1:] for value in before]
            for values in (other, before):
                node.line.send(Frame(can_id, b"".join(values)))
                now = node.values_soon(mapped, values)
                for thing, actual, sent in zip(mapped, now, values, strict=True):
                    problem = f"rpdo{pdo.number}: {thing} is {actual.hex()}, sent was {sent.hex()}"
                    yield None if actual == sent else problem


@check(
    "pdo.length",
    "RPDOs that are too short are reported, longer ones truncated",
    "CiA 301, 7.2.2.4",
    ACTUATE,
)
def wrong_lengths(node: NodeUnderTest) -> Problems:
    """Check that a short RPDO changes nothing, with an emergency, and a long one is truncated."""
    acting = list(receptions(node))
    with node.operational():
        for pdo, can_id, mapped in acting:
            before = [node.upload(thing.number) for thing in mapped]
            sent = b"".join(before)[:-1]
            if not sent:
                continue
            node.line.send(Frame(can_id, bytes((sent[0] ^ 1,)) + sent[1:]))
            if node.emergencies is not None:
                frame = node.await_frame(node.emergencies, node.bounds.answer)
                code = int.from_bytes(frame.data[:2], "little") if frame else None
                text = "none" if code is None else f"{code:04X}h"
                problem = f"rpdo{pdo.number}: the emergency is {text}"
                yield None if code == PDO_TOO_SHORT else problem
            unchanged = node.values_later(mapped) == before
            yield None if unchanged else f"rpdo{pdo.number}: its objects have changed"
        for pdo, can_id, mapped in acting:
            values = [node.upload(thing.number) for thing in mapped]
            whole = b"".join(values)
            if len(whole) == MAX_DATA:
                continue
            other = [bytes((values[0][0] ^ 1,)) + values[0][1:], *values[1:]]
            node.line.send(Frame(can_id, b"".join(other)))
            if node.values_soon(mapped, other) != other:
                continue  # `reception` reports it.
            node.line.send(Frame(can_id, whole + bytes(1)))
            problem = f"rpdo{pdo.number}: one that is too long is ignored"
            yield None if node.values_soon(mapped, values) == values else problem
            node.line.send(Frame(can_id, whole))


@check("pdo.states", "no PDOs in PRE-OPERATIONAL", "CiA 301, 7.3.2.2.5", ACTUATE)
def pre_operational(node: NodeUnderTest) -> Problems:
    """Check that a node in PRE-OPERATIONAL sends no TPDO, and ignores RPDOs."""
    acting = list(receptions(node))
    identifiers = {
        CobId(int.from_bytes(node.values[pdo.communication, 1], "little")).can_id
        for pdo in node.described.device.pdos
        if pdo.direction is PdoDirection.TPDO and (pdo.communication, 1) in node.values
    }
    node.restart()
    node.synchronise()
    end = node.line.now() + _QUIET
    sent = False
    while (frame := node.line.receive(end)) is not None:
        sent |= frame.can_id in identifiers and not frame.remote
    yield "it sends TPDOs" if sent else None
    for pdo, can_id, mapped in acting:
        before = [node.upload(thing.number) for thing in mapped]
        other = [bytes((value[0] ^ 1,)) + value[1:] for value in before]
        node.line.send(Frame(can_id, b"".join(other)))
        unchanged = node.values_later(mapped) == before
        yield None if unchanged else f"rpdo{pdo.number}: it is not ignored"
        if not unchanged:
            node.line.send(Frame(can_id, b"".join(before)))
