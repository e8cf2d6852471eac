"""Components of processes that run a system over DDS or Zenoh, on the page that watches them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from attached_page import Watching
from in_process import Network
from mcap.reader import make_reader
from ui_bench import QUIET

from refrobots.rtc import Time, TimedDouble, TimedLong
from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.runtime import xcdr
from rtgen.runtime.distribution.transport import DistributedTransport
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.ui.attaching import EngineLink
from rtgen.ui.bus_description import BusDescriber
from rtgen.ui.peers_recorder import PeersRecorder
from rtgen.ui.peers_watcher import PeersWatcher
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.recorded import Recorded
from rtgen.ui.session import Session

WIRE = ui.Connection(
    "wire",
    ui.PortAddress("Source0", "out"),
    ui.PortAddress("Sink0", "in"),
    [ui.Value("dataport.data_type", "TimedDouble")],
)


class Gain:
    gain = 1.0


class Source(runtime.Component):
    """Writes its gain in each tick."""

    profile = runtime.ComponentProfile(
        "Source",
        rate=100.0,
        configuration=(runtime.ParameterProfile("gain", "gain", "double", "1.0"),),
    )

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.config = self.add_configuration(Gain())
        self.out = self.add_out_port("out", TimedDouble)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.out.write(TimedDouble(Time(1, 2), self.config.gain))
        return RTC_OK


class Sink(runtime.Component):
    """Takes samples."""

    profile = runtime.ComponentProfile("Sink", rate=100.0)

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.inward = self.add_in_port("in", TimedDouble)


class Other(runtime.Component):
    """Has a port whose type the project does not define."""

    profile = runtime.ComponentProfile("Other", rate=100.0)

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.out = self.add_out_port("out", TimedLong)


class Project(CommandProject):
    """A project that defines the type of the ports."""

    def data_type(self, name: str) -> type[Any] | None:
        return TimedDouble if name == TimedDouble._descriptor_.name else None


class Run:
    """A system over a network, whose time the test lets pass."""

    def __init__(self, network: Network) -> None:
        self.transport = DistributedTransport(network.medium())
        self.system = runtime.System(runtime.SimulatedClock(), self.transport)
        self.transport.allow_control(self.system)
        for component in (Source("Source0"), Sink("Sink0")):
            self.system.add(component)

    def close(self) -> None:
        self.system.close()
        self.transport.close()


@pytest.fixture
def network() -> Network:
    return Network()


@pytest.fixture
def run(network: Network) -> Iterator[Run]:
    found = Run(network)
    yield found
    found.close()


@contextmanager
def watching(
    network: Network,
    file: Path | None = None,
    recorders: list[PeersRecorder] | None = None,
) -> Iterator[Watching]:
    """Yield a page that knows the components, of a session that records to a file."""
    project = Project(QUIET, [])
    transport = DistributedTransport(network.medium())
    link = EngineLink(transport, {WIRE.name: WIRE})

    def attach(publish: Any, report: Any) -> PeersWatcher:
        recorder = None
        if file is not None:
            files = ExitStack()
            writer = files.enter_context(McapWriter(file))
            recorder = PeersRecorder(writer, files, partial(report, ""))
            if recorders is not None:
                recorders.append(recorder)
        data_type = project.data_type
        return PeersWatcher(link, "here", data_type, publish, report, 0.005, recorder)

    session = Session(project, "", runtime.RealClock, attach=attach)
    found = Watching(session)
    found.until(lambda: found.components.keys() >= {"Source0", "Sink0"})
    yield found
    session.close()


@pytest.fixture
def page(network: Network, run: Run) -> Iterator[Watching]:
    with watching(network) as page:
        yield page


def passed(page: Watching, run: Run, condition: Any) -> None:
    """Let time pass until a condition holds."""

    def holds() -> Any:
        run.system.run(run.system.time + 20_000_000)
        return condition()

    page.until(holds)


def test_components_and_wires_are_shown(page: Watching) -> None:
    source = page.components["Source0"]
    assert (source.type, source.place, source.silent) == ("Source", "here", "")
    [port] = source.ports
    assert (port.name, port.kind) == ("out", ui.PortKind.PORT_OUT)
    assert source.current is ui.State.STATE_INACTIVE
    page.until(lambda: "wire" in page.connections)


def test_states_are_asked_for(page: Watching, run: Run) -> None:
    page.done("activated", ["Source0"])
    active = ui.State.STATE_ACTIVE
    passed(page, run, lambda: page.state("Source0") is active)
    page.done("deactivated", ["Source0"])
    inactive = ui.State.STATE_INACTIVE
    passed(page, run, lambda: page.state("Source0") is inactive)


def test_samples_of_watched_ports_arrive(page: Watching, run: Run) -> None:
    page.done("activated", ["Source0"])
    page.done("setting", ui.SetParameter("Source0", "", "gain", "2.5"))
    [channel] = page.channels
    page.done("channels", [channel.id])

    def numbers() -> list[float]:
        found = page.samples.get(channel.id, [])
        return [xcdr.deserialize(TimedDouble, each.data).data for each in found]

    passed(page, run, lambda: 2.5 in numbers())


def test_parameters_are_set_and_edits_undone(page: Watching, run: Run) -> None:
    def gain() -> str:
        [active] = page.components["Source0"].configuration_sets
        [value] = active.values
        return value.text

    page.done("setting", ui.SetParameter("Source0", "", "gain", "3.0"))
    page.until(lambda: gain() == "3.0")
    page.until(lambda: page.edits.undo != "")
    page.done("undone", True)
    page.until(lambda: gain() == "1.0")
    refused = page.ask("setting", ui.SetParameter("Source0", "", "none", "1"))
    assert not refused.done


def test_what_is_not_possible_says_so(page: Watching) -> None:
    cut = page.ask("connection", "wire")
    assert not cut.done
    assert "only watched" in cut.message
    for request in ("activated", "deactivated", "restored"):
        result = page.ask(request, [])
        assert (result.done, result.code) == (False, "UIS0009")
        assert "one by one" in result.hint


def test_a_process_that_ends_is_told_and_comes_back(
    page: Watching, run: Run, network: Network
) -> None:
    run.close()
    page.until(lambda: page.components["Source0"].silent != "")
    again = Run(network)
    page.until(lambda: page.components["Source0"].silent == "")
    again.close()


def lines(file: Path, capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    """Return what `rtgen log cat` prints."""
    capsys.readouterr()
    assert rtgen(["log", "cat", str(file)]) == 0
    return [json.loads(each) for each in capsys.readouterr().out.splitlines()]


def test_all_that_arrives_is_recorded(
    network: Network, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also samples that no page watches, until the session ends."""
    other = Other("Other0")
    run.system.add(other)
    file = tmp_path / "peers.mcap"
    recorders: list[PeersRecorder] = []
    with watching(network, file, recorders) as page:
        page.until(lambda: len(page.components) == 3)
        page.done("activated", ["Source0"])
        page.done("setting", ui.SetParameter("Source0", "", "gain", "2.5"))
        active = ui.State.STATE_ACTIVE
        passed(page, run, lambda: page.state("Source0") is active)
        page.until(lambda: any("Other0" in each for each in page.notices))
        page.done("deactivated", ["Source0"])
        inactive = ui.State.STATE_INACTIVE
        passed(page, run, lambda: page.state("Source0") is inactive)
    assert recorders[0].missing.messages() == [
        "all samples of Other0.out are missing: the project does not define "
        + TimedLong._descriptor_.name
    ]
    found = lines(file, capsys)
    samples = [each for each in found if each["event"] == "sample"]
    assert {(each["instance"], each["port"]) for each in samples} == {
        ("Source0", "out")
    }
    assert samples[-1]["value"]["data"] == 2.5
    states = [
        (each["from"], each["to"])
        for each in found
        if each["event"] == "state" and each["instance"] == "Source0"
    ]
    assert states == [
        ("INACTIVE_STATE", "ACTIVE_STATE"),
        ("ACTIVE_STATE", "INACTIVE_STATE"),
    ]
    [wire] = [each for each in found if each["event"] == "connection"]
    assert (wire["source"], wire["target"]) == ("Source0.out", "Sink0.in")
    assert wire["properties"]
    times = [each["t"] for each in found]
    assert times == sorted(times)
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        topics = [channel.topic for _, channel, _ in reader.iter_messages()]
    assert topics.count("/Source0/out") == len(samples)
    shown = Recorded([str(file)], lambda bus, network: BusDescriber(None)).history
    components = shown.at(shown.last, [], ())[0].whole.components
    assert {"Source0", "Sink0", "Other0"} == {each.instance for each in components}
