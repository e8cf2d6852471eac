"""`rtgen conformance` of CANopen nodes: rtgen's own pass; the reports; the command."""

from __future__ import annotations

import json
import re
import signal
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from can_nodes import SPECS, description, nodes
from conformance_nodes import ID, SimulatedLine, failed, limited, report_of, unaltered
from hub_process import HubProcess
from json_schemas import valid
from wrong_answers import answering, refusing

from refnav.epos_drive_device import EposDriveDevice
from rtgen.cli import run
from rtgen.runtime import RealClock, System
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtState
from rtgen.tools.can.decoding.node_index import read_node_index
from rtgen.tools.conformance.canopen.checks import CHECKS
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.canopen.testing import checked
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import (
    Report,
    Verdict,
    as_html,
    as_json_text,
    as_junit,
    as_text,
)

NAMES = ("f_palette", "motor_core_unit", "ftmd", "epos_drive")


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", NAMES)
def test_our_own_nodes_conform(name: str) -> None:
    report = report_of(SPECS / f"{name}.eds")
    assert report.passed, as_text(report)
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert skipped <= {"sdo.write-only", "guarding", "guarding.life", "pdo.synchronous"}


def with_entry(folder: Path, eds: Path, section: str, entry: str) -> Path:
    """Return a DCF: an EDS with an entry in a section."""
    head, begin, rest = eds.read_text().partition(f"[{section}]\n")
    assert begin
    path = folder / "configured.dcf"
    path.write_text(f"{head}{begin}{entry}\n{rest}")
    return path


def test_configured_values_that_the_node_does_not_have(tmp_path: Path) -> None:
    eds = SPECS / "motor_core_unit.eds"
    report = report_of(with_entry(tmp_path, eds, "1A00sub0", "ParameterValue=1"))
    assert report.passed, as_text(report)


@pytest.mark.parametrize(("value", "passes"), [(0, True), (5, True), (7, False)])
def test_an_object_has_its_default_or_the_value_of_a_dcf(
    value: int, passes: bool, tmp_path: Path
) -> None:
    dcf = with_entry(tmp_path, limited(tmp_path), "2F02", "ParameterValue=5")
    report = report_of(dcf, answering(0x2F02, 0, 0x4B, bytes((value, 0))))
    assert failed(report) == (set() if passes else {"object.defaults"})
    assert passes or "is 0700, its default is 0 or 5" in as_text(report)


@pytest.mark.parametrize(("count", "passes"), [(2, True), (1, True), (0, False)])
def test_a_pdo_has_the_default_mapping_or_that_of_a_dcf(
    count: int, passes: bool, tmp_path: Path
) -> None:
    eds = SPECS / "motor_core_unit.eds"
    dcf = with_entry(tmp_path, eds, "1A00sub0", "ParameterValue=1")
    stored = answering(0x1A00, 0, 0x4F, bytes((count,)))
    report = report_of(dcf, stored, actuate=False)
    assert failed(report) == (set() if passes else {"pdo.parameters"})
    assert passes or "is 0h, described is 2h or 1h" in as_text(report)


def test_a_node_that_a_manager_has_configured() -> None:
    """Its PDOs have other parameters until a reset of communication."""
    eds = SPECS / "motor_core_unit.eds"
    (described,) = read_node_index(None, [(ID, eds)]).nodes.values()
    node = DeviceNode(description(eds), ID, serial_number=1)
    subject = NodeUnderTest(described, SimulatedLine(node, unaltered))
    subject.download((0x1800, 1), (0xC0000180 + ID).to_bytes(4, "little"))
    for count in (0, 1):
        subject.download((0x1A00, 0), bytes((count,)))
    subject.download((0x1800, 1), (0x40000180 + ID).to_bytes(4, "little"))
    report = checked(subject, eds.name, [Permission.ACTUATE])
    assert report.passed, as_text(report)


def with_default(folder: Path, name: str, section: str, value: str) -> Path:
    """Return one of our EDS files with another default of an object."""
    head, begin, rest = (SPECS / name).read_text().partition(f"[{section}]\n")
    old, end, rest = rest.partition("\n[")
    new = re.sub("(?m)^DefaultValue=.*$", f"DefaultValue={value}", old)
    assert new != old
    path = folder / name
    path.write_text(head + begin + new + end + rest)
    return path


def test_a_node_without_emergencies(tmp_path: Path) -> None:
    eds = with_default(tmp_path, "f_palette.eds", "1014", "0x80000081")
    report = report_of(eds)
    assert report.passed, as_text(report)
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert {"emcy.entry", "emcy.reset", "heartbeat.consumer"} <= skipped


def test_tpdos_without_mapped_objects(tmp_path: Path) -> None:
    eds = with_default(tmp_path, "motor_core_unit.eds", "1A00sub0", "0")
    report = report_of(eds)
    assert report.passed, as_text(report)


def test_a_node_with_everything_conforms(tmp_path: Path) -> None:
    report = report_of(limited(tmp_path))
    assert report.passed, as_text(report)


def test_without_actuate_the_node_stays_as_it_was(tmp_path: Path) -> None:
    eds = limited(tmp_path)
    sent: list[Frame] = []

    def alter(cause: Frame, out: list[Frame]) -> list[Frame]:
        sent.append(cause)
        return out

    report = report_of(eds, alter, actuate=False)
    assert report.passed
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert skipped >= {check.name for check in CHECKS if check.needs is not None}
    assert Frame(0, bytes((1, ID))) not in sent
    written = {
        int.from_bytes(f.data[1:3], "little")
        for f in sent
        if f.can_id == 0x600 + ID and not f.remote and f.data[0] & 0xE0 == 0x20
    }
    read_only = {
        v.index
        for v in read_node_index(None, [(ID, eds)]).nodes[ID].device.variables
        if not v.access.writable
    }
    assert {i for i in written - read_only if i >= 0x2000} <= {0x5FFF, 0xFFFF}


@pytest.mark.parametrize("at", [10, 450, 600, 750, 900])
def test_a_node_is_left_in_pre_operational_after_sigterm(at: int) -> None:
    """At some frame of the checks, with the node in any state."""
    count = 0

    def interrupted(cause: Frame, frames: list[Frame]) -> list[Frame]:
        nonlocal count
        count += 1
        if count == at:
            signal.raise_signal(signal.SIGTERM)
        return frames

    eds = SPECS / "f_palette.eds"
    (described,) = read_node_index(None, [(ID, eds)]).nodes.values()
    node = DeviceNode(description(eds), ID, serial_number=1)
    subject = NodeUnderTest(described, SimulatedLine(node, interrupted))
    with pytest.raises(KeyboardInterrupt):
        checked(subject, eds.name, [Permission.ACTUATE])
    assert node.state is NmtState.PRE_OPERATIONAL
    assert node.get(0x1017) == DeviceNode(description(eds), ID).get(0x1017)


@pytest.mark.sampled(0)
@pytest.mark.waits
def test_a_component_in_real_time_conforms(capfd: pytest.CaptureFixture[str]) -> None:
    """The states of a component follow its node's within a tick, and commands are faster.

    A busy machine may be late for the periods of the checks.
    """
    with HubProcess() as hub, System(RealClock()) as system:
        device = EposDriveDevice("device")
        for name, value in (
            ("interface", "socketcand"),
            ("options", hub.options()),
            ("node_id", str(ID)),
        ):
            device.configuration_sets.set(name, value)
        system.add(device, 200.0)
        system.run(1)
        where = [*("--interface", "socketcand"), *("--option", f"port={hub.port}")]
        eds = str(SPECS / "epos_drive.eds")
        run(["conformance", eds, "--node", str(ID), *where, "--actuate", "--json"])
        outcomes = json.loads(capfd.readouterr().out)["outcomes"]
        wrong = {
            o["check"]: o["problems"] for o in outcomes if o["verdict"] == "failed"
        }
        assert wrong.keys() <= {"heartbeat", "pdo.times"}, wrong
        assert device.node.state is NmtState.PRE_OPERATIONAL


def broken() -> Report:
    return report_of(SPECS / "f_palette.eds", refusing(0x40, 0x5FFF), actuate=False)


def test_reports_in_each_form() -> None:
    report = broken()
    text = as_text(report)
    assert "failed   sdo.unknown" in text
    assert "- 5FFFh: it was refused with 08000000h, not with 06020000h" in text
    content = valid(as_json_text(report), "conformance.schema.json")
    assert content["passed"] is False
    assert [o["check"] for o in content["outcomes"]] == [c.name for c in CHECKS]
    suite = ElementTree.fromstring(as_junit(report))
    assert suite.get("failures") == "1"
    (failure,) = suite.findall("testcase/failure")
    assert failure.text is not None
    assert failure.text.startswith("5FFFh")
    page = as_html(report)
    assert page.count("<tr class=") == len(CHECKS)
    assert "<script" not in page


def test_texts_of_a_definition_are_data_in_reports() -> None:
    hostile = "<script>alert(1)</script>\x00]]>&\"'"
    outcome = replace(broken().outcomes[0], problems=(hostile,), verdict=Verdict.FAILED)
    report = Report(hostile, hostile, (outcome,))
    assert "<script" not in as_html(report)
    suite = ElementTree.fromstring(as_junit(report))
    shown = hostile.replace("\x00", "\N{REPLACEMENT CHARACTER}")
    assert suite.get("name") == shown
    assert [e.text for e in suite.iter("failure")] == [shown]
    assert json.loads(as_json_text(report))["subject"] == hostile


def test_the_command_on_a_bus(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    eds, page = str(SPECS / "f_palette.eds"), tmp_path / "report.html"
    suite = tmp_path / "report.xml"
    arguments = ["conformance", eds, "--node", str(ID), "--timeout", "0.5"]
    arguments += ["--connect", "virtual:conformance"]
    with nodes("conformance", {ID: "f_palette"}):
        code = run([*arguments, "--json", "--html", str(page), "--junit", str(suite)])
    said = capfd.readouterr()
    assert code == 0, said
    assert valid(said.out, "conformance.schema.json")["passed"]
    assert ElementTree.parse(suite).getroot().get("failures") == "0"
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert run(arguments) == 3
    assert "node 5 does not answer" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["board.txt"], "is not a description of a device, a CDL file or"),
        (["f_palette.eds", "--connect", "can0"], "not INTERFACE:CHANNEL"),
        (["f_palette.eds", "--connect", "virtual:x"], "--node N"),
        (["nothing.eds", "--node", "1", "--connect", "virtual:x"], "nothing.eds"),
    ],
)
def test_what_the_command_refuses(
    arguments: list[str],
    word: str,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(SPECS)
    assert run(["conformance", *arguments]) == 2
    assert word in capfd.readouterr().err
