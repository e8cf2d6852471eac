"""`rtgen conformance`: each check fails for a node that violates it alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from can_nodes import SPECS
from conformance_nodes import ID, Alter, failed, limited, report_of
from wrong_answers import (
    AbortsNothing,
    AfterAbort,
    EverySecondBeat,
    IgnoresLong,
    KeepsItsHeartbeat,
    LosesItsGuard,
    ObeysOthers,
    OldValues,
    SendsInPreOperational,
    ServedWhenStopped,
    SilentAtSync,
    SlowTimer,
    StartsItself,
    accepting,
    accepts_wrong_lengths,
    acknowledged,
    altered,
    answering,
    at,
    changed,
    instead_of_abort,
    plain,
    refused,
    refuses_its_own_value,
    refusing,
    replaced,
    selected_by_any_revision,
    selected_by_any_serial,
    to_server,
    too_high_is_stored,
    with_octet,
    without_boot_up,
    writes,
)

from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.conformance.canopen.checks import CHECKS
from rtgen.tools.conformance.report import as_text

MUTANTS: dict[str, Alter] = {
    "sdo.read": refusing(0x40, 0x1018, 4),
    "object.type": answering(0x6000, 1, 0x4B, b"\0\0"),
    "object.limits": answering(0x2F00, 0, 0x4B, b"\xff\x7f"),
    "object.constants": answering(0x1000, 0, 0x43, b"\x99\0\0\0"),
    "object.defaults": answering(0x2F02, 0, 0x4B, b"\5\0"),
    "pdo.parameters": answering(0x1800, 3, 0x4B, b"\x99\0"),
    "sdo.read-only": accepting(0x20, 0x1018, 1),
    "sdo.write-only": answering(0x2F01, 0, 0x4B, b"\0\0"),
    "sdo.unknown": refusing(0x40, 0x5FFF),
    "sdo.length": accepting(0x20, 0x1017, most=1),
    "sdo.command": refused(lambda f: to_server(f, 0xE0), 0x08000000),
    "sdo.toggle": instead_of_abort(
        0x05030000, plain(0x10), lambda f: f.data[:1] == b"\x70"
    ),
    "sdo.abort": AfterAbort(),
    "sdo.block": altered(lambda f, out: f.data[:1] == b"\xa3", with_octet(1, b"?")),
    "sdo.segments": instead_of_abort(
        0x05030000, plain(0x30), lambda f: f.data[:1] == b"\x1b"
    ),
    "sdo.block-download": instead_of_abort(0x05040004, plain(0xA1)),
    "sdo.block-sizes": instead_of_abort(0x05040002, plain(0xC6)),
    "sdo.block-repeats": altered(
        lambda f, out: to_server(f, 0x82), with_octet(1, b"\1")
    ),
    "emcy.history": instead_of_abort(
        0x06090030, acknowledged, lambda f: at(f, 0x20, 0x1003)
    ),
    "heartbeat": EverySecondBeat(),
    "guarding": altered(lambda f, out: f.remote, lambda data: bytes((data[0] & 0x7F,))),
    "nmt.boot-up": without_boot_up(0x82),
    "nmt.parameters": KeepsItsHeartbeat(),
    "nmt.stopped": ServedWhenStopped(),
    "nmt.states": replaced(0x700 + ID, b"\x05", b"\x7f"),
    "sdo.range": too_high_is_stored,
    "sdo.lengths": accepts_wrong_lengths,
    "sdo.same-value": refuses_its_own_value,
    "pdo.synchronous": SilentAtSync(),
    "pdo.reception": OldValues(synchronous=False),
    "pdo.length": changed(
        0x80 + ID,
        lambda data: b"\0\0" + data[2:] if data[:2] == b"\x10\x82" else data,
    ),
    "pdo.states": SendsInPreOperational(),
    "pdo.content": changed(0x180 + ID, lambda data: data[::-1]),
    "pdo.identifiers": instead_of_abort(
        0x06090030,
        acknowledged,
        lambda f: writes(f, 0x1400, 0x19FF, 1) and not f.data[7] & 0x80,
    ),
    "pdo.mapping": instead_of_abort(
        0x06040041, acknowledged, lambda f: f.data[4:] == b"\x20\0\0\x10"
    ),
    "pdo.transmission": instead_of_abort(
        0x06090030, acknowledged, lambda f: writes(f, 0x1800, 0x19FF, 2)
    ),
    "pdo.times": SlowTimer(),
    "pdo.synchronous-reception": OldValues(synchronous=True),
    "emcy.entry": answering(0x1003, 1, 0x43, b"\x30\x81\0\0"),
    "emcy.reset": replaced(0x80 + ID, b"\0\0", None),
    "heartbeat.consumer": replaced(0x80 + ID, b"\x30\x81", None),
    "guarding.life": LosesItsGuard(),
    "nmt.reset": without_boot_up(0x81),
    "lss.address": selected_by_any_serial,
    "lss.identify": replaced(0x7E4, b"\x4f", None),
    "lss.identity": replaced(0x7E4, b"\x5b", b"\x5b\x63"),
    "lss.refusals": replaced(0x7E4, b"\x11", b"\x11\0"),
}
FURTHER: dict[str, tuple[str, Alter]] = {
    "nothing by remote frames": (
        "pdo.transmission",
        lambda cause, out: (
            [f for f in out if not 0x180 <= f.can_id < 0x580] if cause.remote else out
        ),
    ),
    "too many objects are mapped": (
        "pdo.mapping",
        instead_of_abort(0x06040042, acknowledged),
    ),
    "a false count of segments": (
        "sdo.block-sizes",
        instead_of_abort(0x05040003, plain(0xC1)),
    ),
    "segments that are too long": (
        "sdo.segments",
        instead_of_abort(
            0x06070012, acknowledged, lambda f: f.data[:3] == b"\x21\x17\x10"
        ),
    ),
    "no bit of the error register": ("emcy.entry", answering(0x1001, 0, 0x4F, b"\0")),
    "another node with its LSS address": (
        "lss.address",
        lambda cause, out: [f for f in out for _ in range(1 + (f.can_id == 0x7E4))],
    ),
    "selected by another revision number": ("lss.address", selected_by_any_revision),
    "its own node-id is not accepted": (
        "lss.refusals",
        replaced(0x7E4, b"\x11", b"\x11\1"),
    ),
    "an answer in the LSS state waiting": (
        "lss.address",
        lambda cause, out: (
            [Frame(0x7E4, bytes((0x5E, ID)) + bytes(6))]
            if cause.can_id == 0x7E5 and cause.data[:1] == b"\x5e"
            else out
        ),
    ),
    "a second boot-up message": (
        "nmt.boot-up",
        lambda cause, out: (
            out + [f for f in out if f.data == b"\0" and f.can_id == 0x700 + ID]
        ),
    ),
    "it starts by itself": ("nmt.boot-up", StartsItself()),
    "another error register in the emergency": (
        "emcy.entry",
        changed(0x80 + ID, lambda data: data[:2] + b"\x81" + data[3:]),
    ),
    "the older error first": (
        "emcy.entry",
        answering(0x1003, 2, 0x43, b"\x20\x82\0\0"),
    ),
    "a long RPDO is ignored": ("pdo.length", IgnoresLong()),
    "a limit is refused": (
        "sdo.range",
        refused(lambda f: at(f, 0x20, 0x2F02) and f.data[4] == 10, 0x06090031),
    ),
    "types over 24 are refused": (
        "pdo.transmission",
        refused(
            lambda f: writes(f, 0x1800, 0x19FF, 2) and f.data[4] == 240,
            0x06090030,
        ),
    ),
    "its own type is refused": (
        "pdo.transmission",
        refused(
            lambda f: writes(f, 0x1800, 0x19FF, 2) and f.data[4] == 255,
            0x06090030,
        ),
    ),
    "an entry of a mapping in use": (
        "pdo.mapping",
        instead_of_abort(
            0x06010003, acknowledged, lambda f: writes(f, 0x1A00, 0x1BFF, 1)
        ),
    ),
    "an aborted transfer goes on": ("sdo.abort", AbortsNothing()),
    "a toggle bit of a download": (
        "sdo.segments",
        altered(
            lambda f, out: f.can_id == 0x600 + ID and out[0].data[:1] == b"\x20",
            with_octet(0, b"\x30"),
        ),
    ),
    "commands to other node-ids": ("nmt.states", ObeysOthers()),
    "a bit rate that does not exist": (
        "lss.refusals",
        replaced(0x7E4, b"\x13", b"\x13\0"),
    ),
}
"""Further violations: the check that has to fail, and the answers."""

LIMITED = {
    *("object.limits", "object.defaults", "sdo.write-only", "sdo.range"),
    *("pdo.content", "guarding", "guarding.life"),
    *("nothing by remote frames", "a limit is refused"),
}
"""Violations for which only the device `limited` has objects."""


def described(violation: str, folder: Path) -> Path:
    """Return the description of the device for a violation."""
    if violation in LIMITED:
        return limited(folder)
    is_core = violation == "pdo.synchronous"
    return SPECS / ("motor_core_unit.eds" if is_core else "f_palette.eds")


def test_each_check_has_a_mutant() -> None:
    assert list(MUTANTS) == [check.name for check in CHECKS]


@pytest.mark.sampled(5)
@pytest.mark.parametrize("check", MUTANTS)
def test_a_check_finds_the_node_that_breaks_just_it(check: str, tmp_path: Path) -> None:
    report = report_of(described(check, tmp_path), MUTANTS[check])
    assert failed(report) == {check}, as_text(report)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("what", FURTHER)
def test_a_check_finds_other_nodes_too(what: str, tmp_path: Path) -> None:
    check, alter = FURTHER[what]
    report = report_of(described(what, tmp_path), alter)
    assert failed(report) == {check}, as_text(report)


def test_an_answer_that_is_not_valid_is_no_refusal() -> None:
    report = report_of(SPECS / "f_palette.eds", MUTANTS["sdo.block"])
    [outcome] = [o for o in report.outcomes if o.check == "sdo.block"]
    assert outcome.problems == (
        "the end of the transfer is not valid: 05040004h CRC error",
    )
