"""A base that `rtgen new base --ros2` makes of RH3's drives, driven by a program of rclpy."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import media
import pytest
from free_ports import free_port
from logged_process import LoggedProcess
from ros2_peers import installation
from type_checkers import check_by_mypy

from rtgen.cli import run as rtgen
from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.ros2.network import RosNode, RosTopic
from rtgen.runtime.ros2.types import decoded
from rtgen.tools.running.ros2 import message_classes

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from rtgen.runtime.ros2.dds import open_dds

ROOT = Path(__file__).resolve().parents[2]
EDS = ROOT / "specs" / "canopen" / "epos_drive.eds"
CDL = ROOT / "specs" / "tecs" / "board.cdl"
DOMAIN = media.own_domain()
TRANSFORMS = "tf2_msgs/msg/TFMessage"


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.waits
@pytest.mark.parametrize(
    ("source", "kind"),
    [
        (EDS, "stamped"),
        pytest.param(EDS, "plain", marks=pytest.mark.nightly),
        pytest.param(CDL, "stamped", marks=pytest.mark.nightly),
    ],
)
def test_a_base_is_driven_by_rclpy(
    source: Path, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It stops when the commands end."""
    peer = installation("jazzy")
    monkeypatch.chdir(tmp_path)
    twist = [] if kind == "stamped" else ["--twist"]
    assert rtgen(["new", "base", "Rover", str(source), "--ros2", *twist]) == 0
    folder = tmp_path / "Rover"
    environment = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN)}
    command = ["-m", "rtgen", "run", "systems/simulation.xml", "--clock", "real"]
    if source == CDL:
        port = free_port()
        for setting in ("Board0.port", "OpaqueRpcCommunication0.port"):
            command += ["--set", f"{setting}={port}"]
    type_ = message_classes(TRANSFORMS)[TRANSFORMS]
    transforms: list[Any] = []
    network = open_dds(RosNode("listener", "/", DOMAIN))
    network.subscribe(
        RosTopic("/tf", type_),
        PROFILES["default"],
        lambda octets: transforms.append(decoded(type_, octets)),
    )
    run = LoggedProcess(
        [*command, "--ros2", "dds"], folder, environment, tmp_path / "run.log"
    )
    try:
        run.says("Base0 ACTIVE")
        script = Path(__file__).with_name("rclpy_teleop.py")
        found = json.loads(peer.output(script, kind, domain=DOMAIN).splitlines()[-1])
    finally:
        run.end()
        network.close()
    assert {*found["received"]} == {"/odom", "/joint_states", "/diagnostics"}
    # tf2_msgs has no package for rclpy there.
    [transform] = transforms[-1].transforms
    assert [transform.header.frame_id, transform.child_frame_id] == found["frames"]
    assert transform.transform.translation.x == pytest.approx(found["way"], abs=0.02)
    # Without a command it goes on for 0.5 s, at 0.2 m/s; messages take their time.
    assert 0.3 <= found["way"] < 1.0
    assert found["angle"] == pytest.approx(found["way"] / 0.1, abs=0.01)
    assert found["frames"] == ["odom", "base_link"]
    assert found["joints"] == ["left_wheel_joint", "right_wheel_joint"]
    drives = {"Base0: left drive": "enabled", "Base0: right drive": "enabled"}
    assert found["diagnosed"] == {
        "Base0: command": "no velocity: the base stands",
        **({"Base0: board": "answers"} if source == CDL else drives),
    }


def test_what_a_drive_lacks_is_located(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is left behind."""
    monkeypatch.chdir(tmp_path)
    text = EDS.read_text()
    assert "0x60FF0020" in text
    Path("drive.eds").write_text(text.replace("0x60FF0020", "0x607A0020"))
    assert rtgen(["new", "base", "Rover", "drive.eds", "--ros2"]) == 2
    error = capsys.readouterr().err
    assert "drive.eds:" in error
    assert "NEW0006" in error
    assert "no RPDO maps the target, 60FFh" in error
    assert [path.name for path in Path().iterdir()] == ["drive.eds"]


def test_two_descriptions_and_no_ros2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.eds").write_bytes(EDS.read_bytes())
    other = EDS.read_text().replace("ProductName=", "ProductName=Other ", 1)
    Path("two.eds").write_text(other)
    assert rtgen(["new", "base", "Rover", "one.eds", "two.eds", "--ros2"]) == 0
    monkeypatch.chdir("Rover")
    assert rtgen(["check", "-q", "--no-cache"]) == 0
    bus = Path("definitions/rover_bus.toml").read_text()
    assert '[device.left]\neds = "one.eds"' in bus
    assert '[device.right]\neds = "two.eds"' in bus
    capsys.readouterr()
    assert rtgen(["new", "base", "Other", str(EDS)]) == 2
    assert "Missing option '--ros2'" in capsys.readouterr().err


@pytest.mark.sampled(0)
@pytest.mark.parametrize("source", [pytest.param(EDS, marks=pytest.mark.nightly), CDL])
def test_what_it_makes_is_sound(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert rtgen(["new", "base", "Rover", str(source), "--ros2"]) == 0
    with monkeypatch.context() as inside:
        inside.chdir("Rover")
        assert rtgen(["check", "--no-cache"]) == 0
        folders = [Path("src").resolve(), Path("generated").resolve()]
        check_by_mypy([Path("src"), Path("tests")], folders)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd="Rover",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


SHAPES = {
    "two numbers, and a function for the counts": (
        "void setSpeeds( [in] int16_t left, [in] int16_t right );"
        "ER getCounts( [out,size_is(2)] int32_t *count );"
    ),
    "arrays of fixed length": (
        "void drive( [in] const float32_t speed[2], [out] struct tagWheels *wheels );"
    ),
    "a getter with a struct, sizes, a limit": (
        "ER identify( [out,string(9)] char_t *name ); ER setLimit( [in] float32_t speed );"
        "ER go( [in,size_is(n)] const int32_t *speeds, [in] uint8_t n );"
        "void look( [out] struct tagWheels *class );"
    ),
}
JOIN = """
struct tagWheels { float32_t volts; int16_t position[2]; };
signature sBase { %s };
celltype tBase { entry sBase eBase; };
[active] celltype tUser { call sBase cBase; };
cell tBase Base {};
cell tUser User { [through(RTCPlugin,"")] cBase = Base.eBase; };
"""


@pytest.mark.nightly
@pytest.mark.parametrize("shape", SHAPES)
def test_boards_of_other_shapes(
    shape: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wheels.cdl").write_text(JOIN % SHAPES[shape])
    assert rtgen(["new", "base", "Rover", "wheels.cdl", "--ros2"]) == 0
    with monkeypatch.context() as inside:
        inside.chdir("Rover")
        folders = [Path("src").resolve(), Path("generated").resolve()]
        check_by_mypy([Path("src"), Path("tests")], folders)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd="Rover",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_a_board_without_such_a_function(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wheels.cdl").write_text(JOIN % "ER beep( [in] uint8_t times );")
    assert rtgen(["new", "base", "Rover", "wheels.cdl", "--ros2"]) == 2
    error = capsys.readouterr().err
    assert "NEW0006" in error
    assert "there are: beep" in error
    assert [path.name for path in Path().iterdir()] == ["wheels.cdl"]
