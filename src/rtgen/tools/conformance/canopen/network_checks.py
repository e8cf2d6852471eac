"""The checks of resets, lost heartbeats, and the error history of a node."""

from __future__ import annotations

from typing import Final

from rtgen.facts.write_order import CONSUMERS, consumed_node
from rtgen.runtime.canopen.wire.emergency import (
    HEARTBEAT_LOST,
    PDO_TOO_LONG,
    PDO_TOO_SHORT,
)
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MAX_DATA,
    MAX_NODE_ID,
    MILLISECOND,
    Frame,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.canopen.pdo_checks import receptions
from rtgen.tools.conformance.canopen.sdo_checks import HEARTBEAT, writable_heartbeat
from rtgen.tools.conformance.check import ACTUATE, Problems, SkipError, check

_CONSUMER: Final = (0x1016, 1)
_GUARD_TIME: Final = (0x100C, 0)
_LIFE_FACTOR: Final = (0x100D, 0)
_HISTORY: Final = 0x1003
_REGISTER: Final = (0x1001, 0)
_ERROR_RESET: Final = 0x0000
_PERIOD: Final = 100
"""Heartbeat and guard time of the checks, in ms."""


@check("nmt.reset", "boot-up after reset node", "CiA 301, 7.3.2.2", ACTUATE)
def reset(node: NodeUnderTest) -> Problems:
    """Check that reset node leads to the boot-up message, and to a node that answers."""
    problem = node.restart(NmtCommand.RESET_NODE)
    if problem != NmtState.INITIALISING:
        yield f"no boot-up within {node.bounds.boot // MILLISECOND} ms"
        return
    yield None if node.read_code((0x1000, 0)) is None else "1000h is refused after it"


@check("nmt.parameters", "reset communication reverts parameters", "CiA 301, 7.3.2.2.1")
def parameters_reverted(node: NodeUnderTest) -> Problems:
    """Check that reset communication reverts 1017h."""
    writable_heartbeat(node)
    node.restart()
    before = node.upload(HEARTBEAT)
    node.download(HEARTBEAT, bytes((before[0] ^ 1,)) + before[1:])
    node.restart()
    now = node.upload(HEARTBEAT)
    yield None if now == before else f"1017h is {now.hex()} then, not {before.hex()}"
    if now != before:
        node.download(HEARTBEAT, before)


def _emergencies(node: NodeUnderTest) -> int:
    if node.emergencies is None:
        raise SkipError("the node has no valid 1014h, so it sends no emergencies")
    return node.emergencies


def _emergency(node: NodeUnderTest, within: int) -> int | None:
    """Return the code of the next emergency of the node, or None. Raises SkipError."""
    frame = node.await_frame(_emergencies(node), within)
    return None if frame is None else int.from_bytes(frame.data[:2], "little")


def _is(code: int | None, expected: int, what: str) -> str | None:
    text = "none" if code is None else f"{code:04X}h"
    problem = f"{what}: the emergency is {text}, not {expected:04X}h"
    return None if code == expected else problem


def _unwatched(node: NodeUnderTest) -> int:
    """Return the highest node-id of which no entry of 1016h consumes the heartbeat."""
    taken = {node.id}
    for (index, sub), octets in node.values.items():
        if index == CONSUMERS and sub:
            taken.add(consumed_node(int.from_bytes(octets, "little")) or 0)
    return max(set(range(1, MAX_NODE_ID + 1)) - taken)


@check(
    "heartbeat.consumer",
    "a lost heartbeat is reported",
    "CiA 301, 7.2.8.3.2.2",
    ACTUATE,
)
def consumer(node: NodeUnderTest) -> Problems:
    """Check that the node reports a lost heartbeat, and none that is in time."""
    thing = node.described.objects.get(_CONSUMER)
    if thing is None or not thing.access.writable:
        raise SkipError("1016h:1 is not described as writable")
    producer = _unwatched(node)
    beat = Frame(ERROR_CONTROL + producer, bytes((NmtState.OPERATIONAL,)))
    try:
        node.configure(_CONSUMER, producer << 16 | _PERIOD)
        for _ in range(4):
            node.line.send(beat)
            code = _emergency(node, _PERIOD * MILLISECOND // 2)
            yield None if code is None else f"emergency {code:04X}h between heartbeats"
        code = _emergency(node, 10 * _PERIOD * MILLISECOND)
        yield _is(code, HEARTBEAT_LOST, "a heartbeat was lost")
    finally:
        node.restart()


@check("guarding.life", "a lost guard is reported", "CiA 301, 7.2.8.3.2.1", ACTUATE)
def life_guarding(node: NodeUnderTest) -> Problems:
    """Check that a guarded node reports the end of guarding."""
    things = [node.described.objects.get(n) for n in (_GUARD_TIME, _LIFE_FACTOR)]
    if not all(thing is not None and thing.access.writable for thing in things):
        raise SkipError("100Ch and 100Dh are not described as writable")
    if not node.line.remote_frames:
        raise SkipError("this interface carries no remote frames")
    try:
        if node.has(*HEARTBEAT):
            node.download(HEARTBEAT, bytes(2))
        node.configure(_GUARD_TIME, _PERIOD)
        node.configure(_LIFE_FACTOR, 2)
        for _ in range(3):
            node.line.send(Frame(ERROR_CONTROL + node.id, remote=True))
            code = _emergency(node, _PERIOD * MILLISECOND)
            yield None if code is None else f"emergency {code:04X}h while it is guarded"
        code = _emergency(node, 10 * _PERIOD * MILLISECOND)
        yield _is(code, HEARTBEAT_LOST, "the guard has gone")
    finally:
        node.restart()


def _reported(node: NodeUnderTest) -> bytes:
    """Return the emergency for a short RPDO. Raises SkipError."""
    frame = node.await_frame(_emergencies(node), node.bounds.answer)
    code = None if frame is None else int.from_bytes(frame.data[:2], "little")
    if frame is None or code != PDO_TOO_SHORT or len(frame.data) != MAX_DATA:
        raise SkipError("a short RPDO is not reported, see pdo.length")
    return frame.data


@check("emcy.reset", "the end of an error is reported", "CiA 301, 7.2.7.2", ACTUATE)
def error_reset(node: NodeUnderTest) -> Problems:
    """Check that the end of an error is reported by 0000h, and cleared in the register."""
    received = next(receptions(node), None)
    if received is None:
        raise SkipError("no RPDO can be too short")
    _, can_id, mapped = received
    whole = b"".join(node.upload(thing.number) for thing in mapped)
    node.command(NmtCommand.START)
    try:
        node.line.send(Frame(can_id, whole[:-1]))
        _reported(node)
        node.line.send(Frame(can_id, whole))
        code = _emergency(node, node.bounds.answer)
        yield _is(code, _ERROR_RESET, "a right RPDO followed a short one")
        register = node.upload(_REGISTER)[0]
        yield f"1001h is {register:02X}h then" if register & 1 else None
    finally:
        node.restart()


def _second_entry(node: NodeUnderTest, can_id: int, short: bytes) -> str | None:
    """Return a problem unless a second error comes first in the history."""
    long = short + bytes(2)
    if len(long) > MAX_DATA or not node.has(_HISTORY, 2):
        return None
    node.line.send(Frame(can_id, long))
    code = _emergency(node, node.bounds.answer)
    if code == _ERROR_RESET:
        code = _emergency(node, node.bounds.answer)
    if code != PDO_TOO_LONG:
        return None
    codes = [
        int.from_bytes(node.upload((_HISTORY, sub))[:2], "little") for sub in (1, 2)
    ]
    text = " and ".join(f"{code:04X}h" for code in codes)
    problem = f"1003h:1 and 2 are {text} after {PDO_TOO_SHORT:04X}h and {code:04X}h"
    return None if codes == [code, PDO_TOO_SHORT] else problem


@check("emcy.entry", "errors are entered in the history", "CiA 301, 7.5.2.4", ACTUATE)
def entries(node: NodeUnderTest) -> Problems:
    """Check that an error is in the history and the register; 0 empties the history."""
    received = next(receptions(node), None)
    if received is None or not node.has(_HISTORY, 1):
        raise SkipError("no RPDO can be too short, or 1003h is not described")
    _, can_id, mapped = received
    short = b"".join(node.upload(thing.number) for thing in mapped)[:-1]
    node.command(NmtCommand.START)
    try:
        node.line.send(Frame(can_id, short))
        message = _reported(node)
        count = node.upload((_HISTORY, 0))[0]
        yield None if count else "1003h counts no error after an emergency"
        newest = int.from_bytes(node.upload((_HISTORY, 1)), "little") & 0xFFFF
        problem = f"1003h:1 is {newest:04X}h after emergency {PDO_TOO_SHORT:04X}h"
        yield None if newest == PDO_TOO_SHORT else problem
        register = node.upload(_REGISTER)[0]
        problem = f"1001h is {register:02X}h, the emergency has {message[2]:02X}h"
        yield None if register == message[2] else problem
        yield None if register & 1 else f"1001h is {register:02X}h with an error"
        yield _second_entry(node, can_id, short)
        if node.described.objects[_HISTORY, 0].access.writable:
            node.download((_HISTORY, 0), b"\0")
            count = node.upload((_HISTORY, 0))[0]
            yield f"1003h counts {count} errors after 0 was written" if count else None
    finally:
        node.restart()
