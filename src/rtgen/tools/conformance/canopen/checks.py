"""Checks of a CANopen node: a function each, in the order of execution."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from rtgen.compiler.model.canopen import Access
from rtgen.runtime.canopen.values import ObjectValueError, decode, encode, size
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import SdoAbort, Target
from rtgen.tools.can.decoding.node_index import DescribedObject
from rtgen.tools.conformance.canopen import network_checks, nmt_checks, pdo_changes
from rtgen.tools.conformance.canopen.lss_checks import (
    lss_address,
    lss_identify,
    lss_identity,
    lss_refusals,
)
from rtgen.tools.conformance.canopen.node import NodeUnderTest, SilenceError, refusal
from rtgen.tools.conformance.canopen.pdo_checks import (
    parameters,
    pre_operational,
    reception,
    synchronous,
    wrong_lengths,
)
from rtgen.tools.conformance.canopen.sdo_checks import (
    HEARTBEAT,
    NAME,
    abort_code,
    block_download,
    block_repeats,
    block_sizes,
    long_name,
    segments,
    writable_heartbeat,
)
from rtgen.tools.conformance.check import (
    ACTUATE,
    Permission,
    Problems,
    SkipError,
    check,
)

_SDO: Final = "CiA 301, 7.2.4.3"
_EDS: Final = "CiA 306, 4.6"
_HISTORY: Final = (0x1003, 0)
_SETTINGS: Final = (*range(0x1005, 0x1008), *range(0x1012, 0x101A), 0x1028, 0x1029)
"""Objects of the communication profile that accept their present values."""
_MAX_SILENT: Final = 5
"""Number of objects without a response after which reading stops."""
_APPLICATION: Final = 0x2000
"""The first index of the application."""
_READ_ONLY: Final = (sdo.READ_ONLY, sdo.ACCESS_UNSUPPORTED)
_WRITE_ONLY: Final = (sdo.WRITE_ONLY, sdo.ACCESS_UNSUPPORTED)
_LENGTH: Final = (sdo.LENGTH_MISMATCH, sdo.LENGTH_TOO_HIGH, sdo.LENGTH_TOO_LOW)
_TOO_HIGH: Final = (sdo.VALUE_TOO_HIGH, sdo.VALUE_INVALID)
_TOO_LOW: Final = (sdo.VALUE_TOO_LOW, sdo.VALUE_INVALID)


def _objects(node: NodeUnderTest) -> Iterator[DescribedObject]:
    yield from sorted(node.described.objects.values(), key=lambda o: o.number)


@check("sdo.read", "every readable object is read", _SDO)
def readable(node: NodeUnderTest) -> Problems:
    """Check that every object described as readable can be read."""
    silent = 0
    for thing in _objects(node):
        if thing.access.readable:
            try:
                node.values[thing.number] = node.upload(thing.number)
            except SdoAbort as abort:
                is_empty = thing.number[0] == _HISTORY[0] and abort.code == sdo.NO_DATA
                yield None if is_empty else f"{thing}: {abort}"
            except SilenceError:
                yield f"{thing}: no answer"
                silent += 1
                if silent == _MAX_SILENT:
                    raise
            else:
                yield None


@check("object.type", "values have the length of their types", _EDS)
def types(node: NodeUnderTest) -> Problems:
    for number, octets in node.values.items():
        thing = node.described.objects[number]
        expected = size(thing.kind)
        fits = expected is None or len(octets) == expected
        yield (
            None
            if fits
            else f"{thing}: {len(octets)} octets, {thing.kind} has {expected}"
        )


@check("object.limits", "values are within their limits", _EDS)
def limits(node: NodeUnderTest) -> Problems:
    """Check that values are within LowLimit and HighLimit."""
    for number, octets in node.values.items():
        thing = node.described.objects[number]
        if thing.low is None and thing.high is None:
            continue
        try:
            value = decode(thing.kind, octets)
        except ObjectValueError as error:
            yield f"{thing}: {error}"
            continue
        if isinstance(value, str | bytes):
            continue
        low, high = thing.low, thing.high
        fits = (low is None or value >= low) and (high is None or value <= high)
        yield None if fits else f"{thing} is {value}, outside {low} to {high}"


@check("object.constants", "constants and identity as described", _EDS)
def constants(node: NodeUnderTest) -> Problems:
    """Check that constants, the device type and the identity match the description."""
    identity = {(0x1018, sub) for sub in (1, 2, 3, 4)}
    described = {(0x1000, 0), *identity} - {(0x1018, 4)}
    for number, octets in node.values.items():
        thing = node.described.objects[number]
        if number in identity and not any(node.described_values(number)):
            continue  # 0 says nothing about the device (CiA 301, 7.5.2.19).
        if thing.access is Access.CONST or number in described:
            yield from _compared(node, thing, octets, "described is")


@check(
    "object.defaults",
    "values are the defaults of the description",
    _EDS,
    Permission.DEFAULTS,
)
def defaults(node: NodeUnderTest) -> Problems:
    """Check that writable objects have the described defaults; PDOs have their own check."""
    pdos = node.described.device.pdos
    compared = {index for pdo in pdos for index in (pdo.communication, pdo.mapping)}
    for number, octets in node.values.items():
        thing = node.described.objects[number]
        if number[0] not in compared and thing.access.writable:
            yield from _compared(node, thing, octets, "its default is")


def _compared(
    node: NodeUnderTest, thing: DescribedObject, octets: bytes, words: str
) -> Problems:
    """Compare a value with those of the description; yields nothing if there are none."""
    expected = node.described_values(thing.number)
    if not expected or not size(thing.kind):
        return
    try:
        fits = octets in [encode(thing.kind, value) for value in expected]
    except ObjectValueError:
        return
    choices = " or ".join(map(str, expected))
    yield None if fits else f"{thing} is {octets.hex()}, {words} {choices}"


@check("sdo.read-only", "read-only objects refuse writes", _SDO)
def read_only(node: NodeUnderTest) -> Problems:
    for thing in _objects(node):
        octets = node.values.get(thing.number)
        if not thing.access.writable and octets:
            yield refusal(thing, node.write_code(thing.number, octets), *_READ_ONLY)


@check("sdo.write-only", "write-only objects refuse reads", _SDO)
def write_only(node: NodeUnderTest) -> Problems:
    for thing in _objects(node):
        if not thing.access.readable:
            yield refusal(thing, node.read_code(thing.number), *_WRITE_ONLY)


@check("sdo.unknown", "unknown objects and sub-indices are refused", _SDO)
def unknown_objects(node: NodeUnderTest) -> Problems:
    """Check that accesses to undescribed objects and sub-indices are rejected."""
    indices = {index for index, _ in node.described.objects}
    for index in (0x0000, 0x1FFF, 0x5FFF, 0xFFFF):
        if index not in indices:
            yield refusal(f"{index:04X}h", node.read_code((index, 0)), sdo.NO_OBJECT)
            code = node.write_code((index, 0), bytes(1))
            yield refusal(f"{index:04X}h, written", code, sdo.NO_OBJECT)
    for index in sorted(indices):
        subs = {sub for i, sub in node.described.objects if i == index}
        unused = next((s for s in range(max(subs) + 1, 255)), None)
        if unused is not None:
            code = node.read_code((index, unused))
            yield refusal(f"{index:04X}h:{unused:X}", code, sdo.NO_SUBINDEX)


@check("sdo.length", "values of a wrong length are refused", _SDO)
def lengths(node: NodeUnderTest) -> Problems:
    writable_heartbeat(node)
    for octets in (bytes(1), bytes(3), bytes(4)):
        code = node.write_code(HEARTBEAT, octets)
        yield refusal(f"1017h with {len(octets)} octets", code, *_LENGTH)


@check("sdo.command", "unknown commands are refused", _SDO)
def commands(node: NodeUnderTest) -> Problems:
    """Check that unknown commands, and segments without a transfer, are rejected."""
    for first in (0xE0, 0x00, 0x60):
        answer = node.ask(bytes((first,)).ljust(8, b"\0"))
        code = abort_code(answer)
        yield refusal(f"command {first:02X}h", code, sdo.COMMAND_UNKNOWN)


@check("sdo.toggle", "a wrong toggle bit is refused", _SDO)
def toggling(node: NodeUnderTest) -> Problems:
    """Check that a segment with a wrong toggle bit ends the transfer."""
    long_name(node)
    node.ask(Target(*NAME).message(sdo.UPLOAD))
    answer = node.ask(bytes((sdo.UPLOAD_SEGMENT | sdo.TOGGLE,)).ljust(8, b"\0"))
    code = abort_code(answer)
    yield refusal("the first segment with toggle bit 1", code, sdo.TOGGLE_ERROR)
    if code is None:
        node.abandon(NAME)


@check("sdo.abort", "an aborted transfer leaves the server ready", _SDO)
def aborted(node: NodeUnderTest) -> Problems:
    """Check that after an aborted transfer the server is ready, with an unchanged value."""
    long_name(node)
    node.ask(Target(*NAME).message(sdo.UPLOAD))
    node.abandon(NAME)
    answer = node.ask(bytes((sdo.UPLOAD_SEGMENT,)).ljust(8, b"\0"))
    code = abort_code(answer)
    yield refusal("a segment after the abort", code, sdo.COMMAND_UNKNOWN)
    if code is None:
        node.abandon(NAME)
    same = node.upload(NAME) == node.values[NAME]
    yield None if same else "1008h differs after an aborted transfer"


@check("sdo.block", "block transfer gives the same values", "CiA 301, 7.2.4.3.9")
def blocks(node: NodeUnderTest) -> Problems:
    """Check that block upload reads the same as segmented upload, or is rejected as unknown."""
    for number, octets in node.values.items():
        if len(octets) <= sdo.SEGMENT:
            continue
        try:
            same = node.upload(number, block=True) == octets
        except SdoAbort as abort:
            if abort.code == sdo.COMMAND_UNKNOWN:
                raise SkipError("the node has no block transfer") from None
            raise
        thing = node.described.objects[number]
        yield None if same else f"{thing}: a block upload gives another value"


@check("emcy.history", "the error history", "CiA 301, 7.5.2.4")
def errors(node: NodeUnderTest) -> Problems:
    """Check that the error history counts its errors, and only accepts 0."""
    if not node.has(*_HISTORY):
        raise SkipError("1003h is not described")
    count = int.from_bytes(node.upload(_HISTORY), "little")
    for sub in range(1, count + 1):
        code = node.read_code((_HISTORY[0], sub))
        yield None if code is None else f"1003h:{sub:X}: refused with {code:08X}h"
    if node.described.objects[_HISTORY].access.writable:
        code = node.write_code(_HISTORY, b"\x01")
        yield refusal("1003h:0 set to 1", code, sdo.VALUE_INVALID, *_TOO_HIGH)


@check("sdo.range", "limits are accepted, values beyond them refused", _SDO, ACTUATE)
def range_of_writes(node: NodeUnderTest) -> Problems:
    """Check that limits are accepted, values beyond them rejected, and the value unchanged."""
    for thing in _objects(node):
        before = node.values.get(thing.number)
        if not thing.access.writable or before is None:
            continue
        for limit, step, codes in (
            (thing.high, 1, _TOO_HIGH),
            (thing.low, -1, _TOO_LOW),
        ):
            if limit is None:
                continue
            if thing.number[0] >= _APPLICATION:
                code = node.write_code(thing.number, encode(thing.kind, limit))
                if code is None:
                    node.download(thing.number, before)
                    yield None
                else:
                    yield f"{thing}: its limit {limit} is refused with {code:08X}h"
            try:
                octets = encode(thing.kind, limit + step)
            except ObjectValueError:
                continue
            code = node.write_code(thing.number, octets)
            yield refusal(f"{thing} set to {limit + step}", code, *codes)
            yield _unchanged(node, thing, before)


def _unchanged(
    node: NodeUnderTest, thing: DescribedObject, before: bytes
) -> str | None:
    """Return a problem unless an object has its value from before; it is restored."""
    if node.upload(thing.number) == before:
        return None
    node.download(thing.number, before)
    return f"{thing}: a refused value was stored"


@check("sdo.lengths", "objects refuse values of a wrong length", _SDO, ACTUATE)
def wrong_lengths_of_writes(node: NodeUnderTest) -> Problems:
    """Check that objects of the application reject values that are too long or too short."""
    for thing in _objects(node):
        before = node.values.get(thing.number)
        if thing.number[0] < _APPLICATION or not thing.access.writable or not before:
            continue
        if size(thing.kind) != len(before):
            continue
        for octets in (before + bytes(1), before[:-1]):
            if octets:
                code = node.write_code(thing.number, octets)
                yield refusal(f"{thing} with {len(octets)} octets", code, *_LENGTH)
        yield _unchanged(node, thing, before)


@check("sdo.same-value", "objects accept their current values", _SDO, ACTUATE)
def same_value(node: NodeUnderTest) -> Problems:
    """Check that objects of the application, and settings, accept their current values."""
    for thing in _objects(node):
        before = node.values.get(thing.number)
        index = thing.number[0]
        is_tried = index >= _APPLICATION or index in _SETTINGS
        if is_tried and thing.access.writable and before:
            code = node.write_code(thing.number, before)
            yield (
                None
                if code is None or (index in _SETTINGS and code == sdo.DEVICE_STATE)
                else f"{thing}: its own value is refused with {code:08X}h"
            )


CHECKS: Final = (
    readable,
    types,
    limits,
    constants,
    defaults,
    parameters,
    read_only,
    write_only,
    unknown_objects,
    lengths,
    commands,
    toggling,
    aborted,
    blocks,
    segments,
    block_download,
    block_sizes,
    block_repeats,
    errors,
    nmt_checks.heartbeat,
    nmt_checks.guarding,
    nmt_checks.boot_up,
    network_checks.parameters_reverted,
    nmt_checks.stopped,
    nmt_checks.states,
    range_of_writes,
    wrong_lengths_of_writes,
    same_value,
    synchronous,
    reception,
    wrong_lengths,
    pre_operational,
    pdo_changes.content,
    pdo_changes.identifiers,
    pdo_changes.mapping,
    pdo_changes.transmission,
    pdo_changes.times,
    pdo_changes.synchronous_reception,
    network_checks.entries,
    network_checks.error_reset,
    network_checks.consumer,
    network_checks.life_guarding,
    network_checks.reset,
    lss_address,
    lss_identify,
    lss_identity,
    lss_refusals,
)
"""All checks, in the order of a test: the first one reads values that others compare with."""
