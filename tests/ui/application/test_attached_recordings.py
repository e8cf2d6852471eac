"""Recordings of attached runs, and recordings that are opened beside a run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from attached_page import Watching
from attached_program import running, watching
from patience import PATIENCE, until
from ui_bench import GOAL, ROOT, Bench

from rtgen.cli import run as rtgen
from rtgen.runtime.distribution.medium import MediumError
from rtgen.tools.kit.exits import INTERRUPTED
from rtgen.ui.protocol import ui

FOURX = ROOT / "specs/canopen/fourx.xml"
pytestmark = pytest.mark.usefixtures("sockets")
PACED = ("--clock", "sim", "--rate", "1", "-q")
A_CHUNK = 20_000
"""So large is a file that has a chunk of samples, at least."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of one second, in which the robot is slower than in the file."""
    file = tmp_path_factory.mktemp("recording") / "slow.mcap"
    command = ["run", str(GOAL), "--until", "1", "--record", str(file), "-q"]
    assert rtgen([*command, "--set", "PathFollower0.max_w=0.1"]) == 0
    return file


def lines(file: Path, capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    """Return what `rtgen log cat` prints."""
    capsys.readouterr()
    assert rtgen(["log", "cat", str(file)]) == 0
    return [json.loads(each) for each in capsys.readouterr().out.splitlines()]


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.parametrize(
    ("transport", "module"), [("dds", "cyclonedds"), ("zenoh", "zenoh")]
)
def test_a_server_records_other_processes_until_it_is_interrupted(
    transport: str, module: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip(module)
    file, said = tmp_path / "others.mcap", tmp_path / "said.txt"
    net = ["--transport", transport, "--partition", f"record{os.getpid()}"]
    command = [sys.executable, "-m", "rtgen", "ui", str(GOAL), *net, "--no-open"]
    with (
        running(str(GOAL), "--clock", "real", *net, "-q"),
        said.open("w", encoding="utf-8") as output,
        subprocess.Popen(
            [*command, "--port", "0", "--record", str(file)],
            stdout=output,
            stderr=subprocess.STDOUT,
        ) as server,
    ):
        try:
            until(
                lambda: (
                    (file.exists() and file.stat().st_size > A_CHUNK)
                    or server.poll() is not None
                ),
                shown=lambda: said.read_text(encoding="utf-8"),
            )
            server.send_signal(signal.SIGINT)
            assert server.wait(PATIENCE) == INTERRUPTED, said.read_text(
                encoding="utf-8"
            )
        finally:
            server.kill()
    assert f"recorded in {file}\n" in said.read_text(encoding="utf-8")
    found = lines(file, capsys)
    assert len([each for each in found if each["event"] == "component"]) == 6
    samples = {each["port"] for each in found if each["event"] == "sample"}
    assert "OutWheelAngle" in samples
    times = [each["t"] for each in found]
    assert times == sorted(times)


@pytest.mark.sampled(0)
def test_a_run_is_recorded_from_the_time_of_attaching(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "attached.mcap"
    with (
        running(str(GOAL), *PACED) as program,
        watching(program.path, record=file) as page,
    ):
        begun = page.session.now
        page.until(lambda: page.session.now > begun + 1.0)
        page.done("deactivated", ["Odometry0"])
        page.until(lambda: page.state("Odometry0") is ui.State.STATE_INACTIVE)
    assert rtgen(["log", "info", str(file)]) == 0
    assert "cut off" not in capsys.readouterr().out
    found = lines(file, capsys)
    assert {"Odometry0", "PathFollower0"} <= {each.get("instance") for each in found}
    times = [each["t"] for each in found]
    assert times == sorted(times)
    assert times[0] == 0
    command = ["replay", str(file), "--into", str(GOAL), "--only", "PathFollower0"]
    assert rtgen([*command, "-q"]) == 0, capsys.readouterr().err
    with Shown(file) as shown:
        states = {each.instance: each.current for each in shown.components}
        assert {"PathFollower0", "Odometry0"} <= states.keys()
        assert shown.channels


class Shown:
    """The whole state of a recording, as `rtgen ui FILE` shows it."""

    def __init__(self, file: Path) -> None:
        from rtgen.ui.bus_description import BusDescriber
        from rtgen.ui.recorded import Recorded

        self._recorded = Recorded([str(file)], lambda bus, network: BusDescriber(None))

    def __enter__(self) -> ui.SystemState:
        from rtgen.ui.outbox import Outbox

        page = Outbox(lambda: None)
        self._recorded.join(page)
        data = page.take()
        assert data is not None
        return next(
            e.whole
            for e in ui.ServerMessage.from_cdr(data).events
            if e.discriminator is ui.EventKind.EVENT_SYSTEM
        )

    def __exit__(self, *error: object) -> None:
        self._recorded.close()


@pytest.mark.nightly
def test_frames_are_recorded_and_each_run_has_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bus.mcap"
    with (
        running(str(FOURX), *PACED) as program,
        watching(program.path, record=file) as page,
    ):
        page.until(lambda: len(page.frames) > 500)
        program.interrupt()
        page.until(lambda: page.session.time().ended)
        with running(str(FOURX), *PACED) as second:
            page.until(lambda: page.session.remote.run.number == 2)
            seen = len(page.frames)
            page.until(lambda: len(page.frames) > seen + 100)
            second.interrupt()
    for each in (file, tmp_path / "bus-2.mcap"):
        until(lambda each=each: rtgen(["log", "info", str(each)]) == 0)
        assert "can0" in capsys.readouterr().out


def test_a_file_that_cannot_be_written_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with running(str(GOAL), *PACED) as program:
        with (
            pytest.raises(MediumError, match="cannot write"),
            watching(program.path, tmp_path),
        ):
            pass
        command = ["ui", "--attach", "--no-open", "--record"]
        assert rtgen([*command, str(tmp_path)]) != 0
        error = capsys.readouterr().err
        assert "cannot write" in error
        assert "Traceback" not in error
        assert program.process.poll() is None


@pytest.fixture
def page() -> Iterator[Watching]:
    """Yield a page of a run in real time."""
    from rtgen import runtime

    bench = Bench(GOAL, clock=runtime.RealClock)
    found = Watching(bench.session)
    found.until(lambda: found.components)
    yield found
    bench.close()


@pytest.mark.sampled(0)
def test_a_recording_is_opened_beside_a_run(
    page: Watching, recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(recording.parent)
    assert page.done("listed", True).files == [recording.name]
    page.done("compared", recording.name)
    page.until(lambda: any(each.beside for each in page.channels))
    beside = {each.port.port: each for each in page.channels if each.beside}
    own = {each.port.port: each for each in page.channels if not each.beside}
    for port, channel in beside.items():
        kinds = [
            page.session.types.nodes[each.type_number].kind
            for each in (channel, own[port])
        ]
        assert kinds[0] is kinds[1], port
    page.done("channels", [beside["velocity"].id, own["velocity"].id])
    page.session.runner.submit(page.session.runner.play)
    page.until(lambda: page.samples.get(beside["velocity"].id))
    page.until(lambda: page.samples.get(own["velocity"].id))
    page.done("compared", "")
    page.until(lambda: not any(each.beside for each in page.channels))


@pytest.mark.nightly
def test_a_recording_is_opened_beside_an_attached_run(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(recording.parent)
    with running(str(GOAL), *PACED) as program, watching(program.path) as page:
        page.done("compared", recording.name)
        page.until(lambda: any(each.beside for each in page.channels))
        number = next(
            e.id for e in page.channels if e.beside and e.port.port == "velocity"
        )
        page.done("channels", [number])
        page.until(lambda: page.samples.get(number))
        program.interrupt()
        page.until(lambda: page.session.time().ended)
        with running(str(GOAL), *PACED):
            page.until(lambda: page.session.remote.run.number == 2)
            page.until(lambda: any(each.beside for each in page.channels))


@pytest.mark.parametrize("name", ["/etc/passwd", "../other.mcap", "none.mcap", "x.xml"])
def test_other_files_are_not_opened(
    page: Watching, recording: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(recording.parent)
    refused = page.ask("compared", name)
    assert not refused.done
    assert refused.message
    assert page.session.beside.name == ""
