"""Events of a timeline that edits have overtaken, and runs that end by an error."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ui_bench import ROOT, Bench, Page, whole

from rtgen.cli import run as rtgen
from rtgen.runtime import ACTIVE_STATE, RTC_ERROR
from rtgen.ui.protocol import ui

INTERCHANGE = ROOT / "specs/experiments/interchange"
SYSTEM = """<?xml version="1.0"?>
<rts:RtsProfile rts:id="RTSystem:a:b:1" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
  <rts:Components rts:id="RTC:r:Robots:JoystickA:1.0.0" rts:instanceName="A0"/>
  <rts:Components rts:id="RTC:r:Robots:JoystickA:1.0.0" rts:instanceName="B0"/>
  <rts:Components rts:id="RTC:r:Robots:RefHardControl:1.0.0" rts:instanceName="R0"/>
  <rts:DataPortConnectors rts:connectorId="wire" rts:name="wire">
    <rts:sourceDataPort rts:portName="A0.velocity" rts:instanceName="A0"/>
    <rts:targetDataPort rts:portName="R0.velocity" rts:instanceName="R0"/>
  </rts:DataPortConnectors>
  <rts:Activation>
    <rts:targets rts:sequence="1">
      <rts:TargetComponent rts:instanceName="R0"/>
    </rts:targets>
    <rts:targets rts:sequence="2">
      <rts:WaitTime rts:waitTime="500"/>
      <rts:TargetComponent rts:instanceName="B0"/>
    </rts:targets>
  </rts:Activation>
</rts:RtsProfile>
"""
EVENTS = """[[at]]
t = 1
disconnect = "wire"
deactivate = "R0"
set = "R0.max_v=0.1"
[[at]]
t = 2
connect = "wire"
"""


def skipped(page: Page) -> list[str]:
    """Return the lines of the timeline about skipped events, since the last call."""
    return [
        event.reported.text
        for event in page.seen
        if event.discriminator is ui.EventKind.EVENT_NOTICE
        and event.reported.kind == "skipped"
    ]


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.chdir(ROOT)
    (tmp_path / "system.xml").write_text(SYSTEM)
    (tmp_path / "timeline.toml").write_text(EVENTS)
    made = Bench(tmp_path)
    yield made
    made.close()


def test_a_wire_cut_by_hand_does_not_end_the_run(
    bench: Bench, capfd: pytest.CaptureFixture[str]
) -> None:
    page, session = bench.page(), bench.session
    page.done("connection", "wire")
    page.done("step", 1.5)
    [line] = skipped(page)
    assert line.endswith("the event is skipped")
    assert "timeline.toml:3: there is no connection 'wire'" in line
    error = capfd.readouterr().err
    assert error.count("warning[SYS0027]") == 1
    assert "timeline.toml:3:1" in error
    page.done("step", 3.0)
    assert not session.runner.over
    assert "wire" in [each.name for each in session.system.connectors]


def test_a_time_that_is_set_skips_it_too(bench: Bench) -> None:
    page, session = bench.page(), bench.session
    page.done("connection", "wire")
    assert page.done("time", 3.0).message == ""
    assert session.now == 3.0
    assert len(skipped(page)) == 1


def test_a_wire_made_by_hand_that_the_timeline_makes(bench: Bench) -> None:
    page, session = bench.page(), bench.session
    page.done("step", 1.5)
    ends = ui.PortAddress("A0", "velocity"), ui.PortAddress("R0", "velocity")
    page.done("wire", ui.Connect(*ends, "mine"))
    page.done("step", 1.0)
    [line] = skipped(page)
    assert "timeline.toml:8" in line
    assert not session.runner.over


def test_a_removed_component_skips_its_events(bench: Bench) -> None:
    page, session = bench.page(), bench.session
    for name in ("R0", "B0"):
        page.done("removed", name)
    page.done("step", 3.0)
    assert [line.partition("timeline.toml:")[2][0] for line in skipped(page)] == [
        *"3548"
    ]
    assert not session.runner.over
    assert session.now == 3.0
    page.done("time", 3.0)
    assert session.now == 3.0
    page.done("file", "")


def test_one_of_another_type_with_the_name_of_a_removed_one(bench: Bench) -> None:
    page, session = bench.page(), bench.session
    page.done("removed", "R0")
    page.done("added", ui.AddComponent("JoystickB", "R0"))
    page.done("step", 3.0)
    assert len(skipped(page)) == 2
    assert "cannot be connected" in skipped(page)[1]
    assert not session.runner.over


def test_a_run_that_has_ended_says_why_on_every_page(
    bench: Bench, capfd: pytest.CaptureFixture[str]
) -> None:
    page, session = bench.page(), bench.session
    session.system.at(500_000_000, lambda: 1 // 0)
    page.done("step", 1.0)
    [clock] = [
        event.clock
        for event in page.seen
        if event.discriminator is ui.EventKind.EVENT_TIME and event.clock.ended
    ][:1]
    assert clock.reason.startswith("ZeroDivisionError: ")
    later = whole(bench.page().events()).time
    assert (later.ended, later.reason) == (True, clock.reason)
    assert "the run has ended at 0.500 s: ZeroDivisionError" in capfd.readouterr().err
    page.done("played", True)
    assert not session.runner.playing
    page.done("time", 0.0)
    assert not session.time().ended
    assert session.time().reason == ""
    page.done("step", 1.0)
    assert session.system.state("R0") is ACTIVE_STATE


def test_events_that_no_longer_apply_do_not_end_a_run(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(ROOT)
    (tmp_path / "system.xml").write_text(SYSTEM)
    again = '[[at]]\nt = 1.5\ndisconnect = "wire"\n[[at]]\nt = 2.5\nconnect = "wire"\n'
    (tmp_path / "timeline.toml").write_text(EVENTS + again)
    assert rtgen(["run", str(tmp_path), "--until", "3", "-q"]) == 0
    errors = re.findall(r"timeline.toml:(\d+):\d+: (\S+): (.*)", capfd.readouterr().err)
    assert [each[:2] for each in errors] == [
        ("11", "warning[SYS0027]"),
        ("14", "warning[SYS0027]"),
    ]
    wrong = '[[at]]\nt = 1.5\nconnect = { from = "A0.velocity", to = "B0.velocity" }\n'
    (tmp_path / "timeline.toml").write_text(EVENTS + wrong)
    assert rtgen(["run", str(tmp_path), "--until", "3", "-q"]) == 2
    assert "timeline.toml:11:1: error[RTC0582]" in capfd.readouterr().err


def test_calls_and_planned_ends_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    finishes = """  <rtsExt:Properties rtsExt:name="rtgen.run.finishes" rtsExt:value="B0"/>
</rts:RtsProfile>"""
    text = SYSTEM.replace("</rts:RtsProfile>", finishes)
    (tmp_path / "system.xml").write_text(text)
    (tmp_path / "timeline.toml").write_text(EVENTS)
    bench = Bench(tmp_path)
    state = whole(bench.page().events())
    assert [c.instance for c in state.components if c.finishes] == ["B0"]
    assert [(e.time, e.kind, e.text) for e in state.plan] == [
        (1.0, "disconnect", "wire"),
        (1.0, "set", "R0.max_v = 0.1"),
        (1.0, "deactivate", "R0"),
        (2.0, "connect", "A0.velocity to R0.velocity"),
    ]
    assert state.plan[-1].source == ui.PortAddress(instance="A0", port="velocity")
    page = bench.page()
    for instance in ("A0", "B0"):
        component: Any = bench.session.system.component(instance)
        component.on_execute = lambda ec_id: RTC_ERROR
        page.ask("activated", [instance])
    page.done("step", 1.0)
    failed = [
        event.reported.instance
        for event in page.seen
        if event.discriminator is ui.EventKind.EVENT_NOTICE
        and event.reported.kind == "error"
    ]
    assert failed == ["A0"]
    bench.close()


def test_a_call_is_a_line_with_its_outcome(warm: Path) -> None:
    timeline = warm / "systems/warm/timeline.toml"
    call = '[[at]]\nt = 1.0\ncall = "Heater0.setup.set_room(18.5)"\n\n[[at]]\nt = 2.0'
    timeline.write_text(timeline.read_text().replace("[[at]]\nt = 2.0", call))
    bench = Bench("systems/warm")
    page = bench.page()
    page.done("step", 1.5)
    [line] = [
        event.reported
        for event in page.seen
        if event.discriminator is ui.EventKind.EVENT_NOTICE
        and event.reported.kind == "call"
    ]
    assert (line.time, line.instance) == (1.0, "Heater0")
    assert line.text == "Heater0.setup.set_room(18.5) -> 20.0"
    bench.close()


def test_samples_of_connections_are_counted(warm: Path) -> None:
    bench = Bench("systems/warm")
    page, session = bench.page(), bench.session
    page.done("step", 1.5)

    def changed() -> bool:
        return session.flows.changed(
            session.now, session.connectors, session.channels.source
        )

    assert changed()
    assert not changed()
    page.done("deactivated", ["Controller0"])
    page.done("step", 60.0)
    assert changed()
    [flow] = [f for f in session.flows.latest if "temperature" in f.name]
    assert flow.rate == pytest.approx(10.0, abs=0.5)
    assert flow.lost > 0
    assert flow.details == f"{flow.lost} overwritten in a full buffer"
    bench.close()
