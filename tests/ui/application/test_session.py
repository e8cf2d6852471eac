"""Commands of a page: the state of the system behind it, and the events to every page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from shutil import copytree

import pytest
from ui_bench import GOAL, ROOT, Bench, Page, channels, whole

from refrobots.iis import TimedVelocity2D
from rtgen.cli import run as rtgen
from rtgen.compiler.systems.reading import read_file
from rtgen.runtime import ACTIVE_STATE, INACTIVE_STATE, RealClock, xcdr
from rtgen.ui.bus_description import BusDescriber
from rtgen.ui.flows import Chains
from rtgen.ui.outbox import MAX_CHANGES, MAX_SAMPLES
from rtgen.ui.protocol import ui
from rtgen.ui.recorded import Recorded

VELOCITY = "PathFollower0.velocity_RefHardRh30.InTargetVelocity"
WIRE = ui.Connect(
    source=ui.PortAddress("PathFollower0", "velocity"),
    target=ui.PortAddress("RefHardRh30", "InTargetVelocity"),
    name="by_hand",
)


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench()
    yield made
    made.close()


@pytest.fixture
def page(bench: Bench) -> Page:
    return bench.page()


def test_a_page_gets_the_whole_state(bench: Bench, page: Page) -> None:
    events = page.events()
    assert events[0].greeting.full
    state = whole(events)
    assert [c.instance for c in state.components] == list(
        bench.session.system.instances
    )
    assert len(state.connections) == len(bench.session.system.connectors) == 10
    follower = next(c for c in state.components if c.instance == "PathFollower0")
    assert {p.name for p in follower.parameters} >= {"max_v"}
    assert follower.placed
    assert any(entry.type == "PathFollower" for entry in state.palette)
    named = dict(channels(state))
    node = state.types[named["PathFollower0.velocity"].type_number]
    assert node.name == "IIS::TimedVelocity2D"


def test_connections_are_cut_and_made_while_it_runs(bench: Bench, page: Page) -> None:
    system = bench.session.system
    page.done("step", 0.5)
    [connector] = [
        c for c in system.connectors if str(c.target) == "RefHardRh30.InTargetVelocity"
    ]
    page.done("connection", connector.name)
    assert ui.EventKind.EVENT_CUT in page.kinds()
    assert connector not in system.connectors
    page.done("wire", WIRE)
    assert system.connector("by_hand").source is connector.source
    page.done("undone", True)
    page.done("undone", True)
    assert system.connector(connector.name).properties == connector.properties
    page.done("redone", True)
    assert connector.name not in [c.name for c in system.connectors]
    result = page.ask("connection", connector.name)
    assert (result.done, result.code) == (False, "UIS0003")
    page.done("step", 0.5)
    assert system.state("RefHardRh30") is ACTIVE_STATE


def test_members_of_samples_have_their_own_units(page: Page) -> None:
    system = whole(page.events())
    ports = {
        f"{c.instance}.{p.name}": {v.name: v.text for v in p.units}
        for c in system.components
        for p in c.ports
    }
    lengths, angle = dict.fromkeys("xyr", "m"), {"theta": "rad"}
    speeds = {"v": "m/s", "w": "rad/s"}
    assert ports["Navigation0.path"] == {**lengths, **angle, **speeds}
    assert ports["PathFollower0.velocity"] == {
        "data.vx": "m/s",
        "data.vy": "m/s",
        "data.va": "rad/s",
    }


def test_only_ports_that_fit_are_offered(page: Page) -> None:
    port = ui.PortAddress("Odometry0", "OdometryPosition")
    fits = page.done("ends", port).fits
    fitting = {f"{f.port.instance}.{f.port.port}" for f in fits if not f.refused}
    assert "OmniTo2WD0.goal" in fitting
    refused = {f"{f.port.instance}.{f.port.port}": f.refused for f in fits if f.refused}
    assert "different types" in refused["RefHardRh30.InTargetVelocity"]
    assert "connected already" in refused["Navigation0.position"]
    wrong = ui.Connect(source=port, target=ui.PortAddress("Odometry0", "nothing"))
    result = page.ask("wire", wrong)
    assert result.code == "UIS0004"
    assert "nothing" in result.message
    assert page.ask("ends", ui.PortAddress("Odometry0", "none")).code == "UIS0003"
    assert page.ask("ends", ui.PortAddress("Nobody0", "none")).code == "UIS0003"


def test_states_are_asked_for_and_told(bench: Bench, page: Page) -> None:
    system, other = bench.session.system, bench.page()
    page.done("step", 0.1)
    other.events()
    page.done("deactivated", ["Odometry0"])
    assert system.state("Odometry0") is ACTIVE_STATE
    page.done("step", 0.1)
    assert system.state("Odometry0") is INACTIVE_STATE
    [change] = [
        e.change for e in other.events() if e.discriminator is ui.EventKind.EVENT_STATE
    ]
    assert (change.instance, change.after) == ("Odometry0", ui.State.STATE_INACTIVE)
    result = page.ask("deactivated", ["Odometry0"])
    assert result.code == "UIS0006"
    assert "PRECONDITION_NOT_MET" in result.message
    page.done("deactivated", [])
    page.done("step", 0.2)
    assert {system.state(each) for each in system.instances} == {INACTIVE_STATE}
    for request in ("deactivated", "restored"):
        result = page.ask(request, [])
        assert (result.done, result.code) == (False, "UIS0006")
        assert "no component is in a state for it" in result.message
    page.done("activated", [])
    page.done("step", 0.2)
    assert {system.state(each) for each in system.instances} == {ACTIVE_STATE}


def test_parameters_are_set_within_their_range(bench: Bench, page: Page) -> None:
    sets = bench.session.system.component("PathFollower0").configuration_sets
    before = sets.texts()["max_v"]
    change = ui.SetParameter("PathFollower0", "", "max_v", "0.2")
    page.done("setting", change)
    page.done("step", 0.1)
    assert sets.texts(sets.active)["max_v"] == "0.2"
    assert bench.session.system.component("PathFollower0").config.max_v == 0.2
    change.text = "-4"
    result = page.ask("setting", change)
    assert result.code == "UIS0005"
    assert sets.texts(sets.active)["max_v"] == "0.2"
    page.done("undone", True)
    assert sets.texts(sets.active)["max_v"] == before
    change.parameter = "maximum"
    assert page.ask("setting", change).code == "UIS0003"
    page.done("setting", ui.SetParameter("PathFollower0", "slow", "max_v", "0.1"))
    page.done("chosen", ui.ActiveSet("PathFollower0", "slow"))
    assert sets.active == "slow"
    page.done("undone", True)
    assert sets.active != "slow"
    assert "slow" in sets.ids
    page.done("undone", True)
    assert "slow" not in sets.ids
    [event] = [e for e in page.seen if e.discriminator is ui.EventKind.EVENT_COMPONENT]
    assert [each.name for each in event.described.configuration_sets] == ["default"]
    page.done("redone", True)
    assert sets.texts("slow")["max_v"] == "0.1"


def test_components_are_added_and_removed(bench: Bench, page: Page) -> None:
    page.events()
    other = bench.page()
    wanted = ui.AddComponent("Odometry", "", True, ui.Location(10.0, 20.0))
    page.done("added", wanted)
    assert "Odometry1" in bench.session.system.instances
    kinds = [e.discriminator for e in other.events()]
    assert ui.EventKind.EVENT_COMPONENT in kinds
    assert ui.EventKind.EVENT_CHANNEL in kinds
    page.done("removed", "Odometry0")
    assert "Odometry0" not in bench.session.system.instances
    assert len(bench.session.system.connectors) < 10
    page.done("undone", True)
    assert "Odometry0" in bench.session.system.instances
    assert len(bench.session.system.connectors) == 10
    page.done("undone", True)
    assert "Odometry1" not in bench.session.system.instances
    assert page.ask("added", ui.AddComponent(type="Nothing")).code == "UIS0003"
    assert page.ask("removed", "Odometry1").code == "UIS0003"


@pytest.mark.parametrize(
    "name", ["a.b", "a/b", "..", "a\\b", "x\x01y", "two\nlines", "\ufffe", "Q" * 101]
)
def test_names_that_no_component_can_have_are_refused(page: Page, name: str) -> None:
    assert page.ask("added", ui.AddComponent("Odometry", name)).code == "UIS0005"


def test_two_components_cannot_have_one_name(bench: Bench, page: Page) -> None:
    before = bench.session.system.instances
    result = page.ask("added", ui.AddComponent("Odometry", "Odometry0"))
    assert result.message == "the system has a component 'Odometry0' already"
    assert bench.session.system.instances == before
    assert bench.session.edit_state().saved
    for name in ("日本 0", "<b>", "Q" * 100):
        page.done("added", ui.AddComponent("Odometry", name))
        assert page.ask("added", ui.AddComponent("Odometry", name)).code == "UIS0005"
    ends = ui.PortAddress("Odometry0", "OdometryPosition")
    other = ui.PortAddress("OmniTo2WD0", "goal")
    result = page.ask("wire", ui.Connect(ends, other, VELOCITY))
    assert (result.code, "already" in result.message) == ("UIS0004", True)


def test_a_system_is_saved_with_its_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copytree(GOAL.parent, tmp_path / "systems")
    file = tmp_path / "systems" / "made.xml"
    monkeypatch.chdir(ROOT)
    bench = Bench(tmp_path / "systems" / GOAL.name)
    page = bench.page()
    page.done("place", ui.Moved("Odometry0", ui.Location(321.0, 123.0)))
    page.done(
        "wire",
        ui.Connect(
            source=ui.PortAddress("Odometry0", "OdometryPosition"),
            target=ui.PortAddress("OmniTo2WD0", "goal"),
        ),
    )
    assert bench.session.edit_state().undo.startswith("connect")
    page.done("file", str(file))
    assert bench.session.edit_state().saved
    saved, found, _ = read_file(file)
    assert not found
    assert saved is not None
    assert len(saved.connections) == 11
    places = {c.instance: c.location for c in saved.components}
    assert places["Odometry0"] is not None
    assert places["Odometry0"][:2] == (321, 123)
    in_yaml = file.with_suffix(".yaml")
    page.done("file", str(in_yaml))
    loaded, found, _ = read_file(in_yaml)
    assert not found
    assert loaded is not None
    assert [c.location for c in loaded.components] == [*places.values()]
    again = Bench(file, GOAL)
    assert len(again.session.system.connectors) == 11
    other = file.with_name("other.yaml")
    other.write_text("a: 1\n")
    outside = file.parent.parent / "made.xml"
    for refused in ("/etc/made.xml", outside, f"{file}.txt", other):
        result = page.ask("file", str(refused))
        assert result.code == "UIS0010", refused
    again.page().done("system", str(GOAL))
    assert len(again.session.system.connectors) == 10
    assert again.page().ask("system", "/etc/passwd").code == "UIS0003"
    again.close()
    bench.close()


def test_samples_go_to_pages_that_watch(bench: Bench, page: Page) -> None:
    state = whole(page.events())
    number = dict(channels(state))["PathFollower0.velocity"].id
    page.done("step", 0.1)
    assert ui.EventKind.EVENT_SAMPLES not in page.kinds()
    page.done("channels", [number])
    written: list[bytes] = []
    bench.session.system.watch_port(
        "PathFollower0", "velocity", lambda value: written.append(value.to_cdr())
    )
    page.done("step", 0.05)
    [samples] = [
        e.samples for e in page.seen if e.discriminator is ui.EventKind.EVENT_SAMPLES
    ]
    assert {s.channel for s in samples} == {number}
    times = [s.time for s in samples]
    assert times == sorted(times)
    assert [s.data[4:] for s in samples] == written
    assert len(written) == 50


def test_channels_that_do_not_exist_are_not_watched(page: Page) -> None:
    numbers = {c.id for _, c in channels(whole(page.events()))}
    page.done("channels", [*range(max(numbers) + 100_000)])
    assert page.outbox.watched == numbers


def test_a_page_gets_what_a_channel_had_before_it_is_watched(
    bench: Bench, page: Page
) -> None:
    page.done("time", 0.1)
    number = dict(channels(whole(page.seen)))["PathFollower0.velocity"].id
    page.done("channels", [number])
    [event] = [e for e in page.seen if e.discriminator is ui.EventKind.EVENT_SAMPLES]
    assert {s.channel for s in event.samples} == {number}
    assert event.samples[-1].time == pytest.approx(0.099)


LOOKING = {
    "channels": [],
    "ends": ui.PortAddress("Odometry0", "OdometryPosition"),
    "looked": -1.0,
    "listed": True,
}
NODE = ui.NodeAddress("can0", 1)
CHANGING = {
    "wire": WIRE,
    "connection": VELOCITY,
    "activated": ["Odometry0"],
    "deactivated": ["Odometry0"],
    "restored": ["Odometry0"],
    "setting": ui.SetParameter("PathFollower0", "", "max_v", "0.2"),
    "chosen": ui.ActiveSet("PathFollower0", "default"),
    "called": ui.Call(ui.PortAddress("RefHardRh30", "InventGUIRefHard"), "", "Stop"),
    "added": ui.AddComponent("Odometry"),
    "removed": "Odometry0",
    "place": ui.Moved("Odometry0"),
    "file": "x.xml",
    "replaced": "x.xml",
    **dict.fromkeys(("undone", "redone", "played", "paused", "reset", "kept"), True),
    "step": 1.0,
    "speed": 2.0,
    "time": 0.0,
    "system": str(GOAL),
    "frame": ui.SendFrame("can0", 0),
    "managed": ui.NmtCommand("can0", 0, "start"),
    "read": ui.SdoAccess("can0", 1, 0x6040, 0, ""),
    "written": ui.SdoAccess("can0", 1, 0x6040, 0, "15"),
    "injected": ui.Inject(ui.PortAddress("RefHardRh30", "InTargetVelocity")),
    "renamed": ui.Rename(instance="Odometry0", name="Odometer0"),
    "adjusted": ui.Adjust(VELOCITY),
    "compared": "goal.mcap",
}
"""Every command of a page that may only look: those that it may give, and the others."""


def test_a_page_may_only_look(bench: Bench) -> None:
    page = bench.page(full=False)
    assert not page.events()[0].greeting.full
    kinds = {
        getattr(ui.Command, f"of_{branch}")(value).discriminator
        for branch, value in (LOOKING | CHANGING | {"node": NODE}).items()
    }
    assert kinds == {*ui.CommandKind}
    before = bench.session.whole()
    for branch, value in CHANGING.items():
        assert page.ask(branch, value).code == "UIS0002", branch
    assert bench.session.whole() == before
    for branch, value in LOOKING.items():
        page.done(branch, value)
    assert page.ask("node", NODE).code == "UIS0003"
    assert page.done("ends", LOOKING["ends"]).fits


def test_time_is_set_back_and_on(bench: Bench, page: Page) -> None:
    page.done("step", 2.0)
    page.done("setting", ui.SetParameter("PathFollower0", "", "max_v", "0.2"))
    page.done("time", 0.5)
    assert bench.session.now == 0.5
    assert ui.EventKind.EVENT_SYSTEM in page.kinds()
    sets = bench.session.system.component("PathFollower0").configuration_sets
    assert sets.texts(sets.active)["max_v"] == "0.2"
    assert page.ask("time", -1.0).code == "UIS0005"
    assert page.ask("undone", True).code == "UIS0008"
    page.done("speed", 2.0)
    assert bench.session.time().speed == 2.0
    assert page.ask("speed", float("nan")).code == "UIS0005"


def test_real_time_cannot_be_stopped() -> None:
    bench = Bench(clock=RealClock)
    page = bench.page()
    for branch, value in (("paused", True), ("step", 1.0), ("time", 0.0)):
        assert page.ask(branch, value).code == "UIS0009"
    bench.close()


def test_an_operation_is_called_and_a_sample_injected(bench: Bench, page: Page) -> None:
    state = whole(page.events())
    page.done("step", 0.1)
    hard = next(c for c in state.components if c.instance == "RefHardRh30")
    [port] = [p for p in hard.ports if p.interfaces and p.interfaces[0].provided][:1]
    interface = port.interfaces[0]
    stop = next(o for o in interface.operations if o.name == "Stop")
    assert not stop.refused
    address = ui.PortAddress("RefHardRh30", port.name)
    page.done("called", ui.Call(address, interface.name, "Stop", b""))
    result = page.ask("called", ui.Call(address, interface.name, "Halt", b""))
    assert (result.code, "Stop" in result.message) == ("UIS0003", True)
    hardware = bench.session.system.component("RefHardRh30")
    sample = TimedVelocity2D()
    sample.data.vx = 0.25
    payload = xcdr.serialize(sample, xcdr.representation_of(TimedVelocity2D, 1))
    target = ui.PortAddress("RefHardRh30", "InTargetVelocity")
    before = len(hardware.in_ports["InTargetVelocity"].connectors)
    page.done("injected", ui.Inject(target, payload))
    assert len(hardware.in_ports["InTargetVelocity"].connectors) == before + 1
    assert len(bench.session.system.connectors) == 10
    assert page.ask("injected", ui.Inject(target, payload[:9])).code == "UIS0005"
    wrong = ui.PortAddress("RefHardRh30", "nothing")
    assert page.ask("injected", ui.Inject(wrong, payload)).code == "UIS0003"


def test_a_page_that_does_not_read_is_sent_less(bench: Bench, page: Page) -> None:
    state = whole(page.events())
    number = dict(channels(state))["PathFollower0.velocity"].id
    page.done("channels", [number])
    ticks = bench.session.system.statistics("PathFollower0").ticks
    reader = bench.page()
    bench.session.runner.step(int(5e9))
    assert bench.session.system.statistics("PathFollower0").ticks == ticks + 5000
    events = page.events()
    [samples] = [
        e.samples for e in events if e.discriminator is ui.EventKind.EVENT_SAMPLES
    ]
    assert len(samples) <= MAX_SAMPLES
    [less] = [e.less for e in events if e.discriminator is ui.EventKind.EVENT_SENT_LESS]
    assert less.channels == [number]
    assert less.dropped + len(samples) >= 4999
    assert samples[-1].time == pytest.approx(4.999)
    for number in range(MAX_CHANGES + 1):
        bench.session.notice("test", "", str(number))
    assert reader.outbox.missed_changes
    assert len(reader.events()) >= MAX_CHANGES
    bench.session._report()
    assert whole(reader.events()).components


def test_hostile_names_are_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = GOAL.read_text(encoding="utf-8").replace(
        "Odometry0", "&lt;img src=x onerror=alert(1)&gt;"
    )
    copytree(ROOT / "specs/navigation", tmp_path / "systems")
    file = tmp_path / "systems" / "hostile.xml"
    file.write_text(text, encoding="utf-8")
    monkeypatch.chdir(ROOT)
    bench = Bench(file)
    state = whole(bench.page().events())
    assert "<img src=x onerror=alert(1)>" in {c.instance for c in state.components}
    bench.close()


def test_a_page_is_a_reader_of_what_is_only_written_for_readers(
    bench: Bench, page: Page
) -> None:
    port = "RefHardRh30.PlantPose"
    number = dict(channels(whole(page.events())))[port].id
    page.done("channels", [number])
    page.done("step", 0.05)
    [samples] = [
        e.samples for e in page.seen if e.discriminator is ui.EventKind.EVENT_SAMPLES
    ]
    assert len(samples) == 50
    assert (
        bench.session.system.component("RefHardRh30").out_ports["PlantPose"].unsent == 0
    )


def recorded(file: Path) -> dict[str, list[tuple[float, bytes]]]:
    """Return the samples of a recording by `INSTANCE.PORT`."""
    history = Recorded([str(file)], lambda *_: BusDescriber(None)).history
    state = whole(history.at(history.last, [], ()))
    names = {channel.id: name for name, channel in channels(state)}
    found: dict[str, list[tuple[float, bytes]]] = {name: [] for name in names.values()}
    for event in history.samples(history.last, frozenset(names)):
        for each in event.samples:
            found[names[each.channel]].append((each.time, each.data))
    return found


def test_a_run_is_the_same_with_and_without_a_page(tmp_path: Path) -> None:
    alone, shown = tmp_path / "alone.mcap", tmp_path / "shown.mcap"
    assert (
        rtgen(["run", str(GOAL), "-q", "--until", "0.5", "--record", str(alone)]) == 0
    )
    bench = Bench(record=shown)
    page = bench.page()
    page.done("channels", [c.id for _, c in channels(whole(page.events()))])
    page.done("step", 0.5)
    bench.close()
    without, with_page = recorded(alone), recorded(shown)
    assert without == with_page
    assert without["PathFollower0.velocity"]
    assert "RefHardRh30.PlantPose" not in without


def test_chains_are_measured_anew_when_connections_change(
    bench: Bench, page: Page
) -> None:
    chains = Chains(bench.session.system)
    chains.changed()
    page.done("step", 2.0)
    assert chains.changed()
    before = {each.name for each in chains.latest if each.samples}
    assert any(
        0.0 <= each.least <= each.median <= each.greatest < 1.0
        for each in chains.latest
        if each.samples
    )
    page.done("connection", VELOCITY)
    chains.changed()
    page.done("step", 2.0)
    chains.changed()
    after = {each.name for each in chains.latest}
    assert before - after
    assert any(each.samples for each in chains.latest)
