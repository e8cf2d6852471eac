"""The commands of rtshell on components of `rtgen run --transport corba`.

rtinject and rtprint are components of OpenRTM themselves, so they need the real one.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import middleware
import pytest
from logged_process import LoggedProcess
from patience import PATIENCE, until

pytestmark = [
    pytest.mark.skipif(
        importlib.util.find_spec("rtshell") is None,
        reason="rtshell-aist is not installed",
    ),
]

ROOT = Path(__file__).parents[2]
COMPONENT = """
  <rts:Components rts:id="RTC:rtgen:Navigation:{type}:1.1.0" rts:instanceName="{type}0"
      rts:pathUri="localhost/{type}0.rtc" rts:compositeType="None" rts:isRequired="true">
    <rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="50.0"/>
  </rts:Components>"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:lab:two:1.0.0" rts:version="0.2" rts:abstract="two"
    rts:creationDate="1970-01-01T00:00:00" rts:updateDate="1970-01-01T00:00:00"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">{}
</rts:RtsProfile>
"""
MISSING = (
    "import inspect\ninspect.getargspec = lambda f: inspect.getfullargspec(f)[:4]\n"
)
"""Names removed in Python 3.11 that rtshell-aist 4.2 uses in rtinject and rtprint."""


class Shell:
    """Runs commands of rtshell on a system of a base and its odometry."""

    def __init__(self, address: str, folder: Path, run: LoggedProcess) -> None:
        self.run = run
        self._address = address
        self._folder = folder

    def __call__(self, command: str, *arguments: str) -> str:
        """Return the output of a command; `@` in its arguments stands for the naming service."""
        code = f"{MISSING}from rtshell.{command} import main\nraise SystemExit(main())"
        words = [each.replace("@", self._address) for each in arguments]
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code, *words],
            cwd=self._folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def state(self, name: str) -> str:
        """Return the state of a component by rtls."""
        [line] = [
            line for line in self("rtls", "-l", "/@/").splitlines() if name in line
        ]
        return line.split()[0]

    def comes(self, name: str, state: str) -> None:
        """Wait for a state."""
        until(lambda: self.state(name) == state)

    @property
    def is_connected(self) -> bool:
        """Whether the wheel angles are connected with the odometry."""
        ports = self("rtcat", "-l", "/@/Odometry0.rtc")
        return "RefHardRh30.rtc:OutWheelAngle" in ports


@pytest.fixture
def shell(tmp_path: Path, naming_service: str) -> Iterator[Shell]:
    parts = (COMPONENT.format(type=name) for name in ("RefHardRh3", "Odometry"))
    system = tmp_path / "two.xml"
    system.write_text(SYSTEM.format("".join(parts)))
    command = ["-m", "rtgen", "run", str(system), "--clock", "real"]
    command += ["--transport", "corba", "--nameserver", naming_service]
    log = tmp_path / "run.txt"
    run = LoggedProcess(command, ROOT, {**os.environ, "PYTHONPATH": ""}, log)
    run.says("Odometry0 ACTIVE")
    yield Shell(naming_service, tmp_path, run)
    assert run.end() == 0, run.text


ENDS = "/@/RefHardRh30.rtc:OutWheelAngle", "/@/Odometry0.rtc:CurrentWheelAngle"


def test_connections_are_made_recorded_and_restored(shell: Shell) -> None:
    assert shell.state("Odometry0.rtc") == "Active"
    assert not shell.is_connected
    shell("rtcon", *ENDS)
    assert shell.is_connected
    shell("rtcryo", "-o", "saved.xml", "@")
    shell("rtdis", "/@/RefHardRh30.rtc")
    assert not shell.is_connected
    shell("rtresurrect", "saved.xml")
    assert shell.is_connected
    shell("rtteardown", "saved.xml")
    assert not shell.is_connected


def test_states_and_parameters(shell: Shell) -> None:
    base = "/@/RefHardRh30.rtc"
    shell("rtdeact", base)
    shell.comes("RefHardRh30.rtc", "Inactive")
    shell("rtconf", base, "set", "PlantRoom", "nowhere.txt")
    assert shell("rtconf", base, "get", "PlantRoom").strip() == "nowhere.txt"
    shell("rtact", base)
    shell.comes("RefHardRh30.rtc", "Error")
    shell("rtconf", base, "set", "PlantRoom", "")
    shell("rtreset", base)
    shell.comes("RefHardRh30.rtc", "Inactive")
    shell("rtact", base)
    shell.comes("RefHardRh30.rtc", "Active")


@pytest.mark.skipif(not middleware.REAL, reason="OpenRTM-aist-Python is not installed")
def test_samples_are_printed_and_injected(shell: Shell) -> None:
    printed = shell("rtprint", "-n", "3", ENDS[0])
    assert printed.count("TimedDoubleSeq(tm=") == 3
    assert printed.count("data=[0.0, 0.0]") == 3
    # One wheel is missing, which the odometry refuses. Several samples: rtinject cuts its
    # connection after the last one, and unread ones are lost.
    angles = "RTC.TimedDoubleSeq(RTC.Time(0, 0), [0.5])"
    shell("rtinject", "-n", "3", "-r", "5", "-c", angles, ENDS[1])
    shell.comes("Odometry0.rtc", "Error")
    shell.run.says("CurrentWheelAngle: 1 angles, a wheel is missing")
    shell("rtreset", "/@/Odometry0.rtc")
    shell.comes("Odometry0.rtc", "Inactive")
