"""Commands on the reference systems: graph, inspect, run with wrong connections, a terminal."""

from __future__ import annotations

import json
import os
import pty
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from rtgen.cli import run

ROOT = Path(__file__).resolve().parents[3]
SYSTEM = ROOT / "specs" / "navigation" / "rh3_goal.xml"


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder in which the definitions of the reference tree are kept."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def _at_root(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(cache))


def changed(folder: Path, old: str, new: str) -> str:
    """Return the reference system with one text changed."""
    text = SYSTEM.read_text(encoding="utf-8")
    assert old in text
    file = folder / "changed.xml"
    file.write_text(text.replace(old, new), encoding="utf-8")
    return str(file)


def test_graph(tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert run(["graph", str(SYSTEM)]) == 0
    picture = capfdbinary.readouterr().out
    assert ElementTree.fromstring(picture).tag == "{http://www.w3.org/2000/svg}svg"
    assert b"PathFollower0" in picture
    file = tmp_path / "wiring.svg"
    assert run(["graph", str(SYSTEM), "-o", str(file)]) == 0
    assert file.read_bytes() == picture
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "system.xml").write_bytes(SYSTEM.read_bytes())
    assert run(["graph", str(folder), "-o", str(file)]) == 0
    assert file.read_bytes() == picture


@pytest.mark.sampled(0)
def test_graph_into_a_folder_that_is_not_there(tmp_path: Path) -> None:
    picture = tmp_path / "new" / "folder" / "x.svg"
    assert run(["graph", str(SYSTEM), "-o", str(picture)]) == 0
    assert picture.stat().st_size > 0
    assert run(["graph", str(SYSTEM), "-o", str(picture / "x.svg")]) == 3


def test_graph_refuses_other_formats(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "wiring.png"
    assert run(["graph", str(SYSTEM), "-o", str(file)]) == 2
    assert "the picture is SVG" in capfd.readouterr().err
    assert not file.exists()


@pytest.mark.parametrize("command", ["graph", "run", "inspect"])
def test_a_system_that_cannot_be_read(
    command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.xml").write_text("<RtsProfile>")
    for name in ("bad.xml", "gone.xml"):
        assert run([command, str(tmp_path / name)]) == 2
        assert "error[RTC" in capfd.readouterr().err


def test_inspect_of_a_system(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["inspect", str(SYSTEM), "--json"]) == 0
    [system] = json.loads(capfd.readouterr().out)["declarations"]
    assert system["kind"] == "system"
    assert len(system["components"]) == 6
    assert len(system["connections"]) == 10
    assert {
        "from": "PositionInput0..positon",
        "to": "OmniTo2WD0.goal",
    }.items() <= system["connections"][0].items()


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("old", "new", "code", "message"),
    [
        ("PathFollower0.velocity", "PathFollower0.velocty", "SYS0003", "'velocty'"),
        (
            "Odometry0.CurrentWheelAngle",
            "Odometry0.OdometryPosition",
            "RTC0582",
            "Odometry0",
        ),
        ("Navigation0.path", "Navigation0.status", "RTC0582", "RTC::TimedState"),
    ],
)
def test_connections_that_do_not_fit(
    old: str,
    new: str,
    code: str,
    message: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    system = changed(tmp_path, f'rts:portName="{old}"', f'rts:portName="{new}"')
    assert run(["run", system]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert f"error[{code}]" in err
    assert message in err


@pytest.mark.sampled(0)
def test_the_goal_is_reached_and_two_runs_are_the_same(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    logs = []
    for name in ("a", "b"):
        file = tmp_path / name
        goal = ["--set", "PositionInput0.01_x=0.3", "--set", "PositionInput0.01_y=0"]
        assert run(["run", str(SYSTEM), "--log", str(file), *goal]) == 0
        logs.append(file.read_bytes())
    assert logs[0] == logs[1]
    lines = dict(
        line.split("  ", 1)
        for line in capfd.readouterr().out.splitlines()
        if "error" in line
    )
    assert float(lines["position error [m]"]) < 0.05
    assert float(lines["heading error [rad]"]) < 0.03


def test_on_a_terminal_there_is_a_bar() -> None:
    process, terminal = pty.fork()
    if process == 0:
        command = [sys.executable, "-m", "rtgen", "run", str(SYSTEM), "--until", "2"]
        os.execv(sys.executable, command)
    shown = b""
    while True:
        try:
            data = os.read(terminal, 4096)
        except OSError:
            break
        if not data:
            break
        shown += data
    os.close(terminal)
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
    assert "━".encode() in shown
    assert b"instance" in shown


@pytest.mark.sampled(0)
def test_what_editors_leave_out_and_leave_behind(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Real files have no abstract, connectors without attributes, and properties of the editor."""
    text = re.sub(
        r'\s(rts:abstract|rts:dataType|rts:interfaceType)="[^"]*"',
        "",
        SYSTEM.read_text(),
    )
    text = re.sub(r'\s(rts:dataflowType|rts:subscriptionType)="[^"]*"', "", text)
    text = re.sub(r"<rtsExt:Properties rtsExt:name=.dataport[^>]*/>", "", text)
    left = (
        '<rtsExt:Properties rtsExt:name="POSITION" rtsExt:value="{1:(137,56)}"/>'
        '<rtsExt:Properties rtsExt:name="dataport.corba_cdr.inport_ior" rtsExt:value="IOR:00"/>'
        "</rts:DataPortConnectors>"
    )
    file = tmp_path / "real.xml"
    file.write_text(text.replace("</rts:DataPortConnectors>", left), encoding="utf-8")
    assert run(["run", str(file), "--until", "0.05"]) == 0
    assert "warning" not in capfd.readouterr().err


def test_connector_properties_are_reported_at_their_places(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    name = 'rtsExt:name="dataport.inport.buffer.length" rtsExt:value="1024"'
    qos = 'rtsExt:name="dataport.qos.lease" rtsExt:value="{}"'
    assert run(["run", changed(tmp_path, name, qos.format(0.5)), "--until", "0"]) == 0
    assert run(["run", changed(tmp_path, name, qos.format("no")), "--until", "0"]) == 2
    assert "it must be a time in seconds, above 0" in capfd.readouterr().err
    file = changed(tmp_path, name, name.replace("buffer", "bufer"))
    assert run(["run", file, "--until", "0"]) == 2
    assert "did you mean dataport.inport.buffer.length?" in capfd.readouterr().err
    assert run(["convert", file, "--to", "rts-yaml"]) == 0
    assert "warning[RTC0583]" in capfd.readouterr().err
