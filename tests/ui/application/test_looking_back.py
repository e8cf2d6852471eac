"""A page shows a past time of the run, over the real socket, while the run goes on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from patience import PATIENCE
from ui_bench import GOAL, QUIET, serving
from websockets.sync.client import ClientConnection, connect

from rtgen.ui.history import MAX_LINES, History
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import EventKind
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

PORT = "Odometry0.OdometryPosition"


class Page:
    """A page that applies events as the real one does."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.states: dict[str, str] = {}
        self.times: dict[str, list[float]] = {}
        self.parameters: dict[str, str] = {}
        self.wires: set[str] = set()
        self.lines: list[float] = []
        self.whole = ui.SystemState()
        self.clock = ui.ClockState()
        self.number = 0
        self.until(EventKind.EVENT_SYSTEM)

    def until(self, kind: EventKind) -> Any:
        """Process events until one of a kind; return its value."""
        while True:
            data = self.socket.recv(PATIENCE)
            assert isinstance(data, bytes)
            found = None
            for event in ui.ServerMessage.from_cdr(data).events:
                self.take(event)
                if event.discriminator is kind:
                    found = event
            if found is not None:
                return found.value

    def take(self, event: ui.Event) -> None:
        value: Any = event.value
        match event.discriminator:
            case EventKind.EVENT_SYSTEM:
                self.whole, self.clock = value, value.time
                self.states = {c.instance: c.current.name for c in value.components}
                self.wires = {c.name for c in value.connections}
                self.times, self.lines = {}, []
            case EventKind.EVENT_TIME:
                self.clock = value
            case EventKind.EVENT_STATE:
                self.states[value.instance] = value.after.name
                self.lines.append(value.time)
            case EventKind.EVENT_PARAMETER:
                self.parameters[value.parameter] = value.text
            case EventKind.EVENT_CUT:
                self.wires.discard(value)
            case EventKind.EVENT_CONNECTED:
                self.wires.add(value.name)
            case EventKind.EVENT_SAMPLES:
                ports = {
                    c.id: f"{c.port.instance}.{c.port.port}"
                    for c in self.whole.channels
                }
                for each in value:
                    self.times.setdefault(ports[each.channel], []).append(each.time)

    def ask(self, branch: str, value: Any) -> ui.Result:
        self.number += 1
        asked = getattr(ui.Command, f"of_{branch}")(value)
        self.socket.send(ui.ClientMessage(request=self.number, asked=asked).to_cdr())
        while True:
            result: ui.Result = self.until(EventKind.EVENT_RESULT)
            if result.request == self.number:
                return result

    def done(self, branch: str, value: Any) -> None:
        result = self.ask(branch, value)
        assert result.done, result.message

    def watch(self, *ports: str) -> None:
        self.done(
            "channels",
            [
                c.id
                for c in self.whole.channels
                if f"{c.port.instance}.{c.port.port}" in ports
            ],
        )


@pytest.fixture
def server() -> Iterator[Server]:
    """Yield a server for each test: times count from the start of its run."""
    project = CommandProject(QUIET, [str(GOAL)])
    with serving(Server(Session(project, str(GOAL)), "127.0.0.1", 0)) as found:
        yield found


@pytest.fixture
def pages(server: Server) -> Iterator[Any]:
    with ExitStack() as sockets:

        def join(*, full: bool = True) -> Page:
            token = server.tokens.full if full else server.tokens.read_only
            address = f"ws://{server.host}:{server.port}/socket?token={token}"
            return Page(sockets.enter_context(connect(address, max_size=None)))

        yield join


def test_a_page_sees_the_run_as_it_was(pages: Any) -> None:
    page = pages()
    page.watch(PORT)
    page.done("step", 1.0)
    wires = set(page.wires)
    wire = min(wires)
    page.done("connection", wire)
    page.done("deactivated", ["Odometry0"])
    page.done("step", 1.0)
    assert page.states["Odometry0"] == "STATE_INACTIVE"

    page.done("looked", 0.99)
    assert page.clock.past
    assert (page.clock.now, page.clock.first, page.clock.last) == (0.99, 0.0, 2.0)
    assert page.states["Odometry0"] == "STATE_ACTIVE"
    assert page.wires == wires
    assert 0.9 < max(page.times[PORT]) <= 0.99
    assert max(page.lines) <= 0.99

    page.done("looked", 0.0)
    assert max(page.times.get(PORT, [0.0])) == 0.0

    page.done("looked", 1e9)
    assert (page.clock.now, page.states["Odometry0"]) == (2.0, "STATE_INACTIVE")
    assert page.wires == wires - {wire}

    page.done("looked", -1.0)
    assert not page.clock.past
    assert page.states["Odometry0"] == "STATE_INACTIVE"
    assert len(page.times[PORT]) > 10


def test_the_run_goes_on_and_other_pages_with_it(pages: Any) -> None:
    looking, live = pages(), pages()
    live.watch(PORT)
    live.done("step", 0.5)
    looking.done("looked", 0.2)
    live.done("step", 0.5)
    assert live.clock.now == 1.0
    looking.watch(PORT)
    assert (looking.clock.now, max(looking.times[PORT]) <= 0.2) == (0.2, True)
    live.done("time", 0.3)
    looking.until(EventKind.EVENT_SYSTEM)
    assert not looking.clock.past, "the run is another one: there is no such past"


def test_looking_needs_no_right(pages: Any) -> None:
    pages().done("step", 0.5)
    page = pages(full=False)
    page.done("looked", 0.25)
    assert page.clock.now == 0.25
    assert page.ask("looked", math.nan).code == "UIS0005"
    assert page.ask("paused", True).code == "UIS0002"


def change(time: float, after: ui.State) -> ui.Event:
    return ui.Event.of_change(ui.StateChange(time=time, instance="A0", after=after))


def test_of_many_changes_the_newest_of_each_part_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rtgen.ui.history.MAX_CHANGES", 1000)
    history = History()
    history.begin(ui.SystemState(components=[ui.Component(instance="A0")]))
    cut = ui.Event.of_cut("gone")
    history.add(0.0, cut)
    for i in range(3000):
        history.add(float(i), change(i, ui.State.STATE_ACTIVE))
    events = history.at(history.nearest(2500.0), [], ())
    assert cut in events
    times = [e.change.time for e in events if e.discriminator is EventKind.EVENT_STATE]
    assert times == [float(i) for i in range(2501 - MAX_LINES, 2501)]
    assert history.first > 0.0
    assert history.nearest(0.0) == history.first


def test_of_a_long_run_older_samples_are_thinned_out() -> None:
    history = History()
    for i in range(10_000):
        history.sample(ui.Sample(channel=1, time=i / 1000, data=b""))
    [event] = history.samples(9.0, [1])
    times = [each.time for each in event.samples]
    assert len(times) == ui.MAX_SAMPLES
    assert times[1000:] == [i / 1000 for i in range(8001, 9001)]
    assert times[0] == 0.0
    steps = {round(b - a, 3) for a, b in itertools.pairwise(times[:1000])}
    assert steps == {0.008}


def test_of_many_frames_those_with_rare_identifiers_stay() -> None:
    history = History()
    for i in range(5000):
        can_id = 0x81 if i == 10 else 0x180 + i % 2
        frame = ui.Frame(time=i / 1000, bus="can0", can_id=can_id)
        history.add(frame.time, ui.Event.of_traffic([frame]))
    [event] = [
        e
        for e in history.at(4.999, [], ())
        if e.discriminator is EventKind.EVENT_FRAMES
    ]
    times = [frame.time for frame in event.traffic]
    assert times == sorted(times)
    assert times[-1000:] == [i / 1000 for i in range(4000, 5000)]
    assert len(times) < 3000
    ids = [frame.can_id for frame in event.traffic[:-1000]]
    assert ids.count(0x81) == 1
    assert abs(ids.count(0x180) - ids.count(0x181)) < 10


def test_the_oldest_samples_go_first() -> None:
    history = History(max_octets=100_000)
    for i in range(1000):
        sample = ui.Sample(channel=1, time=i / 10, data=bytes(100))
        history.sample(sample)
        history.add(i / 10, ui.Event.of_traffic([ui.Frame(time=i / 10, bus="can0")]))
    [samples] = history.samples(history.last, [1])
    assert history.first < samples.samples[0].time
    assert samples.samples[-1].time == 99.9
    assert len(samples.samples) < 100_000 / 300
    assert history.samples(history.first, [1, 2]) == []
