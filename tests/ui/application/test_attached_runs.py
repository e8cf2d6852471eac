"""`rtgen ui --attach`: runs of this machine on a page, to their end and beyond."""

from __future__ import annotations

import errno
import os
import re
import resource
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from attached_page import Watching
from patience import PATIENCE, until
from test_attached import Project, Sink, Source
from ui_bench import QUIET

from refrobots.rtc import Time, TimedDouble, TimedOctetSeq
from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.facts.version import __version__
from rtgen.runtime import xcdr
from rtgen.runtime.distribution import local_listener, local_runs, local_server
from rtgen.runtime.distribution.local_link import LocalLink
from rtgen.runtime.distribution.local_listener import ServedRun
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.return_codes import ReturnCode_t
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.timing.traffic import BoardCall, BusFrame
from rtgen.ui.attaching import RunLink, chosen
from rtgen.ui.peers_watcher import PeersWatcher
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session

pytestmark = pytest.mark.usefixtures("sockets")
CLOCKS = {"real": runtime.RealClock, "simulated": runtime.SimulatedClock}


class Counting(runtime.Component):
    """Remembers the sum of what it receives."""

    profile = runtime.ComponentProfile("Counting", rate=100.0)

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.inward = self.add_in_port("in", TimedDouble)
        self.sum = 0.0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        while self.inward.is_new():
            sample = self.inward.read()
            assert sample is not None
            self.sum += sample.data
            if sample.data < 0:
                raise ValueError(f"below zero: {sample.data}")
        return runtime.RTC_OK


class Unnamed(Source):
    """Fails for the sake of a file whose name is not UTF-8."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        raise OSError("no file " + os.fsdecode(b"a\xff"))


class Running:
    """A system that runs in a thread of its own until `end`."""

    def __init__(
        self, name: str = "demo", clock: str = "real", *further: runtime.Component
    ) -> None:
        self.system = runtime.System(CLOCKS[clock]())
        self.system.on_failure = lambda failure: None
        self.counting = Counting("Counting0")
        for each in (Source("Source0"), Sink("Sink0"), self.counting, *further):
            self.system.add(each)
        self.system.connect(("Source0", "out"), ("Sink0", "in"), name="wire")
        self.served = ServedRun(self.system, name, "demo.xml", "rtgen run demo.xml")
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self.system.run(until=lambda _: self._over.is_set())

    def end(self, reason: str = "it is complete") -> None:
        if self._over.is_set():
            return
        self._over.set()
        self._thread.join()
        if reason:
            self.served.end(reason)
        self.served.close()
        self.system.close()

    @property
    def path(self) -> Path:
        assert self.served.path is not None
        return self.served.path


Begin = Callable[..., Running]


@pytest.fixture
def begin() -> Iterator[Begin]:
    """Yield a function that begins a run, which is ended at the end."""
    begun: list[Running] = []

    def run(*arguments: Any) -> Running:
        begun.append(Running(*arguments))
        return begun[-1]

    yield run
    for each in begun:
        each.end()


@pytest.fixture(params=[*CLOCKS])
def run(request: pytest.FixtureRequest, begin: Begin) -> Running:
    return begin("demo", request.param)


@pytest.fixture
def page(run: Running) -> Iterator[Watching]:
    """Yield a page that knows the run."""
    project = Project(QUIET, [])
    link = RunLink(run.path)

    def attach(publish: Any, report: Any) -> PeersWatcher:
        return PeersWatcher(link, "here", project.data_type, publish, report, 0.005)

    session = Session(project, "", runtime.RealClock, attach=attach)
    found = Watching(session)
    found.until(lambda: len(found.components) == 3)
    yield found
    session.close()


def test_a_run_is_shown(page: Watching) -> None:
    source = page.components["Source0"]
    assert (source.type, source.place, source.silent) == ("Source", "here", "")
    assert [each.rate for each in source.contexts] == [100.0]
    [gain] = source.parameters
    assert (gain.name, gain.type, gain.default_value) == ("gain", "double", "1.0")
    page.until(lambda: page.connections.keys() == {"wire"})
    assert page.session.whole().name == "demo"


def test_states_are_asked_for(page: Watching, run: Running) -> None:
    for request, state in (
        ("activated", ui.State.STATE_ACTIVE),
        ("deactivated", ui.State.STATE_INACTIVE),
    ):
        page.done(request, ["Counting0"])
        page.until(lambda state=state: page.state("Counting0") is state)
    page.done("activated", ["Counting0"])
    page.until(lambda: page.state("Counting0") is ui.State.STATE_ACTIVE)
    give(page, -1.0)
    page.until(lambda: page.state("Counting0") is ui.State.STATE_ERROR)
    reason = page.components["Counting0"].reason
    assert re.match(r"on_execute \(\S+\.py:\d+\): ValueError: below zero", reason)
    page.done("restored", ["Counting0"])
    page.until(lambda: page.state("Counting0") is ui.State.STATE_INACTIVE)


def give(page: Watching, number: float) -> None:
    data = xcdr.serialize(
        TimedDouble(Time(1, 2), number), xcdr.representation_of(TimedDouble, 1)
    )
    page.done("injected", ui.Inject(ui.PortAddress("Counting0", "in"), data))


def test_samples_are_given(page: Watching, run: Running) -> None:
    page.done("activated", ["Counting0"])
    for number in (1.0, 2.0, 4.0):
        give(page, number)
    page.until(lambda: run.counting.sum == 7.0)


@pytest.mark.sampled(1)
def test_parameters_and_samples_have_the_time_of_the_run(page: Watching) -> None:
    page.done("activated", ["Source0"])
    page.done("setting", ui.SetParameter("Source0", "", "gain", "2.5"))
    [channel] = page.channels
    page.done("channels", [channel.id])

    def arrived() -> list[ui.Sample]:
        return page.samples.get(channel.id, [])

    def numbers() -> list[float]:
        return [xcdr.deserialize(TimedDouble, e.data).data for e in arrived()]

    page.until(lambda: 2.5 in numbers())
    times = [each.time for each in arrived()]
    assert times == sorted(times)
    page.until(lambda: page.edits.undo != "")
    page.done("undone", True)
    page.until(lambda: numbers()[-1] == 1.0)


@pytest.mark.sampled(1)
def test_wires_have_rates_and_losses(page: Watching) -> None:
    page.done("activated", ["Source0"])

    def flow() -> Any:
        flows = {each.name: each for each in page.session.remote.flows}
        return flows["wire"].rate > 50.0 and flows["wire"].lost > 0 and flows["wire"]

    assert "overwritten in a full buffer" in page.until(flow).details


def test_what_belongs_to_the_file_is_refused(page: Watching) -> None:
    for branch, value in (
        ("connection", "wire"),
        ("file", "other.xml"),
        ("added", ui.AddComponent("Source")),
    ):
        refused = page.ask(branch, value)
        assert not refused.done
        assert "watched" in refused.message


def test_the_end_is_told_and_the_next_run_is_shown(
    page: Watching, run: Running, begin: Begin
) -> None:
    session = page.session
    run.end("it was interrupted")
    page.until(lambda: session.time().ended)
    assert session.time().reason.startswith("it was interrupted. This page goes on")
    assert "rtgen run demo.xml" in session.time().reason
    page.until(lambda: silent(page) == "the run has ended")
    assert not page.ask("activated", ["Source0"]).done
    begin("other")
    begin("demo")
    page.until(lambda: silent(page) == "")
    assert not session.time().ended
    assert session.remote.run.number == 2
    page.done("activated", ["Source0"])
    page.until(lambda: page.state("Source0") is ui.State.STATE_ACTIVE)


def silent(page: Watching) -> str | None:
    source = page.components.get("Source0")
    return None if source is None else source.silent


def test_a_run_that_is_killed_is_told(page: Watching, run: Running) -> None:
    run.end("")
    page.until(lambda: page.session.time().ended)
    assert "without a farewell" in page.session.time().reason


@pytest.mark.sampled(1)
def test_the_run_before_is_compared_with_the_next(
    page: Watching, run: Running, begin: Begin
) -> None:
    page.done("activated", ["Source0"])
    [channel] = page.channels
    page.done("channels", [channel.id])
    page.until(lambda: len(page.samples.get(channel.id, ())) > 3)
    page.done("kept", True)
    run.end()
    begin("demo")
    page.until(lambda: page.session.remote.run.number == 2)
    page.until(lambda: any(each.beside for each in page.channels))


def test_runs_are_chosen_by_name_or_process(begin: Begin) -> None:
    first, second = begin("one"), begin("two")
    runs = local_runs.runs()
    assert {path for path, _ in runs} == {first.path, second.path}
    assert [path for path, _ in chosen(runs, "two")] == [second.path]
    assert len(chosen(runs, "")) == len(chosen(runs, str(runs[0][1].pid))) == 2
    assert chosen(runs, "three") == []


def test_the_command_lists_the_runs_that_it_cannot_choose_from(
    begin: Begin, capsys: pytest.CaptureFixture[str]
) -> None:
    assert rtgen(["ui", "--attach", "--no-open"]) != 0
    assert "nothing runs" in capsys.readouterr().err
    begin("one")
    begin("two")
    for arguments in (["--attach"], ["--attach", "three"]):
        assert rtgen(["ui", *arguments, "--no-open"]) != 0
        message = capsys.readouterr().err
        assert "one, rtgen run demo.xml" in message
        assert "two, rtgen run demo.xml" in message
    assert rtgen(["ui", "--attach", "one", "--transport", "zenoh"]) != 0
    assert "without SYSTEM" in capsys.readouterr().err


def test_a_run_ends_while_a_program_attaches(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = begin()
    waits = threading.Event()

    class Lock:
        """A lock that tells when somebody has to wait for it."""

        def __init__(self) -> None:
            self._lock = threading.Lock()

        def __enter__(self) -> None:
            if not self._lock.acquire(blocking=False):
                waits.set()
                self._lock.acquire()

        def __exit__(self, *_: object) -> None:
            self._lock.release()

    endings: list[threading.Thread] = []
    start = local_server._Client.start

    def start_at_the_end(client: Any) -> None:
        if not endings:
            endings.append(threading.Thread(target=run.end))
            endings[0].start()
            until(lambda: waits.is_set() or not endings[0].is_alive())
        start(client)

    create = local_server.RunServer.__init__

    def create_with_lock(server: Any, *arguments: Any) -> None:
        create(server, *arguments)
        server._lock = Lock()

    monkeypatch.setattr(local_server.RunServer, "__init__", create_with_lock)
    monkeypatch.setattr(local_server._Client, "start", start_at_the_end)
    link = LocalLink(run.path, lambda: None)
    until(lambda: link.end)
    endings[0].join()
    link.close()
    assert waits.is_set()


def test_others_cannot_enter_the_folder(sockets: Path) -> None:
    assert local_runs.folder().stat().st_mode & 0o777 == 0o700
    sockets.chmod(0o755)
    with pytest.raises(OSError, match="other users"):
        local_runs.runs()
    sockets.chmod(0o700)


def test_a_socket_without_a_process_is_removed(sockets: Path) -> None:
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(sockets / f"1{local_runs.SUFFIX}"))
    dead.close()
    assert local_runs.runs() == []
    assert [*sockets.iterdir()] == []


_DEEP = 100_000
"""Depth of values beyond the limit of recursion."""


@pytest.mark.parametrize(
    "octets",
    [
        b"\xff" * 64,
        b"\0\0\0\2{}",
        b"\0\0\0\1",
        (_DEEP + 12).to_bytes(4, "big")
        + b"\x82\xa4type\xa3ask\xa1x"
        + b"\x91" * (_DEEP - 1)
        + b"\x90",
    ],
)
def test_a_run_survives_what_is_no_message(begin: Begin, octets: bytes) -> None:
    run = begin()
    stream, _ = local_runs.connect(run.path)
    stream.sendall(octets)
    stream.shutdown(socket.SHUT_WR)
    with suppress(ConnectionResetError):
        while stream.recv(1 << 16):
            pass
    stream.close()
    with LocalLink(run.path) as link:
        assert link.asker("Source0").state().state == "INACTIVE_STATE"


@pytest.mark.parametrize("clock", [*CLOCKS])
def test_a_request_that_is_nested_too_deep_is_refused(begin: Begin, clock: str) -> None:
    run = begin("demo", clock)
    deep = b'{"do":"state","more":' + b"[" * _DEEP + b"]" * _DEEP + b"}"
    with LocalLink(run.path) as link:
        for instance in ("Source0", "Sink0"):
            answer = link.ask(
                partial(local_runs.Ask, instance=instance, octets=deep), PATIENCE
            )
            assert b"nested too deep" in answer
            assert link.asker(instance).state().state == "INACTIVE_STATE"


@pytest.mark.parametrize("clock", [*CLOCKS])
def test_a_reason_that_no_message_can_have_is_told(begin: Begin, clock: str) -> None:
    """Such as the name of a file that is not UTF-8."""
    run = begin("demo", clock, Unnamed("Unnamed0"))
    with LocalLink(run.path) as link:
        link.asker("Unnamed0").activate()
        until(lambda: "Unnamed0" in link.states)
        until(lambda: link.asker("Unnamed0").state().state == "ERROR_STATE")
        assert "no file a\\udcff" in link.states["Unnamed0"][1]
        assert link.asker("Source0").state().state == "INACTIVE_STATE"


def test_who_asks_and_does_not_read_is_left(begin: Begin) -> None:
    run = begin()
    stream, _ = local_runs.connect(run.path)
    asked = local_runs.packed(local_runs.Ask(1, "nobody" * 1000, b""))
    with stream, pytest.raises((BrokenPipeError, ConnectionResetError)):
        stream.sendall(asked * 10_000)
    with LocalLink(run.path) as link:
        assert link.asker("Source0").state().state == "INACTIVE_STATE"


def test_a_run_without_files_lets_programs_in_later(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = begin()
    refused, again = threading.Event(), threading.Event()
    reasons: list[int | None] = []

    def wait(error: OSError) -> None:
        reasons.append(error.errno)
        refused.set()
        assert again.wait(PATIENCE)

    monkeypatch.setattr(local_listener, "await_files", wait)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with socket.socket(socket.AF_UNIX) as stream:
        resource.setrlimit(resource.RLIMIT_NOFILE, (3, hard))
        try:
            stream.connect(str(run.path))
            assert refused.wait(PATIENCE)
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
            again.set()
        hello = local_runs.receive(stream, local_runs.Hello)
    assert hello is not None
    assert (hello.name, {*reasons}) == ("demo", {errno.EMFILE})


def test_a_program_that_does_not_read_does_not_stop_a_run(begin: Begin) -> None:
    run = begin("demo", "simulated")
    stream, _ = local_runs.connect(run.path)
    stream.sendall(local_runs.packed(local_runs.Listen("Source0", "out", on=True)))
    with LocalLink(run.path) as link:
        link.asker("Source0").activate()
        begun = run.system.time
        until(lambda: run.system.time > begun + 100_000_000_000)
    stream.close()


def test_samples_that_are_too_long_are_left_out(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The connection goes on, and counts them."""
    monkeypatch.setattr(local_runs, "MAX_LENGTH", 2000)
    run = begin()
    wide = Sink("Wide0")
    out = wide.add_out_port("out", TimedOctetSeq)
    run.system.add(wide)
    received: list[int] = []
    with LocalLink(run.path) as link:
        until(lambda: "Wide0" in link.instances)
        there = RemotePort("Wide0", "out")
        link.listen(
            there, TimedOctetSeq, lambda value: received.append(len(value.data))
        )

        def is_received() -> bool:
            for size in (3000, 100):
                out.write(TimedOctetSeq(Time(), bytes(size)))
            return bool(received)

        until(is_received)
        until(lambda: link.dropped > 0)
        with pytest.raises(MediumError, match="at most 2000 are sent"):
            link.give(there, TimedOctetSeq, TimedOctetSeq(Time(), bytes(3000)))
        assert link.end == ""
    assert {*received} == {100}


def test_a_socket_is_there_when_somebody_listens(
    sockets: Path, monkeypatch: pytest.MonkeyPatch, begin: Begin
) -> None:
    """Who looks for runs would remove one that refuses a connection."""
    before: list[Path] = []

    class Looking(socket.socket):
        def listen(self, *arguments: int) -> None:
            before.extend(sockets.glob(f"*{local_runs.SUFFIX}"))
            super().listen(*arguments)

    with monkeypatch.context() as patched:
        patched.setattr(socket, "socket", Looking)
        run = begin()
    assert before == []
    assert [path for path, _ in local_runs.runs()] == [run.path]
    assert [*sockets.iterdir()] == [run.path]


def test_a_run_of_another_version_is_listed_and_refused(
    begin: Begin, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(local_runs, "MESSAGES", local_runs.MESSAGES + 1)
        run = begin("later")
    assert [hello.name for _, hello in local_runs.runs()] == ["later"]
    with pytest.raises(OSError, match="start both with the same one"):
        LocalLink(run.path)
    assert rtgen(["ui", "--attach", "later", "--no-open"]) != 0
    error = capsys.readouterr().err
    assert f"process {os.getpid()} runs later by rtgen {__version__}" in error
    assert "Traceback" not in error


def test_a_page_says_that_the_next_run_is_of_another_version(
    page: Watching, run: Running, begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    run.end()
    page.until(lambda: page.session.time().ended)
    with monkeypatch.context() as patched:
        patched.setattr(local_runs, "MESSAGES", local_runs.MESSAGES + 1)
        later = begin("demo")
    page.until(lambda: "cannot attach" in page.session.time().reason)
    later.end()
    begin("demo")
    page.until(lambda: not page.session.time().ended)


def test_what_greets_in_another_way_is_no_run(sockets: Path) -> None:
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(str(sockets / f"1{local_runs.SUFFIX}"))
    listening.listen()

    def greet() -> None:
        stream, _ = listening.accept()
        stream.sendall(b"\0\0\0\3\xa2hi")
        stream.close()

    greeting = threading.Thread(target=greet)
    greeting.start()
    assert local_runs.runs() == []
    greeting.join()
    listening.close()


def test_a_process_of_another_user_is_told(
    begin: Begin, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    begin("one")

    def kill(process: int, signal: int) -> None:
        raise PermissionError if process == 17 else ProcessLookupError

    monkeypatch.setattr(os, "kill", kill)
    for process, text in (
        ("17", "process 17 belongs to another user"),
        ("18", "no run '18'"),
    ):
        assert rtgen(["ui", "--attach", process, "--no-open"]) != 0
        assert text in capsys.readouterr().err


def test_a_system_without_such_sockets_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(local_runs, "is_supported", lambda: False)
    assert rtgen(["ui", "--attach", "--no-open"]) != 0
    error = capsys.readouterr().err
    assert "--attach works on Linux and macOS" in error
    assert "--transport zenoh" in error


@pytest.mark.sampled(0)
def test_a_page_survives_a_flood_and_says_so(page: Watching, run: Running) -> None:
    """The run waits for nobody, and states and commands come through."""
    frame = BusFrame("can0", 0x181, bytes(8), remote=False, extended=False)
    flooding = threading.Event()

    def flood() -> None:
        while not flooding.wait(0.001):
            for _ in range(100):
                run.system.clock.traffic.report(frame)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        page.until(lambda: "lost " in page.notices)
        page.done("activated", ["Counting0"])
        page.until(lambda: page.state("Counting0") is ui.State.STATE_ACTIVE)
        begun = run.system.time
        page.until(lambda: run.system.time > begun)
    finally:
        flooding.set()
        thread.join()
    assert page.frames
    page.until(lambda: page.buses.keys() == {"can0"})


def test_what_happens_is_told(page: Watching, run: Running) -> None:
    run.served.tell("call", "Source0", "Source0.port.start() -> 1")
    page.until(lambda: "call Source0" in page.notices)
    run.system.clock.traffic.report(BoardCall("Board0", b"ab", b"cd", "", 1_000_000))
    call = page.until(lambda: page.calls and page.calls[0])
    assert (call.instance, call.request, call.reply) == ("Board0", b"ab", b"cd")
    assert call.round_trip == 0.001
