"""A run shown beside the current one, and runs that are recorded while pages show them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from pathlib import Path

import pytest
from ui_bench import GOAL, Bench, Page, channels, whole

from rtgen.cli import run
from rtgen.ui.bus_description import BusDescriber
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import EventKind
from rtgen.ui.recorded import Recorded

PORT = "PathFollower0.velocity"
SLOWER = ui.SetParameter("PathFollower0", "", "max_w", "0.1")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a recording of one second, in which the robot is slower than in the file."""
    file = str(tmp_path_factory.mktemp("recording") / "slow.mcap")
    command = ["run", str(GOAL), "--until", "1", "--record", file, "-q"]
    assert run([*command, "--set", "PathFollower0.max_w=0.1"]) == 0
    return file


def numbers(state: ui.SystemState) -> tuple[int, int]:
    """Return the numbers of the port's channels, in the run and beside it."""
    found = [(each.beside, each.id) for name, each in channels(state) if name == PORT]
    return dict(found)[False], dict(found)[True]


def samples(events: Iterable[ui.Event], channel: int) -> list[ui.Sample]:
    return [
        each
        for event in events
        if event.discriminator is EventKind.EVENT_SAMPLES
        for each in event.samples
        if each.channel == channel
    ]


def states_beside(events: Iterable[ui.Event]) -> list[tuple[str, str]]:
    return [
        (event.other.instance, event.other.after.name)
        for event in events
        if event.discriminator is EventKind.EVENT_BESIDE
    ]


def passed(bench: Bench, page: Page) -> list[ui.Event]:
    """Return the events that report the time that has passed to the page."""
    bench.session._report()
    return [*page.seen, *page.events()]


def test_a_recording_is_shown_as_the_system_goes_on(recording: str) -> None:
    bench = Bench(beside=recording)
    page = bench.page()
    state = whole(page.events())
    assert (state.beside, state.keeps) == ("slow.mcap", False)
    own, other = numbers(state)
    page.done("channels", [own, other])
    page.done("step", 0.5)
    events = passed(bench, page)
    assert ("PathFollower0", "STATE_ACTIVE") in states_beside(events)
    times = [each.time for each in samples(events, other)]
    assert times == [each.time for each in samples(events, own)]
    assert len(times) == 500
    page.done("step", 1.5)
    later = samples(passed(bench, page), other)
    assert len({each.time for each in later}) == len(later) == 500
    page.done("looked", 0.3)
    [past] = [e for e in page.seen if e.discriminator is EventKind.EVENT_SYSTEM]
    assert past.whole.time.now == 0.3
    shown = samples(page.seen, other)
    assert shown[-1].time == pytest.approx(0.3)
    page.done("looked", -1.0)
    page.done("kept", False)
    assert whole(page.seen).beside == ""
    bench.close()


def test_a_run_is_kept_beside_the_next_one() -> None:
    bench = Bench()
    page = bench.page()
    page.events()
    page.done("step", 1.0)
    page.done("kept", True)
    assert whole(page.seen).keeps
    page.done("setting", SLOWER)
    page.done("time", 0.0)
    state = whole(page.seen)
    assert state.beside == "the run before"
    own, other = numbers(state)
    page.done("channels", [own, other])
    page.done("step", 1.0)
    events = passed(bench, page)
    before, now = samples(events, other), samples(events, own)
    assert [each.time for each in before] == [each.time for each in now]
    assert [each.data for each in before] != [each.data for each in now]
    # The same run stays beside, until it is switched off.
    page.done("time", 0.05)
    assert whole(page.seen).beside == "the run before"
    assert numbers(whole(page.seen))[1] == other
    page.done("kept", False)
    assert not whole(page.seen).keeps
    page.done("time", 0.0)
    assert whole(page.seen).beside == ""
    bench.close()


def test_a_page_has_the_whole_run_beside_after_a_leap_in_time() -> None:
    bench = Bench()
    page = bench.page()
    page.events()
    page.done("step", 6.0)
    page.done("kept", True)
    page.done("time", 0.0)
    own, other = numbers(whole(page.seen))
    page.done("channels", [own, other])
    page.done("step", 6.0)
    times = [each.time for each in samples(passed(bench, page), other)]
    assert len(times) == ui.MAX_SAMPLES
    assert times == sorted(times)
    assert times[0] < 0.01
    assert times[-1] > 5.99
    assert max(b - a for a, b in itertools.pairwise(times)) < 0.02
    bench.close()


def test_each_run_is_recorded_in_a_file(tmp_path: Path) -> None:
    bench = Bench(record=tmp_path / "run.mcap")
    page = bench.page()
    page.done("step", 0.2)
    page.done("added", ui.AddComponent("Odometry", "Second0"))
    page.done("setting", SLOWER)
    page.done("step", 0.1)
    page.done("time", 0.0)
    page.done("step", 0.4)
    bench.close()
    files = sorted(tmp_path.iterdir())
    assert [each.name for each in files] == ["run-2.mcap", "run.mcap"]
    ends = []
    for file in files:
        recorded = Recorded([str(file)], lambda *_: BusDescriber(None))
        ends.append(recorded.history.last)
        [first, *events] = recorded.history.at(recorded.history.last, [], ())
        types = {each.instance: each.type for each in first.whole.components}
        assert types["Second0"] == "Odometry"
        settings = [
            e.setting.text
            for e in events
            if e.discriminator is EventKind.EVENT_PARAMETER
            and e.setting.parameter == "max_w"
        ]
        assert settings == ["0.1"]
    assert ends == pytest.approx([0.4, 0.3], abs=0.01)


def test_a_page_that_is_loaded_again_has_the_timeline() -> None:
    bench = Bench()
    page = bench.page()
    page.done("step", 0.2)
    bench.session.notice("test", "Odometry0", "something")
    events = bench.page().events()
    assert events[0].discriminator is EventKind.EVENT_HELLO
    assert whole(events).time.past is False
    lines = [e.change for e in events if e.discriminator is EventKind.EVENT_STATE]
    assert {line.instance for line in lines} == {*bench.session.system.instances}
    notices = [e.reported for e in events if e.discriminator is EventKind.EVENT_NOTICE]
    assert [each.text for each in notices] == ["something"]
    bench.close()


def test_pages_keep_their_samples_when_a_run_is_kept() -> None:
    bench = Bench()
    page = bench.page()
    found = dict(channels(whole(page.events())))
    channel = found["Odometry0.OdometryPosition"]
    page.done("channels", [channel.id])
    page.done("step", 1.0)
    page.done("kept", True)
    assert whole(page.seen).keeps
    assert samples(page.seen, channel.id)
    bench.close()
