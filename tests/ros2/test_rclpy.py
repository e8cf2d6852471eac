"""The network of rclpy: what `--ros2` chooses, and what is refused, in installations of ROS 2."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import media
import pytest
from ros2_peers import Installation, installation

from rtgen.cli import run as rtgen

pytestmark = [pytest.mark.peer, pytest.mark.waits]

NO_VARIABLES: Mapping[str, str] = {}
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:s:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:rtgen::Part:1.0.0" rts:instanceName="Part0"
      rts:pathUri="localhost/Part0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
SETTINGS = """
[sources]
paths = ["t.idl", "lab", "std_msgs"]
include = ["{share}"]
[output]
package = "parts_{name}"
skeletons = "src/parts"
[ros2.topics]
"""
IDL = """
#include "std_msgs/msg/Float32.idl"
#include "std_msgs/msg/String.idl"
#include "std_srvs/srv/SetBool.idl"
#include "test_msgs/action/Fibonacci.idl"
#include "lab/msg/Own.idl"
#include "lab/srv/Ask.idl"
#include "lab/action/Go.idl"
interface Asked { lab::srv::Ask_Response ask(in lab::srv::Ask_Request request); };
component Part {
    publishes std_msgs::msg::Float32 changed;
    publishes std_msgs::msg::String fine;
    publishes std_srvs::srv::SetBool_Request request;
    publishes test_msgs::action::Fibonacci_SendGoal_Request goal;
    publishes lab::msg::Own own;
    provides Asked asked;
    @port("go") provides lab::action::Go goals;
    @port("go") uses lab::action::Go_Events events;
};
"""
FLOAT32 = "RIHS01_7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2"
TOPIC = '"Part0.{0}" = "{0}"'
SERVICE = '[ros2.services]\n"Part0.asked.ask" = "ask"'
ACTION = '[ros2.actions]\n"Part0.go" = "go"'


def settings() -> str:
    share = installation("jazzy").share.as_posix()
    return SETTINGS.format(name="rclpy", share=share)


@pytest.fixture(
    scope="module", params=["jazzy", pytest.param("kilted", marks=pytest.mark.nightly)]
)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a generated project with own types, and a changed one of ROS 2."""
    folder = tmp_path_factory.mktemp("rclpy")
    files = {
        "t.idl": IDL,
        "system.xml": SYSTEM,
        "rtgen.toml": settings(),
        "std_msgs/msg/Float32.msg": "float64 data\n",
        "lab/msg/Own.msg": "float64 x\n",
        "lab/srv/Ask.srv": "float64 x\n---\nfloat64 x\n",
        "lab/action/Go.action": "float64 x\n---\nfloat64 x\n---\nfloat64 x\n",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
    return folder


@pytest.fixture
def run(
    ros2: Installation, project: Path
) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Return a function that runs the system with lines of `[ros2.topics]`, and options."""

    def ran(
        lines: str,
        *options: str,
        rtgen: str = ros2.rtgen,
        variables: Mapping[str, str] = NO_VARIABLES,
    ) -> subprocess.CompletedProcess[str]:
        text = settings() + lines
        (project / "rtgen.toml").write_text(text)
        command = [rtgen, "run", "system.xml", "--clock", "real", "--until", "0.1"]
        return subprocess.run(
            [*command, *options],
            cwd=project,
            env={**ros2.environment(media.own_domain()), **variables},
            capture_output=True,
            text=True,
            check=False,
        )

    return ran


def test_rclpy_is_taken_if_it_is_there(run: Callable[..., Any]) -> None:
    topics = "\n".join(map(TOPIC.format, ("fine", "request", "goal")))
    for option in ("--ros2", "--ros2=rclpy"):
        done = run(topics, option)
        assert done.returncode == 0, done.stderr
        assert "ROS 2: rclpy, rmw_fastrtps_cpp\n" in done.stderr
        assert "PRJ0020" not in done.stderr


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("lines", "what"),
    [
        (TOPIC.format("own"), "/own: lab/msg/Own: the package lab"),
        (SERVICE, "/ask: lab/srv/Ask: the package lab"),
        (ACTION, "/go/_action/send_goal: lab/action/Go_SendGoal: the package lab"),
    ],
)
def test_types_that_are_not_installed_are_refused(
    lines: str, what: str, run: Callable[..., Any]
) -> None:
    done = run(lines, "--ros2", "rclpy")
    assert done.returncode == 3, done.stderr
    assert f"{what} is not installed in this ROS 2" in done.stderr
    assert "rtgen new ros2-package" in done.stderr
    assert "--ros2 dds" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.nightly
def test_types_that_differ_from_the_installed_ones_are_refused(
    run: Callable[..., Any],
) -> None:
    done = run(TOPIC.format("changed"), "--ros2", "rclpy")
    assert done.returncode == 3, done.stderr
    assert "/changed: std_msgs/msg/Float32 is not the one" in done.stderr
    assert f"that of the installation {FLOAT32}" in done.stderr
    assert done.stderr.count("RIHS01_") == 2


@pytest.mark.nightly
def test_settings_of_other_networks_are_told(run: Callable[..., Any]) -> None:
    lines = TOPIC.format("fine") + '\n[ros2]\ninterface = "lo"\nnode = "n"'
    done = run(lines.replace("\n[ros2]\n", "\n[ros2]\n"), "--ros2", "rclpy")
    assert "[ros2] interface is not for --ros2 rclpy" in done.stderr


@pytest.mark.nightly
def test_dds_is_taken_where_rclpy_is_not(run: Callable[..., Any]) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    own = str(Path(sys.executable).with_name("rtgen"))
    done = run(TOPIC.format("fine"), "--ros2", rtgen=own)
    assert done.returncode == 0, done.stderr
    assert "ROS 2: dds\n" in done.stderr
    done = run(TOPIC.format("fine"), "--ros2", "rclpy", rtgen=own)
    assert done.returncode == 3
    assert "rclpy, which cannot be imported" in done.stderr
    assert "setup.bash" in done.stderr


def test_errors_of_rclpy_are_reported(run: Callable[..., Any]) -> None:
    place = "/nowhere/keys"
    variables = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}
    done = run(
        TOPIC.format("fine"),
        "--ros2",
        variables={**variables, "ROS_SECURITY_KEYSTORE": place},
    )
    assert done.returncode == 3
    assert "error[ENV0001]: rclpy: " in done.stderr
    assert place in done.stderr
    assert "Traceback" not in done.stderr
