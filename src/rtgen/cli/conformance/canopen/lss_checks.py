"""The check of layer setting services (CiA 305)."""

from __future__ import annotations

from typing import Final

from rtgen.cli.conformance.canopen.node import NodeUnderTest
from rtgen.cli.conformance.check import Problems, SkipError
from rtgen.runtime.canopen.wire import lss, lss_master
from rtgen.runtime.canopen.wire.frames import LSS_REQUEST, LSS_RESPONSE, Frame
from rtgen.runtime.canopen.wire.lss import LssCommand

_IDENTITY: Final = 0x1018


def lss_address(node: NodeUnderTest) -> Problems:
    """Check that LSS selects the node by its identity only, and reports its node-id."""
    if not node.described.device.info.lss:
        raise SkipError("the description has no LSS")
    numbers = [node.values.get((_IDENTITY, sub)) for sub in range(1, 5)]
    address = [int.from_bytes(each, "little") for each in numbers if each]
    if len(address) < len(numbers):
        raise SkipError("its identity could not be read")
    other = [*address[:3], address[3] ^ 1]
    waiting = lss.message(LssCommand.SWITCH_GLOBAL, lss.WAITING, 1)
    selection = (
        *(LssCommand.SWITCH_VENDOR, LssCommand.SWITCH_PRODUCT),
        *(LssCommand.SWITCH_REVISION, LssCommand.SWITCH_SERIAL),
    )

    def ask(data: bytes, within: int) -> bytes:
        node.line.send(Frame(LSS_REQUEST, data))
        found = node.await_frame(LSS_RESPONSE, within)
        return b"" if found is None else found.data

    def select(wanted: list[int], within: int) -> bytes:
        node.line.send(Frame(LSS_REQUEST, waiting))
        *first, last = map(lss.message, selection, wanted)
        for data in first:
            node.line.send(Frame(LSS_REQUEST, data))
        return ask(last, within)

    try:
        found = select(other, lss_master.TIMEOUT)
        yield None if not found else "it is selected by another serial number"
        found = select(address, node.bounds.answer)
        selected = found[:1] == bytes((LssCommand.SWITCHED,))
        yield None if selected else "it is not selected by its identity"
        if selected:
            found = ask(lss.message(LssCommand.INQUIRE_NODE_ID), node.bounds.answer)
            told = found[1:2] == bytes((node.id,))
            yield (
                None if told else f"its node-id by LSS: {found.hex(' ') or 'no answer'}"
            )
    finally:
        node.line.send(Frame(LSS_REQUEST, waiting))
