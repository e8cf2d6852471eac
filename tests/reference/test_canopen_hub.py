"""CANopen systems in real time, over `rtgen can hub`, with their devices in other processes."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import hypot
from pathlib import Path
from typing import Any

import pytest
from pipeline import NAVIGATION, at_end, goal, profile

from refnav.geometry import Pose, wrap
from rtgen.cli import run
from rtgen.compiler.project import load
from rtgen.compiler.systems.timeline import assignment
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    RealClock,
    System,
)
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

CANOPEN = NAVIGATION.parent / "canopen"
BUS = CANOPEN / "pdo_linking.toml"
PATIENCE = 60 * SECOND

pytestmark = [pytest.mark.slow, pytest.mark.waits]


@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Yield a command of rtgen in a process, which is killed at the end if it still runs."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rtgen", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def ended(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Return the output of a process until SIGTERM; Ctrl-C may be ignored in the background."""
    process.send_signal(signal.SIGTERM)
    output = process.communicate(timeout=30)
    assert process.returncode == 0, output
    return output


@pytest.fixture
def port() -> Iterator[int]:
    """Yield the port of a hub."""
    with started("can", "hub", "--port", "0") as hub:
        assert hub.stdout is not None
        yield int(hub.stdout.readline().rpartition(":")[2])
        ended(hub)


def joined(port: int, *instances: str) -> list[str]:
    """Return the settings that put components on the hub's bus."""
    options = f"host=127.0.0.1,port={port},tcp_tune=True"
    values = {"interface": "socketcand", "options": options}
    return [
        f"{name}.{key}={text}" for name in instances for key, text in values.items()
    ]


def options(settings: Sequence[str]) -> list[str]:
    return [part for setting in settings for part in ("--set", setting)]


def until(system: System, condition: Any) -> None:
    assert system.run(system.time + PATIENCE, condition)


DRIVES = str(CANOPEN / "rh3_drives.xml")
WHEELS = "LeftWheel0", "RightWheel0"


@contextmanager
def base(port: int) -> Iterator[System]:
    """Yield RH3 without its drives, on the hub's bus, with a near goal."""
    system = profile(CANOPEN / "rh3_pc.xml")
    settings = joined(port, *WHEELS, "CanopenManager0")
    # The process with the drives may take its time to start.
    settings += [f"{wheel}.boot_timeout=30000" for wheel in WHEELS]
    values = [assignment(text, system) for text in [*settings, *goal(0.5, 0.0, 0.0)]]
    with assemble(system, Factories(load()), RealClock(), values, []) as running:
        yield running


def where(system: System) -> Pose:
    return Pose(*system.observable("RefHardRh3Canopen0.truth"))


def bring_back(system: System, *wheels: str) -> None:
    """Reset and activate the proxies until they are ACTIVE: drives take their time."""
    for wheel in wheels:
        for _ in range(PATIENCE // SECOND):
            if system.state(wheel) is ERROR_STATE:
                system.reset(wheel)
            elif system.state(wheel) is INACTIVE_STATE:
                system.activate(wheel)
            system.run(
                system.time + SECOND, lambda s, w=wheel: s.state(w) is ACTIVE_STATE
            )
            if system.state(wheel) is ACTIVE_STATE:
                break
        assert system.state(wheel) is ACTIVE_STATE


def drive(system: System, condition: Any) -> None:
    """Run until a condition holds; on a busy machine a heartbeat may come too late meanwhile."""
    for _ in range(PATIENCE // SECOND):
        if system.run(system.time + SECOND, condition):
            return
        bring_back(system, *WHEELS)
    raise AssertionError("the base does not drive")


def assert_at_the_goal(system: System) -> None:
    drive(system, at_end)
    end = where(system)
    assert hypot(end.x - 0.5, end.y) < 0.05
    assert abs(wrap(end.theta)) < 0.03


@pytest.mark.nightly
def test_drives_in_another_process_one_falls_silent_and_the_run_goes_on(
    port: int,
) -> None:
    drives = options(joined(port, "LeftDrive0", "RightDrive0"))
    with (
        started("run", DRIVES, "--clock", "real", *drives) as process,
        base(port) as system,
    ):
        bring_back(system, *WHEELS)
        drive(system, lambda s: where(s).x > 0.1)
        system.configure("LeftWheel0", "Producer_heartbeat_time", "0")
        until(system, lambda s: s.state("LeftWheel0") is ERROR_STATE)
        assert "no heartbeat" in system.statistics("LeftWheel0").reason
        until(system, lambda s: not any(s.observable("RefHardRh3Canopen0.wheels")))
        assert where(system).x < 0.45
        system.configure("LeftWheel0", "Producer_heartbeat_time", "100")
        bring_back(system, "LeftWheel0")
        assert_at_the_goal(system)
        ended(process)


@pytest.mark.nightly
def test_drives_that_are_switched_off_and_on_count_anew(port: int) -> None:
    drives = options(joined(port, "LeftDrive0", "RightDrive0"))
    with base(port) as system:
        with started("run", DRIVES, "--clock", "real", *drives) as process:
            bring_back(system, *WHEELS)
            drive(system, lambda s: where(s).x > 0.1)
            process.kill()
            for wheel in WHEELS:
                until(system, lambda s, w=wheel: s.state(w) is ERROR_STATE)
        before = where(system)
        with started("run", DRIVES, "--clock", "real", *drives) as process:
            bring_back(system, *WHEELS)
            assert where(system).x >= before.x
            assert_at_the_goal(system)
            ended(process)


def values(lines: Sequence[str]) -> list[Any]:
    """Return the content of decoded frames, without times."""
    found = [json.loads(line) for line in lines]
    return [{k: v for k, v in line.items() if k != "time"} for line in found]


@pytest.mark.nightly
def test_a_record_of_pdo_linking_is_whole_and_replays(
    port: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    record = tmp_path / "run.log"
    on = ["--interface", "socketcand", "--option", f"port={port}", "--channel"]
    names = "PaletteBoard0", "MotorUnit0", "Palette0", "Motor0", "CanopenManager0"
    turning = ["Potentiometer0.frequency=0.3", "Potentiometer0.amplitude=1.25"]
    settings = [*joined(port, *names), *turning]
    with started("can", "record", str(record), *on, "can0") as recorder:
        assert recorder.stderr is not None
        assert "recording" in recorder.stderr.readline()
        file = str(CANOPEN / "pdo_linking.xml")
        command = ["run", file, "--clock", "real", "--until", "6", *options(settings)]
        with started(*command) as running:
            output = running.communicate(timeout=60)
            assert running.returncode == 0, output
        ended(recorder)
    flags = ["--json", "--bus", str(BUS)]
    capfd.readouterr()
    assert run(["can", "replay", str(record), "--decode", *flags]) == 0
    recorded = values(capfd.readouterr().out.splitlines())
    # The frames that the nodes send by themselves; the motor follows.
    references = [
        line["values"][0]["value"]
        for line in recorded
        if (line.get("name"), line["kind"]) == ("palette", "tpdo4")
    ]
    places = [
        line["values"][0]["value"]
        for line in recorded
        if (line.get("name"), line["kind"]) == ("motor", "tpdo2")
    ]
    assert max(references) == pytest.approx(45_000, abs=2000)
    assert min(references) == pytest.approx(-45_000, abs=2000)
    assert max(places) > 30_000
    assert min(places) < -30_000
    assert not [line for line in recorded if line["kind"].startswith("rpdo")]
    # The same again, from another channel.
    again = tmp_path / "again.log"
    count = str(len(record.read_text().splitlines()))
    with started(
        "can", "record", str(again), *on, "can1", "--count", count
    ) as recorder:
        assert recorder.stderr is not None
        assert "recording" in recorder.stderr.readline()
        assert run(["can", "replay", str(record), *on, "can1"]) == 0
        output = recorder.communicate(timeout=60)
        assert recorder.returncode == 0, output
    capfd.readouterr()
    assert run(["can", "replay", str(again), "--decode", *flags]) == 0
    assert values(capfd.readouterr().out.splitlines()) == recorded
