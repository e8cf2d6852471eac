"""The checks of layer setting services (CiA 305)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from rtgen.runtime.canopen.wire import lss, lss_master
from rtgen.runtime.canopen.wire.frames import LSS_REQUEST, LSS_RESPONSE, Frame
from rtgen.runtime.canopen.wire.lss import LssCommand
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.check import Problems, SkipError, check

_IDENTITY: Final = 0x1018
_SELECTION: Final = (
    *(LssCommand.SWITCH_VENDOR, LssCommand.SWITCH_PRODUCT),
    *(LssCommand.SWITCH_REVISION, LssCommand.SWITCH_SERIAL),
)
_PARTS: Final = ("vendor-id", "product code", "revision number", "serial number")
_IDENTIFICATION: Final = (
    *(LssCommand.IDENTIFY_VENDOR, LssCommand.IDENTIFY_PRODUCT),
    *(LssCommand.IDENTIFY_REVISION_LOW, LssCommand.IDENTIFY_REVISION_HIGH),
    *(LssCommand.IDENTIFY_SERIAL_LOW, LssCommand.IDENTIFY_SERIAL_HIGH),
)
_INQUIRIES: Final = (
    *(LssCommand.INQUIRE_VENDOR, LssCommand.INQUIRE_PRODUCT),
    *(LssCommand.INQUIRE_REVISION, LssCommand.INQUIRE_SERIAL),
)
_NO_NODE_ID: Final = 128
_NO_BIT_RATE: Final = 0x63
"""An index that no bit timing table has."""


def _address(node: NodeUnderTest) -> list[int]:
    """Return the LSS address of the node. Raises SkipError."""
    if not node.described.device.info.lss:
        raise SkipError("the description has no LSS")
    numbers = [node.values.get((_IDENTITY, sub)) for sub in range(1, 5)]
    address = [int.from_bytes(each, "little") for each in numbers if each]
    if len(address) < len(numbers):
        raise SkipError("its identity could not be read")
    return address


def _ask(node: NodeUnderTest, data: bytes, within: int | None = None) -> bytes:
    """Return the response to a message; empty without a response."""
    node.line.send(Frame(LSS_REQUEST, data))
    frame = node.await_frame(LSS_RESPONSE, within or node.bounds.answer)
    return b"" if frame is None else frame.data


def _select(node: NodeUnderTest, address: list[int], within: int | None = None) -> int:
    """Return how many nodes confirm that an address selects them; 2 for more."""
    _release(node)
    *first, last = map(lss.message, _SELECTION, address)
    for data in first:
        node.line.send(Frame(LSS_REQUEST, data))
    confirmed = bytes((LssCommand.SWITCHED,))
    if _ask(node, last, within)[:1] != confirmed:
        return 0
    again = node.await_frame(LSS_RESPONSE, lss_master.TIMEOUT)
    return 1 if again is None or again.data[:1] != confirmed else 2


def _release(node: NodeUnderTest) -> None:
    waiting = lss.message(LssCommand.SWITCH_GLOBAL, lss.WAITING, 1)
    node.line.send(Frame(LSS_REQUEST, waiting))


@contextmanager
def _selected(node: NodeUnderTest) -> Iterator[list[int]]:
    """Context in which the node is in the configuration state. Raises SkipError."""
    address = _address(node)
    try:
        if _select(node, address) != 1:
            raise SkipError("its identity does not select it alone, see lss.address")
        yield address
    finally:
        _release(node)


def _problem(what: str, answer: bytes, expected: bytes) -> str | None:
    octets = answer.hex(" ") or "no answer"
    return None if answer.startswith(expected) else f"{what}: {octets}"


@check("lss.address", "selected only by its LSS address", "CiA 305, 3.7")
def lss_address(node: NodeUnderTest) -> Problems:
    """Check that LSS selects the node by its identity only, and reports its node-id."""
    address = _address(node)
    try:
        for part, name in enumerate(_PARTS):
            other = list(address)
            other[part] ^= 1
            response = _select(node, other, lss_master.TIMEOUT)
            yield f"it is selected by another {name}" if response else None
        selected = _select(node, address)
        if not selected:
            yield "it is not selected by its identity"
        elif selected > 1:
            yield "another node of the bus has the same LSS address (1018h)"
        else:
            command = LssCommand.INQUIRE_NODE_ID
            answer = _ask(node, lss.message(command))
            yield _problem("its node-id by LSS", answer, bytes((command, node.id)))
            _release(node)
            answer = _ask(node, lss.message(command), lss_master.TIMEOUT)
            yield "it answers in the waiting state" if answer else None
    finally:
        _release(node)


@check("lss.identify", "identifies itself in a range", "CiA 305, 3.7")
def lss_identify(node: NodeUnderTest) -> Problems:
    """Check that the node identifies itself for ranges with its address, and no others."""
    address = _address(node)
    identified = bytes((LssCommand.IDENTIFIED,))
    low = address[3] ^ 1
    for serials, expected in (((low, low), b""), ((address[3],) * 2, identified)):
        numbers = (*address[:2], *(address[2],) * 2, *serials)
        *first, last = map(lss.message, _IDENTIFICATION, numbers)
        for data in first:
            node.line.send(Frame(LSS_REQUEST, data))
        answer = _ask(node, last, None if expected else lss_master.TIMEOUT)
        octets = answer.hex(" ") or "no answer"
        fits = answer[:1] == expected
        yield None if fits else f"serial numbers {serials[0]} to {serials[1]}: {octets}"


@check("lss.identity", "reports its identity", "CiA 305, 3.11")
def lss_identity(node: NodeUnderTest) -> Problems:
    """Check that LSS reports the same parts of the identity as 1018h."""
    with _selected(node) as address:
        for command, number in zip(_INQUIRIES, address, strict=True):
            answer = _ask(node, lss.message(command))
            expected = bytes((command,)) + number.to_bytes(4, "little")
            yield _problem(command.name.lower().replace("_", " "), answer, expected)


@check(
    "lss.refusals", "node-ids and bit rates are accepted and refused", "CiA 305, 3.9"
)
def lss_refusals(node: NodeUnderTest) -> Problems:
    """Check that its node-id is accepted, and invalid node-ids and bit rates are rejected."""
    with _selected(node):
        own = lss.message(LssCommand.CONFIGURE_NODE_ID, node.id, 1)
        accepted = bytes((LssCommand.CONFIGURE_NODE_ID, 0))
        yield _problem("its own node-id is not accepted", _ask(node, own), accepted)
        for command, value, size in (
            (LssCommand.CONFIGURE_NODE_ID, _NO_NODE_ID, 1),
            (LssCommand.CONFIGURE_BIT_TIMING, _NO_BIT_RATE << 8, 2),
        ):
            answer = _ask(node, lss.message(command, value, size))
            refused = bytes((command, lss.OUT_OF_RANGE))
            what = command.name.lower().replace("_", " ")
            yield _problem(f"{what} {value:X}h is not refused", answer, refused)
        command = LssCommand.INQUIRE_NODE_ID
        answer = _ask(node, lss.message(command))
        yield _problem("its node-id after that", answer, bytes((command, node.id)))
