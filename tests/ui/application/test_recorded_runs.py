"""Recordings on the page, without a system: over the real socket, and in a real browser."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from test_looking_back import PORT, Page
from ui_bench import GOAL, QUIET, ROOT, opened, select, serving, until
from websockets.sync.client import connect

from rtgen.cli import run
from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime import Component
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.ui.bus_description import BusDescriber
from rtgen.ui.outbox import Outbox
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol.ui import EventKind, ServerMessage
from rtgen.ui.recorded import Recorded
from rtgen.ui.serving import Server

BUS = ROOT / "specs/canopen/fourx.toml"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("recordings")
    found = [str(folder / name) for name in ("short.mcap", "long.mcap")]
    for file, end in zip(found, ("1", "2"), strict=True):
        assert run(["run", str(GOAL), "--until", end, "--record", file, "-q"]) == 0
    return found


@pytest.fixture(scope="module")
def recorded(files: list[str]) -> Iterator[Server]:
    session = Recorded(files, lambda *_: BusDescriber(None))
    with serving(Server(session, "127.0.0.1", 0)) as server:
        yield server


def test_texts_and_numbers_that_pages_cannot_hold(tmp_path: Path) -> None:
    path = tmp_path / "odd\udcff.mcap"
    with McapWriter(path) as writer:
        channel = writer.channel("/a\0b", "json", 0, {"unit": "\0"})
        writer.message(channel, 0, b'{"x": NaN, "y": [-Infinity], "\\u0000": 1}')
    session = Recorded([str(path)], lambda *_: BusDescriber(None))
    page = Outbox(lambda: None)
    session.join(page)
    [state] = [
        each.whole
        for each in ServerMessage.from_cdr(page.take()).events
        if each.discriminator is EventKind.EVENT_SYSTEM
    ]
    assert state.name == "odd\N{REPLACEMENT CHARACTER}.mcap"
    [topics] = state.components
    assert topics.ports[0].name == "/a\N{REPLACEMENT CHARACTER}b"
    assert topics.ports[0].unit == "\N{REPLACEMENT CHARACTER}"
    [sample] = session.history.samples(1.0, {state.channels[0].id})[0].samples
    assert b"NaN" in sample.data
    refused: list[str] = []
    value = json.loads(sample.data, parse_constant=refused.append)
    assert value == {"x": "NaN", "y": ["-Infinity"], "\0": 1}
    assert refused == []


def test_two_recordings_are_scrubbed_beside_each_other(recorded: Server) -> None:
    address = (
        f"ws://{recorded.host}:{recorded.port}/socket?token={recorded.tokens.full}"
    )
    with connect(address, max_size=None) as socket:
        page = Page(socket)
        assert (page.whole.name, page.whole.beside) == ("short.mcap", "long.mcap")
        assert page.clock.kind.name == "CLOCK_RECORDING"
        assert page.clock.now == page.clock.first == 0.0
        assert 1.9 < page.clock.last <= 2.0
        follower = next(
            c for c in page.whole.components if c.instance == "PathFollower0"
        )
        ports = {(p.name, p.kind.name, p.type) for p in follower.ports}
        assert ports >= {
            ("velocity", "PORT_OUT", "IIS::TimedVelocity2D"),
            ("position", "PORT_IN", "IIS::TimedPose2D"),
        }

        assert len(page.wires) == 10, "the shutdown is not shown"
        page.done("looked", 0.5)
        assert page.clock.now == 0.5
        assert len(page.wires) == 10
        assert set(page.states.values()) == {"STATE_ACTIVE"}
        assert float(page.parameters["max_v"]) > 0
        [mine, other] = [
            c for c in page.whole.channels if f"{c.port.instance}.{c.port.port}" == PORT
        ]
        assert (mine.beside, other.beside) == (False, True)
        node = page.whole.types[mine.type_number]
        assert node.name == "IIS::TimedPose2D"
        page.done("channels", [mine.id, other.id])
        assert max(page.times[PORT]) <= 0.5
        both = len(page.times[PORT])
        page.done("channels", [])
        page.done("looked", 1.5)
        page.done("channels", [mine.id])
        assert 0.9 < max(page.times[PORT]) <= 1.0
        page.done("looked", 0.5)
        assert len(page.times[PORT]) * 2 == both

        result = page.ask("activated", ["Odometry0"])
        assert (result.done, result.code) == (False, "UIS0009")


def test_frames_of_a_recording_are_decoded(tmp_path: Path) -> None:
    file = str(tmp_path / "bus.mcap")
    system = str(ROOT / "specs/canopen/fourx.xml")
    assert run(["run", system, "--until", "1.5", "--record", file, "-q"]) == 0
    history = Recorded([file], lambda *_: BusDescriber(BUS)).history
    events = history.at(history.nearest(1.4), [], ())
    [buses] = [
        e.described_bus for e in events if e.discriminator is EventKind.EVENT_BUS
    ]
    assert "operational" in {node.nmt_state for node in buses.nodes}
    [frames] = [e.traffic for e in events if e.discriminator is EventKind.EVENT_FRAMES]
    assert {"heartbeat", "tpdo2"} <= {frame.kind for frame in frames}
    assert max(frame.time for frame in frames) <= 1.4
    [load] = [e.carried for e in events if e.discriminator is EventKind.EVENT_LOAD]
    assert 0.0 < load.load < 1.0


def test_calls_to_a_board_have_their_values(tmp_path: Path) -> None:
    file = str(tmp_path / "board.mcap")
    command = ["run", str(ROOT / "specs/tecs/rh3_board.xml"), "--until", "0.2"]
    assert run([*command, "--record", file, "-q"]) == 0
    codec = CommandProject(QUIET, [str(GOAL)]).codec
    history = Recorded([file], lambda *_: BusDescriber(None), codec).history
    calls = [
        e.call
        for e in history.at(history.last, [], ())
        if e.discriminator is EventKind.EVENT_BOARD_CALL
    ]
    drive = next(c for c in calls if c.function == "sMotorBoard.drive")
    assert [each.name for each in drive.request_values] == ["speed", "count"]
    assert [each.name for each in drive.reply_values] == ["return", "state"]
    made: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Component, "__init__", lambda _, name: made.append(name))
        assert codec("PathFollower") is codec("Nothing") is None
    assert made == []


def test_what_is_no_recording_is_reported(
    tmp_path: Path, files: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "run.log"
    log.write_text('{"t": 0, "event": "state"}\n')
    with pytest.raises(ToolError, match="log in JSON lines"):
        Recorded([str(log)], lambda *_: BusDescriber(None))
    empty = tmp_path / "empty.mcap"
    empty.touch()
    assert run(["ui", str(empty), "--no-open"]) == 3
    assert run(["ui", str(GOAL), str(empty), "--no-open"]) == 3
    assert run(["ui", *files, files[0], "--no-open"]) == 2
    assert run(["ui", str(GOAL), *files, "--no-open"]) == 2
    assert run(["ui", files[0], "--record", str(empty), "--no-open"]) == 2
    err = capfd.readouterr().err
    assert "is empty" in err
    assert "compared with one system or one other recording" in err
    assert "no system runs" in err
    assert "Traceback" not in err


def test_of_a_long_recording_the_end_is_kept(files: list[str]) -> None:
    session = Recorded(files[1:], lambda *_: BusDescriber(None), max_octets=200_000)
    assert session.left_out
    assert 0.0 < session.history.first < session.history.last


@pytest.mark.nightly
@pytest.mark.peer
def test_the_page_overlays_both(browser: Any, recorded: Server) -> None:
    with opened(browser, recorded.address(full=True)) as page:
        select(page, "Odometry0")
        values = page.get_by_role("region", name=PORT)
        values.get_by_role("columnheader", name="beside", exact=True).wait_for()
        values.get_by_role("row", name="data.position.x").wait_for()
        slider = page.get_by_role("slider", name="Look at time")
        slider.press("Home")
        time = page.get_by_label("Time of the run")
        until(page, lambda: time.inner_text() == "0.000 s")
        page.get_by_role("button", name="Play").click()
        until(page, lambda: float(time.inner_text().removesuffix(" s")) > 0.3)
        page.get_by_role("button", name="Pause").press("Enter")
        assert page.get_by_text("beside: ACTIVE").count() == 1
