"""Checks of boot-up, heartbeat, node guarding and NMT commands (CiA 301, 7.2.8, 7.3.2)."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, MILLISECOND, NMT, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.tools.conformance.canopen.node import NodeUnderTest, SilenceError
from rtgen.tools.conformance.canopen.sdo_checks import HEARTBEAT, writable_heartbeat
from rtgen.tools.conformance.check import ACTUATE, Problems, SkipError, check

_GUARD_TIME: Final = (0x100C, 0)
_STARTUP: Final = (0x1F80, 0)
_PERIOD: Final = 100
"""Heartbeat period of the checks, in ms."""
_OTHER_PERIOD: Final = 70
"""The period for a node that has the first one already."""
_QUIET: Final = 20 * MILLISECOND
"""Time in which a second boot-up message would follow."""
_NO_NODE: Final = 255
_NO_COMMAND: Final = 0x7F
_BEATS: Final = 5


@check("nmt.boot-up", "boot-up after reset communication", "CiA 301, 7.3.2.2")
def boot_up(node: NodeUnderTest) -> Problems:
    """Check that reset communication leads to the boot-up message, and PRE-OPERATIONAL."""
    if node.restart() != NmtState.INITIALISING:
        yield f"no boot-up within {node.bounds.boot // MILLISECOND} ms"
        return
    again = node.await_frame(ERROR_CONTROL + node.id, _QUIET)
    is_second = again is not None and again.data == b"\0"
    yield "a second boot-up message follows" if is_second else None
    yield None if node.read_code((0x1000, 0)) is None else "1000h is refused after it"
    if not node.has(*HEARTBEAT) or node.has(*_STARTUP):
        return
    if not node.described.objects[HEARTBEAT].access.writable:
        return
    if not node.allows(HEARTBEAT, _PERIOD):
        return
    before = node.upload(HEARTBEAT)
    node.configure(HEARTBEAT, _PERIOD)
    state = node.await_state([NmtState.PRE_OPERATIONAL], 3 * _PERIOD * MILLISECOND)
    node.download(HEARTBEAT, before)
    text = "nothing" if state is None else f"{state:02X}h"
    is_there = state == NmtState.PRE_OPERATIONAL
    yield None if is_there else f"the heartbeat shows {text} after it"


@check("heartbeat", "the heartbeat keeps its period", "CiA 301, 7.2.8.3.2.2")
def heartbeat(node: NodeUnderTest) -> Problems:
    """Check that 1017h starts the heartbeat with its period, and 0 stops it."""
    before = writable_heartbeat(node)
    first = _PERIOD.to_bytes(2, "little")
    period = _OTHER_PERIOD if before == first else _PERIOD
    try:
        node.configure(HEARTBEAT, period)
        read = int.from_bytes(node.upload(HEARTBEAT), "little")
        yield (
            None if read == period else f"1017h is {read} after {period} was written"
        )
        times = []
        for _ in range(_BEATS + 1):
            frame = node.await_frame(ERROR_CONTROL + node.id, 10 * period * MILLISECOND)
            if frame is None:
                yield f"no heartbeat within {10 * period} ms"
                return
            times.append(node.line.now())
        mean = (times[-1] - times[0]) / _BEATS / MILLISECOND
        fits = abs(mean - period) <= node.bounds.period_tolerance * period
        yield None if fits else f"a period of {mean:.0f} ms, {period} was written"
        node.download(HEARTBEAT, bytes(2))
        node.await_frame(ERROR_CONTROL + node.id, period * MILLISECOND // 4)
        late = node.await_frame(ERROR_CONTROL + node.id, 3 * period * MILLISECOND)
        yield None if late is None else "the heartbeat goes on after 0 was written"
    finally:
        node.download(HEARTBEAT, before)


@check("guarding", "node guarding", "CiA 301, 7.2.8.3.2.1")
def guarding(node: NodeUnderTest) -> Problems:
    """Check that remote frames are answered with the state and an alternating bit."""
    if not node.has(*_GUARD_TIME):
        raise SkipError("100Ch is not described")
    if not node.line.remote_frames:
        raise SkipError("this interface carries no remote frames")
    before = node.upload(HEARTBEAT) if node.has(*HEARTBEAT) else bytes(2)
    if any(before):
        node.download(HEARTBEAT, bytes(2))
    try:
        toggles = []
        for _ in range(3):
            node.line.send(Frame(ERROR_CONTROL + node.id, remote=True))
            frame = node.await_frame(ERROR_CONTROL + node.id, node.bounds.answer)
            if frame is None or len(frame.data) != 1:
                yield "no answer to a remote frame of node guarding"
                return
            toggles.append(frame.data[0] >> 7)
        alternating = toggles[0] != toggles[1] != toggles[2]
        yield None if alternating else f"toggle bits {toggles}"
    finally:
        if any(before):
            node.download(HEARTBEAT, before)


@check("nmt.stopped", "a stopped node serves no SDO", "CiA 301, 7.3.2.2.4")
def stopped(node: NodeUnderTest) -> Problems:
    """Check that SDO is not served while stopped, and is again in PRE-OPERATIONAL."""
    node.command(NmtCommand.STOP)
    try:
        node.upload((0x1000, 0))
        yield "a stopped node answers an SDO"
    except SilenceError:
        yield None
    finally:
        node.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    yield None if node.read_code((0x1000, 0)) is None else "1000h is refused after it"


@check("nmt.states", "NMT commands lead to their states", "CiA 301, 7.3.2", ACTUATE)
def states(node: NodeUnderTest) -> Problems:
    """Check that each NMT command leads to its state, as shown by the heartbeat."""
    before = writable_heartbeat(node)
    node.configure(HEARTBEAT, _PERIOD)
    try:
        for command, expected in (
            (NmtCommand.START, NmtState.OPERATIONAL),
            (NmtCommand.STOP, NmtState.STOPPED),
            (NmtCommand.START, NmtState.OPERATIONAL),
            (NmtCommand.ENTER_PRE_OPERATIONAL, NmtState.PRE_OPERATIONAL),
            (NmtCommand.START, NmtState.OPERATIONAL),
        ):
            node.command(command)
            state = node.await_state([expected], 10 * _PERIOD * MILLISECOND)
            text = "nothing" if state is None else f"{state:02X}h"
            name = command.name.replace("_", " ")
            yield None if state == expected else f"{name}: the heartbeat shows {text}"
        for data, what in (
            (bytes((NmtCommand.STOP, _NO_NODE)), f"a command to node {_NO_NODE}"),
            (bytes((_NO_COMMAND, node.id)), f"command {_NO_COMMAND:02X}h"),
        ):
            node.line.send(Frame(NMT, data))
            for _ in range(2):
                state = node.await_state(NmtState, 10 * _PERIOD * MILLISECOND)
            fits = state == NmtState.OPERATIONAL
            yield None if fits else f"{what} is not ignored"
    finally:
        node.command(NmtCommand.ENTER_PRE_OPERATIONAL)
        node.download(HEARTBEAT, before)
