"""Components of other processes on the page: shown, controlled, configured, wired over CORBA."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from attached_page import Watching, ending
from patience import PATIENCE
from ui_bench import QUIET, started_over_corba

from refrobots.iis import TimedVelocity2D
from refrobots.rtc import TimedDoubleSeq
from rtgen.compiler.systems.reading import read_file
from rtgen.facts.openrtm_ports import foreign_instances
from rtgen.runtime import RealClock, xcdr
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.transport import NamedCorba
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session

INTERFACE = "RefHard"
SOURCE, TARGET = "PathFollower0.velocity", "RefHardRh30.InTargetVelocity"


@pytest.fixture(scope="module")
def names() -> Iterator[str]:
    with NameServer() as server:
        yield server.address


@pytest.fixture(scope="module")
def process(names: str) -> Iterator[subprocess.Popen[bytes]]:
    found = started_over_corba(names)
    yield found
    found.send_signal(signal.SIGCONT)
    found.terminate()
    found.wait(PATIENCE)


class Watcher(Watching):
    """A page that watches a naming service."""

    def __init__(
        self, names: str, transport: NamedCorba | None = None, file: str = ""
    ) -> None:
        files = [file] if file else []
        project = CommandProject(QUIET, files, transport=transport)
        own = None if transport is None else transport.rt_objects
        super().__init__(Session(project, file, RealClock, [names], own))


@pytest.fixture(scope="module")
def page(names: str, process: subprocess.Popen[bytes]) -> Iterator[Watcher]:
    found = Watcher(names)
    found.until(lambda: len(found.components) == 6 and len(found.wires()) == 10)
    active = {ui.State.STATE_ACTIVE}
    found.until(lambda: {c.current for c in found.components.values()} == active)
    yield found
    found.session.close()


def test_the_tree_and_its_components_are_shown(page: Watcher, names: str) -> None:
    [service] = page.services
    assert (service.address, service.silent) == (names, "")
    kinds = {each.path: (each.kind, each.instance) for each in service.bindings}
    name = f"{names}/Odometry0"
    assert kinds["Odometry0.rtc"] == (ui.BindingKind.BINDING_COMPONENT, name)
    odometry = page.components[name]
    assert (odometry.type, odometry.place, odometry.silent) == ("Odometry", names, "")
    assert [each.rate for each in odometry.contexts] == [100.0]
    ports = {each.name: (each.kind, each.type) for each in odometry.ports}
    kind = ui.PortKind.PORT_OUT
    assert ports["OdometryPosition"] == (kind, "IIS::TimedPose2D")
    assert (SOURCE, TARGET) in page.wires()


def test_states_are_asked_for(page: Watcher, names: str) -> None:
    name = f"{names}/PathFollower0"
    page.done("deactivated", [name])
    page.until(lambda: page.state(name) is ui.State.STATE_INACTIVE)
    refused = page.ask("deactivated", [name])
    assert refused.code == "UIS0006"
    assert "PRECONDITION_NOT_MET" in refused.message
    page.done("activated", [name])
    page.until(lambda: page.state(name) is ui.State.STATE_ACTIVE)


def test_parameters_are_set_by_the_component(page: Watcher, names: str) -> None:
    name = f"{names}/PathFollower0"

    def value() -> str:
        component = page.components[name]
        [found] = [s for s in component.configuration_sets if s.name == "default"]
        return next(each.text for each in found.values if each.name == "max_v")

    before = value()
    page.done("setting", ui.SetParameter(name, "", "max_v", "0.25"))
    page.until(lambda: value() == "0.25")
    refused = page.ask("setting", ui.SetParameter(name, "", "max_v", "fast"))
    assert refused.code == "UIS0005"
    page.done("setting", ui.SetParameter(name, "default", "max_v", before))
    page.until(lambda: value() == before)
    assert page.ask("chosen", ui.ActiveSet(name, "nothing")).code == "UIS0005"


def test_connections_are_cut_and_drawn_by_the_ports(page: Watcher, names: str) -> None:
    page.done("connection", page.wires()[SOURCE, TARGET])
    page.until(lambda: (SOURCE, TARGET) not in page.wires())
    source = ui.PortAddress(f"{names}/PathFollower0", "velocity")
    target = ui.PortAddress(f"{names}/RefHardRh30", "InTargetVelocity")
    fits = {ending(f.port): f.refused for f in page.done("ends", source).fits}
    assert fits[TARGET] == ""
    assert "different types" in fits["OmniTo2WD0.goal"]
    page.done("wire", ui.Connect(source, target))
    page.until(lambda: (SOURCE, TARGET) in page.wires())
    fits = {ending(f.port): f.refused for f in page.done("ends", source).fits}
    assert "connected already" in fits[TARGET]
    wrong = ui.PortAddress(f"{names}/Odometry0", "OdometryPosition")
    assert page.ask("wire", ui.Connect(wrong, target)).code == "UIS0004"
    assert page.ask("connection", "nothing").code == "UIS0003"


def test_boxes_are_moved_for_all_pages(page: Watcher, names: str) -> None:
    name = f"{names}/Odometry0"
    page.done("place", ui.Moved(name, ui.Location(3.0, 4.0)))
    whole = page.session.whole()
    [found] = [each for each in whole.components if each.instance == name]
    assert (found.placed, found.where) == (True, ui.Location(3.0, 4.0))
    page.done("undone", True)
    assert name not in page.session.places


def test_what_is_not_possible_is_said(page: Watcher, names: str) -> None:
    name = f"{names}/Odometry0"
    assert page.ask("removed", name).code == "UIS0009"
    for port, code in (
        ("CurrentWheelAngle", "UIS0005"),
        ("OdometryPosition", "UIS0009"),
        ("nothing", "UIS0003"),
    ):
        injected = ui.Inject(ui.PortAddress(name, port), b"")
        assert page.ask("injected", injected).code == code
    service = ui.PortAddress(f"{names}/RefHardRh30", "InventGUIRefHard")
    for interface, operation in (("nothing", "Stop"), (INTERFACE, "nothing")):
        result = page.ask("called", ui.Call(service, interface, operation, b""))
        assert result.code == "UIS0003", result.message


def samples(page: Watcher, port: str) -> list[ui.Sample]:
    """Subscribe the page to a channel; return the samples that arrived."""
    [channel] = [c for c in page.channels if ending(c.port) == port]
    page.done("channels", [channel.id])
    page.until(lambda: len(page.samples.get(channel.id, ())) > 20)
    return page.samples[channel.id]


def connectors(page: Watcher, name: str, port: str) -> int:
    """Return the number of connections that a port reports, including those of pages."""
    watcher = page.session.others.watcher
    assert watcher is not None
    return len(watcher._components[name].ports[port].connector_profiles)


def test_samples_of_their_ports_come(page: Watcher, names: str) -> None:
    name = f"{names}/PathFollower0"
    before = connectors(page, name, "velocity")
    found = samples(page, SOURCE)
    [channel] = [c for c in page.channels if ending(c.port) == SOURCE]
    node = page.session.types.nodes[channel.type_number]
    assert node.name == "IIS::TimedVelocity2D"
    sample = xcdr.deserialize(TimedVelocity2D, found[-1].data)
    assert sample.tm.sec > 0
    times = [each.time for each in found]
    assert times == sorted(times)
    page.until(lambda: connectors(page, name, "velocity") == before + 1)
    # The page hides its own connection.
    assert [*page.wires()].count((SOURCE, TARGET)) == 1
    page.done("channels", [])
    page.until(lambda: connectors(page, name, "velocity") == before)


def test_an_in_port_takes_samples(page: Watcher, names: str) -> None:
    page.done("connection", page.wires()[SOURCE, TARGET])
    sample = TimedVelocity2D()
    sample.data.vx = 0.125
    payload = xcdr.serialize(sample, xcdr.representation_of(TimedVelocity2D, 1))
    target = ui.PortAddress(f"{names}/RefHardRh30", "InTargetVelocity")
    wheels = samples(page, "RefHardRh30.OutWheelAngle")

    def turned() -> float:
        page.done("injected", ui.Inject(target, payload))
        first, last = (
            xcdr.deserialize(TimedDoubleSeq, each.data).data
            for each in (wheels[0], wheels[-1])
        )
        return float(last[0] - first[0])

    wheels.clear()
    page.until(lambda: wheels and turned() > 0.2)
    page.done("undone", True)
    page.until(lambda: (SOURCE, TARGET) in page.wires())


def test_services_are_called(page: Watcher, names: str) -> None:
    hard = page.components[f"{names}/RefHardRh30"]
    [port] = [p for p in hard.ports if p.name == "InventGUIRefHard"]
    [interface] = port.interfaces
    operations = {each.name: each for each in interface.operations}
    assert not operations["Stop"].refused
    address = ui.PortAddress(hard.instance, port.name)
    for _ in range(2):
        page.done("called", ui.Call(address, interface.name, "Stop", b""))
    page.done("called", ui.Call(address, interface.name, "Go", b""))


def test_changes_are_undone_and_made_again(page: Watcher, names: str) -> None:
    name = f"{names}/PathFollower0"

    def value(set_id: str = "default") -> str:
        sets = page.components[name].configuration_sets
        found = [s.values for s in sets if s.name == set_id]
        return next((v.text for each in found for v in each if v.name == "max_v"), "")

    before = value()
    page.done("setting", ui.SetParameter(name, "", "max_v", "0.25"))
    page.done("setting", ui.SetParameter(name, "fast", "max_v", "0.5"))
    page.done("chosen", ui.ActiveSet(name, "fast"))
    page.done("connection", page.wires()[SOURCE, TARGET])
    page.until(lambda: (SOURCE, TARGET) not in page.wires())
    page.until(lambda: page.components[name].active_set == "fast")
    page.until(lambda: page.edits.undo.startswith("cut velocity"))
    page.done("undone", True)
    page.until(lambda: (SOURCE, TARGET) in page.wires())
    page.done("undone", True)
    page.until(lambda: page.components[name].active_set == "default")
    page.done("undone", True)
    page.until(lambda: not value("fast"))
    page.done("undone", True)
    page.until(lambda: value() == before)
    page.done("redone", True)
    page.until(lambda: value() == "0.25")
    page.done("undone", True)
    page.until(lambda: value() == before)


def test_a_page_to_look_only_cannot_steer(page: Watcher, names: str) -> None:
    page.outbox.full = False
    assert page.ask("deactivated", [f"{names}/Odometry0"]).code == "UIS0002"
    assert page.ask("connection", page.wires()[SOURCE, TARGET]).code == "UIS0002"
    assert page.done("ends", ui.PortAddress(f"{names}/Odometry0", "OdometryPosition"))
    page.outbox.full = True


def test_components_of_the_page_are_wired_with_others(
    process: subprocess.Popen[bytes], page: Watcher, names: str
) -> None:
    target = ui.PortAddress(f"{names}/RefHardRh30", "InTargetVelocity")
    source = ui.PortAddress("Own0", "velocity")
    assert page.state(target.instance) is ui.State.STATE_ACTIVE
    with NamedCorba(name_server=names) as transport:
        page = Watcher(names, transport=transport)
        try:
            page.until(lambda: len(page.components) == 6)
            page.done("added", ui.AddComponent("PathFollower", "Own0"))
            kind = ui.BindingKind.BINDING_COMPONENT
            own = ui.Binding("Own0.rtc", kind, "Own0")
            page.until(lambda: own in page.services[0].bindings)
            assert [*page.components].count("Own0") == 1
            fits = {ending(f.port): f.refused for f in page.done("ends", source).fits}
            assert fits[TARGET] == ""
            assert "different types" in fits["Odometry0.LocalizedPosition"]
            fits = {ending(f.port): f.refused for f in page.done("ends", target).fits}
            assert fits["Own0.velocity"] == ""
            assert fits["Own0.position"] != ""
            page.done("wire", ui.Connect(source, target))
            wire = ("Own0.velocity", TARGET)
            page.until(lambda: wire in page.wires())
            assert len(page.session.whole().connections) == 11
            refused = page.ask("wire", ui.Connect(ui.PortAddress("Own0", "x"), target))
            assert refused.code == "UIS0003"
            page.done("connection", page.wires()[wire])
            page.until(lambda: wire not in page.wires())
            page.done("wire", ui.Connect(source, target))
            page.until(lambda: wire in page.wires())
            page.done("removed", "Own0")
            page.until(lambda: wire not in page.wires())
            page.until(lambda: own not in page.services[0].bindings)
        finally:
            page.session.close()


@pytest.mark.nightly
def test_they_are_saved_with_the_system_and_restored(
    page: Watcher, names: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    follower = f"{names}/PathFollower0"
    page.until(lambda: not any(each.silent for each in page.components.values()))
    page.done("place", ui.Moved(follower, ui.Location(30.0, 40.0)))

    # A component of another test would stay in the file once it is saved.
    page.until(lambda: len(page.components) == 6)
    page.done("file", "others.xml")
    page.until(lambda: page.edits.saved)
    saved, findings, _ = read_file(tmp_path / "others.xml")
    assert saved is not None
    assert not findings
    assert len(saved.components) == 6
    assert len(saved.connections) == 10
    components = {each.instance: each for each in saved.components}
    assert [*foreign_instances(saved.properties)] == [*components]
    assert components["PathFollower0"].path_uri == f"{follower}.rtc"
    assert components["PathFollower0"].location == (30, 40, -1, -1)
    assert dict(components["PathFollower0"].configuration)["default"]
    # Another page shows them at the same places, and restores them.
    before = {
        v.name: v.text for v in page.components[follower].configuration_sets[0].values
    }
    page.done("setting", ui.SetParameter(follower, "", "max_v", "0.25"))
    page.done("connection", page.wires()[SOURCE, TARGET])
    other = Watcher(names, file="others.xml")
    try:
        other.until(
            lambda: (
                len(other.components) == 6
                and other.session.foreign.keys()
                == {f"{n}.rtc" for n in other.components}
            )
        )
        assert other.components[follower].where == ui.Location(30.0, 40.0)
        other.done("reset", True)
        other.until(lambda: (SOURCE, TARGET) in other.wires())
        sets = other.components[follower].configuration_sets
        assert {v.name: v.text for v in sets[0].values} == before
        other.done("undone", True)
        other.until(lambda: (SOURCE, TARGET) not in other.wires())
        other.done("redone", True)
        other.until(lambda: (SOURCE, TARGET) in other.wires())
    finally:
        other.session.close()


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.waits
def test_a_peer_that_is_frozen_or_dead_says_so_and_blocks_nothing(
    page: Watcher, names: str, process: subprocess.Popen[bytes]
) -> None:
    def silent() -> list[str]:
        said = "does not answer"
        return [n for n, each in page.components.items() if said in each.silent]

    def dead() -> list[str]:
        kind = ui.BindingKind.BINDING_DEAD
        return [b.instance for b in page.services[0].bindings if b.kind is kind]

    os.kill(process.pid, signal.SIGSTOP)
    [name, *_] = page.until(silent)
    assert name in page.until(dead)
    # The run goes on, and a command for the frozen one is refused at once.
    before = page.session.runner.system.time
    assert page.ask("activated", [name]).code == "UIS0007"
    page.done("played", True)
    page.until(lambda: page.session.runner.system.time > before)
    os.kill(process.pid, signal.SIGCONT)
    page.until(lambda: not silent())
    page.until(lambda: {f"lost {name}", f"found {name}"} <= {*page.notices})
    process.kill()
    process.wait()
    page.until(lambda: len(silent()) == len(dead()) == 6)
    again = started_over_corba(names)
    page.until(lambda: not silent())
    again.terminate()
    again.wait(PATIENCE)
    page.until(lambda: not page.components)


@pytest.mark.sampled(0)
def test_a_naming_service_that_comes_late_is_found() -> None:
    with NameServer() as server:
        address = server.address
    page = Watcher(address)
    try:
        page.until(lambda: page.services and page.services[0].silent)
        assert "naming service" in page.services[0].silent
    finally:
        page.session.close()
