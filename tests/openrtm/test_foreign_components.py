"""Systems with a component of OpenRTM or C++ in its own process, which rtgen does not run."""

from __future__ import annotations

import os
import signal
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import cpp_build
import middleware
import pytest
from logged_process import LoggedProcess
from patience import until
from watching_page import Page

from refrobots.iis import TimedPose2D
from refrobots.rtc import TimedState
from rtgen.cli import run as rtgen
from rtgen.runtime import xcdr
from rtgen.ui.protocol import ui

pytestmark = pytest.mark.waits

ROOT = Path(__file__).resolve().parents[2]
GOAL = ROOT / "specs" / "navigation" / "rh3_goal.xml"
CALC = ROOT / "tests" / "runtime" / "corba" / "corba_system"
CPP_TYPES = {
    "operator": "IDL:IIS/TimedPose2D:1.0",
    "mistaken": "IDL:RTC/TimedLong:1.0",
}
NEAR = {'"01_x" rts:data="3.4"': '"01_x" rts:data="0.2"'}
NEAR |= {'"01_y" rts:data="7.7"': '"01_y" rts:data="0"'}
NEAR |= {'"01_th" rts:data="-1.57"': '"01_th" rts:data="0"'}


@pytest.fixture(scope="module")
def stubs(
    tmp_path_factory: pytest.TempPathFactory, rtm_folders: list[Path]
) -> dict[str, str]:
    """Return the environment of foreign processes, with the stubs of their own types."""
    folder = tmp_path_factory.mktemp("stubs")
    types = middleware.DATA_TYPES
    files = [types / "intellirobot.idl", CALC / "calc.idl"]
    middleware.compile_idl(folder, files, [types])
    return {**middleware.environment(rtm_folders), "TYPES": str(folder)}


@pytest.fixture
def author(request: pytest.FixtureRequest) -> str:
    """Return the kind of the foreign component; OpenRTM's unless a test has `by_each_author`."""
    return str(getattr(request, "param", "openrtm"))


by_each_author = pytest.mark.parametrize(
    "author",
    ["openrtm", pytest.param("c++", marks=cpp_build.needed)],
    indirect=True,
)


@pytest.fixture
def launch(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    naming_service: str,
    stubs: dict[str, str],
    author: str,
) -> Iterator[Callable[..., LoggedProcess]]:
    """Yield a function that starts processes: foreign ones by their kind, and `rtgen run`."""
    made: list[LoggedProcess] = []
    # Compiled before a run begins, which waits for the operator.
    cpp = request.getfixturevalue("cpp_programs") if author == "c++" else None

    def launched(
        *what: str, formats: str = "%n.rtc", folder: Path = ROOT, path: str = ""
    ) -> LoggedProcess:
        log = tmp_path / f"{len(made)}.txt"
        program = sys.executable
        if what[0] == "run":
            command = ["-m", "rtgen", *what, "--clock", "real", "--transport", "corba"]
            environment = {**os.environ, "PYTHONPATH": path}
        elif author == "c++":
            program = str(cpp / "position_input")
            place = formats.replace("%n", "PositionInput0")
            command = [f"corbaname::{naming_service}#{place}", CPP_TYPES[what[0]]]
            command += ["-ORBendPoint", "giop:tcp:127.0.0.1:"]
            environment = {**os.environ}
        else:
            script = str(Path(__file__).with_name("foreign_process.py"))
            command, environment = [script, what[0], naming_service, formats], stubs
        made.append(LoggedProcess(command, folder, environment, log, program))
        return made[-1]

    yield launched
    for each in made:
        if each.runs:
            each.end(signal.SIGKILL)


def near_goal(folder: Path, path: str = "", marked: bool = True) -> str:
    """Return RH3 with a near goal, whose operator is foreign and has a path."""
    text = GOAL.read_text()
    changes = dict(NEAR)
    if path:
        changes['"localhost/PositionInput0.rtc"'] = f'"{path}"'
    if marked:
        own = '<rtsExt:Properties rtsExt:name="rtgen.foreign" rtsExt:value="PositionInput0"/>'
        changes["</rts:RtsProfile>"] = f"{own}</rts:RtsProfile>"
    for old, new in changes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    system = folder / "rh3.xml"
    system.write_text(text)
    return str(system)


@pytest.mark.nightly
@by_each_author
def test_rh3_reaches_its_goal_with_a_foreign_operator_that_comes_late_and_is_killed(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
) -> None:
    # By its path, below another naming service than that of the run.
    system = near_goal(tmp_path, f"{naming_service}/lab.host_cxt/PositionInput0.rtc")
    ours = launch("run", system)
    ours.says("waiting for other processes: PositionInput0")
    formats = "lab.host_cxt/%n.rtc"
    operator = launch("operator", formats=formats)
    operator.says("going")
    operator.end(signal.SIGKILL)
    ours.says("warning[SYS0024]: PositionInput0 is lost: its process does not respond")
    again = launch("operator", formats=formats)
    ours.says("PositionInput0 is there again")
    again.says("FINISH")
    assert ours.end() == 0
    found = next(line for line in ours.text.splitlines() if "final pose" in line)
    x, y, theta = (float(text) for text in found.partition("(")[2][:-1].split(","))
    assert abs(x - 0.2) < 0.05
    assert abs(y) < 0.05
    assert abs(theta) < 0.1


@pytest.mark.nightly
@by_each_author
def test_a_foreign_component_that_is_absent(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
) -> None:
    system = near_goal(tmp_path, marked=False)
    options = ["--foreign", "PositionInput0", "--nameserver", naming_service]
    ours = launch("run", system, *options, "--wait", "0.1")
    assert ours.code() == 3
    assert (
        "no process runs PositionInput0, which rtgen does not run: the naming service "
        f"{naming_service} has no PositionInput0.rtc, nor is anything at "
        "localhost/PositionInput0.rtc, that answers" in ours.text
    )


@pytest.mark.sampled(0)
@by_each_author
def test_a_foreign_component_of_another_type(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
) -> None:
    mistaken = launch("mistaken")
    mistaken.says("ready")
    ours = launch("run", near_goal(tmp_path), "--nameserver", naming_service)
    assert ours.code() == 2
    assert (
        "error[SYS0003]: OmniTo2WD0.goal and PositionInput0..positon have different types: "
        "IDL:IIS/TimedPose2D:1.0 and IDL:RTC/TimedLong:1.0" in ours.text
    )


@pytest.mark.sampled(0)
@by_each_author
def test_a_foreign_component_without_a_parameter(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
) -> None:
    system = Path(near_goal(tmp_path))
    system.write_text(system.read_text().replace('"01_x"', '"09_x"'))
    operator = launch("operator")
    operator.says("ready")
    ours = launch("run", str(system), "--nameserver", naming_service)
    assert ours.code() == 2
    assert (
        "error[SYS0004]: PositionInput0 has no parameter 09_x; it has: 01_th, 01_x, 01_y, input"
        in ours.text
    )


@pytest.mark.sampled(1)
def test_a_foreign_component_provides_a_service(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    openrtm: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for file in CALC.iterdir():
        if file.is_file():
            (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert rtgen(["generate", "-q"]) == 0
    adder = launch("adder", formats="%h.host_cxt/%n.rtc")
    adder.says("ready")
    options = ["--foreign", "Counter0", "--nameserver", naming_service]
    path = os.pathsep.join([str(tmp_path), str(tmp_path / "generated")])
    ours = launch(
        *("run", "calc.xml", *options, "--log", "log.jsonl"), folder=tmp_path, path=path
    )
    log = tmp_path / "log.jsonl"
    until(lambda: log.exists() and '"number": 5' in log.read_text())
    adder.end(signal.SIGKILL)
    ours.says("Counter0 is lost")
    again = launch("adder", formats="%h.host_cxt/%n.rtc")
    again.says("ready")
    ours.says("Counter0 is there again")
    size = log.stat().st_size
    until(lambda: '"error": ""' in log.read_text()[size:])
    assert ours.end() == 0


@pytest.fixture
def page(naming_service: str) -> Iterator[Page]:
    page = Page(naming_service)
    yield page
    page.session.close()


def test_a_page_shows_and_steers_it(
    launch: Callable[..., LoggedProcess], naming_service: str, page: Page
) -> None:
    operator = launch("operator", formats="%h.host_cxt/%n.rtc")
    operator.says("ready")
    name = page.found("host_cxt/PositionInput0").instance

    def now() -> ui.Component:
        return page.session.remote.components[name]

    def values() -> dict[str, str]:
        [found] = [s for s in now().configuration_sets if s.name == "default"]
        return {each.name: each.text for each in found.values}

    assert (now().type, now().current) == ("PositionInput", ui.State.STATE_INACTIVE)
    page.done("setting", ui.SetParameter(name, "", "01_x", "0.5"))
    until(lambda: values()["01_x"] == "0.5")
    page.done("undone", True)
    until(lambda: values()["01_x"] == "0")
    page.done("redone", True)
    until(lambda: values()["01_x"] == "0.5")
    [channel] = [
        each
        for each in page.session.whole().channels
        if (each.port.instance, each.port.port) == (name, "positon")
    ]
    page.done("channels", [channel.id])
    watcher = page.session.others.watcher
    assert watcher is not None
    found = watcher._components[name]
    until(lambda: found.ports["positon"].connector_profiles)
    page.done("activated", [name])
    until(lambda: now().current is ui.State.STATE_ACTIVE)
    operator.says("sent")
    until(lambda: page._follow() or page.samples)
    pose = xcdr.deserialize(TimedPose2D, page.samples[0])
    assert pose.data.position.x == 0.5
    status = TimedState(data=0)
    octets = xcdr.serialize(status, xcdr.representation_of(TimedState, 1))
    page.done("injected", ui.Inject(ui.PortAddress(name, "status"), octets))
    operator.says("FINISH")


def test_a_page_calls_its_service(
    launch: Callable[..., LoggedProcess],
    naming_service: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for file in CALC.iterdir():
        if file.is_file():
            (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert rtgen(["generate", "-q"]) == 0
    launch("adder", formats="%h.host_cxt/%n.rtc").says("ready")
    page = Page(naming_service)
    try:
        name = page.found("host_cxt/Counter0").instance
        page.done("activated", [name])
        [port] = page.session.remote.components[name].ports
        [interface] = port.interfaces
        assert (interface.name, interface.type) == ("adder", "Adder")
        operations = {each.name for each in interface.operations}
        assert operations == {"add", "nap", "_get_naps"}
        arguments = b"\0\1\0\0" + struct.pack("<ii", 2, 40)
        address = ui.PortAddress(name, port.name)
        called = ui.Call(address, "adder", "add", arguments)
        assert page.done("called", called).reply[4:] == struct.pack("<i", 42)
    finally:
        page.session.close()
