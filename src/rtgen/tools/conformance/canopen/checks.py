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
    block_download,
    block_repeats,
    block_sizes,
    long_name,
    segments,
    writable_heartbeat,
)
from rtgen.tools.conformance.check import Check, Permission, Problems, SkipError

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


def types(node: NodeUnderTest) -> Problems:
    """Check that values have the length of their types."""
    for number, octets in node.values.items():
        thing = node.described.objects[number]
        expected = size(thing.kind)
        fits = expected is None or len(octets) == expected
        yield (
            None
            if fits
            else f"{thing}: {len(octets)} octets, {thing.kind} has {expected}"
        )


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


def read_only(node: NodeUnderTest) -> Problems:
    """Check that writes to read-only objects are rejected."""
    for thing in _objects(node):
        octets = node.values.get(thing.number)
        if not thing.access.writable and octets:
            yield refusal(thing, node.write_code(thing.number, octets), *_READ_ONLY)


def write_only(node: NodeUnderTest) -> Problems:
    """Check that reads of write-only objects are rejected."""
    for thing in _objects(node):
        if not thing.access.readable:
            yield refusal(thing, node.read_code(thing.number), *_WRITE_ONLY)


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


def lengths(node: NodeUnderTest) -> Problems:
    """Check that values of a wrong length are rejected."""
    writable_heartbeat(node)
    for octets in (bytes(1), bytes(3), bytes(4)):
        code = node.write_code(HEARTBEAT, octets)
        yield refusal(f"1017h with {len(octets)} octets", code, *_LENGTH)


def commands(node: NodeUnderTest) -> Problems:
    """Check that unknown commands, and segments without a transfer, are rejected."""
    for first in (0xE0, 0x00, 0x60):
        answer = node.ask(bytes((first,)).ljust(8, b"\0"))
        code = int.from_bytes(answer[4:8], "little") if answer[0] == sdo.ABORT else None
        yield refusal(f"command {first:02X}h", code, sdo.COMMAND_UNKNOWN)


def toggling(node: NodeUnderTest) -> Problems:
    """Check that a segment with a wrong toggle bit ends the transfer."""
    long_name(node)
    node.ask(Target(*NAME).message(sdo.UPLOAD))
    answer = node.ask(bytes((sdo.UPLOAD_SEGMENT | sdo.TOGGLE,)).ljust(8, b"\0"))
    code = int.from_bytes(answer[4:8], "little") if answer[0] == sdo.ABORT else None
    yield refusal("the first segment with toggle bit 1", code, sdo.TOGGLE_ERROR)
    if code is None:
        node.abandon(NAME)


def aborted(node: NodeUnderTest) -> Problems:
    """Check that after an aborted transfer the server is ready, with an unchanged value."""
    long_name(node)
    node.ask(Target(*NAME).message(sdo.UPLOAD))
    node.abandon(NAME)
    answer = node.ask(bytes((sdo.UPLOAD_SEGMENT,)).ljust(8, b"\0"))
    code = int.from_bytes(answer[4:8], "little") if answer[0] == sdo.ABORT else None
    yield refusal("a segment after the abort", code, sdo.COMMAND_UNKNOWN)
    if code is None:
        node.abandon(NAME)
    same = node.upload(NAME) == node.values[NAME]
    yield None if same else "1008h differs after an aborted transfer"


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


_SDO = "CiA 301, 7.2.4.3"
_EDS = "CiA 306, 4.6"

ACTUATE: Final = Permission.ACTUATE

CHECKS: Final = (
    Check("sdo.read", "every readable object is read", _SDO, readable),
    Check("object.type", "values have the length of their types", _EDS, types),
    Check("object.limits", "values are within their limits", _EDS, limits),
    Check("object.constants", "constants and identity as described", _EDS, constants),
    Check(
        "object.defaults",
        "values are the defaults of the description",
        _EDS,
        defaults,
        Permission.DEFAULTS,
    ),
    Check(
        "pdo.parameters",
        "PDO parameters as described",
        "CiA 301, 7.5.2.35 to 38",
        parameters,
    ),
    Check("sdo.read-only", "read-only objects refuse writes", _SDO, read_only),
    Check("sdo.write-only", "write-only objects refuse reads", _SDO, write_only),
    Check(
        "sdo.unknown",
        "unknown objects and sub-indices are refused",
        _SDO,
        unknown_objects,
    ),
    Check("sdo.length", "values of a wrong length are refused", _SDO, lengths),
    Check("sdo.command", "unknown commands are refused", _SDO, commands),
    Check("sdo.toggle", "a wrong toggle bit is refused", _SDO, toggling),
    Check("sdo.abort", "an aborted transfer leaves the server ready", _SDO, aborted),
    Check(
        "sdo.block",
        "block transfer gives the same values",
        "CiA 301, 7.2.4.3.9",
        blocks,
    ),
    Check("sdo.segments", "downloads by segments", "CiA 301, 7.2.4.3.3", segments),
    Check(
        "sdo.block-download",
        "downloads by blocks, with their check sum",
        "CiA 301, 7.2.4.3.9",
        block_download,
    ),
    Check(
        "sdo.block-sizes",
        "uploads by blocks of a wrong size are refused",
        "CiA 301, 7.2.4.3.13",
        block_sizes,
    ),
    Check(
        "sdo.block-repeats",
        "lost segments of blocks are repeated",
        "CiA 301, 7.2.4.3.11",
        block_repeats,
    ),
    Check("emcy.history", "the error history", "CiA 301, 7.5.2.4", errors),
    Check(
        "heartbeat",
        "the heartbeat keeps its period",
        "CiA 301, 7.2.8.3.2.2",
        nmt_checks.heartbeat,
    ),
    Check("guarding", "node guarding", "CiA 301, 7.2.8.3.2.1", nmt_checks.guarding),
    Check(
        "nmt.boot-up",
        "boot-up after reset communication",
        "CiA 301, 7.3.2.2",
        nmt_checks.boot_up,
    ),
    Check(
        "nmt.parameters",
        "reset communication reverts parameters",
        "CiA 301, 7.3.2.2.1",
        network_checks.parameters_reverted,
    ),
    Check(
        "nmt.stopped",
        "a stopped node serves no SDO",
        "CiA 301, 7.3.2.2.4",
        nmt_checks.stopped,
    ),
    Check(
        "nmt.states",
        "NMT commands lead to their states",
        "CiA 301, 7.3.2",
        nmt_checks.states,
        ACTUATE,
    ),
    Check(
        "sdo.range",
        "limits are accepted, values beyond them refused",
        _SDO,
        range_of_writes,
        ACTUATE,
    ),
    Check(
        "sdo.lengths",
        "objects refuse values of a wrong length",
        _SDO,
        wrong_lengths_of_writes,
        ACTUATE,
    ),
    Check(
        "sdo.same-value",
        "objects accept their current values",
        _SDO,
        same_value,
        ACTUATE,
    ),
    Check(
        "pdo.synchronous",
        "synchronous TPDOs follow SYNC",
        "CiA 301, 7.5.2.37",
        synchronous,
        ACTUATE,
    ),
    Check(
        "pdo.reception",
        "objects get the values of an RPDO",
        "CiA 301, 7.2.2.2",
        reception,
        ACTUATE,
    ),
    Check(
        "pdo.length",
        "RPDOs that are too short are reported, longer ones truncated",
        "CiA 301, 7.2.2.4",
        wrong_lengths,
        ACTUATE,
    ),
    Check(
        "pdo.states",
        "no PDOs in PRE-OPERATIONAL",
        "CiA 301, 7.3.2.2.5",
        pre_operational,
        ACTUATE,
    ),
    Check(
        "pdo.content",
        "TPDOs have the values of their objects",
        "CiA 301, 7.5.2.38",
        pdo_changes.content,
        ACTUATE,
    ),
    Check(
        "pdo.identifiers",
        "identifiers of valid PDOs cannot be changed",
        "CiA 301, 7.5.2.37",
        pdo_changes.identifiers,
        ACTUATE,
    ),
    Check(
        "pdo.mapping",
        "mappings are set, and invalid ones are refused",
        "CiA 301, 7.5.2.36",
        pdo_changes.mapping,
        ACTUATE,
    ),
    Check(
        "pdo.transmission",
        "each transmission type of TPDOs",
        "CiA 301, 7.5.2.37",
        pdo_changes.transmission,
        ACTUATE,
    ),
    Check(
        "pdo.times",
        "event timers and inhibit times",
        "CiA 301, 7.5.2.37",
        pdo_changes.times,
        ACTUATE,
    ),
    Check(
        "pdo.synchronous-reception",
        "synchronous RPDOs take effect at a SYNC",
        "CiA 301, 7.5.2.35",
        pdo_changes.synchronous_reception,
        ACTUATE,
    ),
    Check(
        "emcy.entry",
        "errors are entered in the history",
        "CiA 301, 7.5.2.4",
        network_checks.entries,
        ACTUATE,
    ),
    Check(
        "emcy.reset",
        "the end of an error is reported",
        "CiA 301, 7.2.7.2",
        network_checks.error_reset,
        ACTUATE,
    ),
    Check(
        "heartbeat.consumer",
        "a lost heartbeat is reported",
        "CiA 301, 7.2.8.3.2.2",
        network_checks.consumer,
        ACTUATE,
    ),
    Check(
        "guarding.life",
        "a lost guard is reported",
        "CiA 301, 7.2.8.3.2.1",
        network_checks.life_guarding,
        ACTUATE,
    ),
    Check(
        "nmt.reset",
        "boot-up after reset node",
        "CiA 301, 7.3.2.2",
        network_checks.reset,
        ACTUATE,
    ),
    Check(
        "lss.address", "selected only by its LSS address", "CiA 305, 3.7", lss_address
    ),
    Check("lss.identify", "identifies itself in a range", "CiA 305, 3.7", lss_identify),
    Check("lss.identity", "reports its identity", "CiA 305, 3.11", lss_identity),
    Check(
        "lss.refusals",
        "node-ids and bit rates are accepted and refused",
        "CiA 305, 3.9",
        lss_refusals,
    ),
)
"""All checks, in the order of a test: the first one reads values that others compare with."""
