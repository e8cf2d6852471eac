"""What the exit code, the report and the lines of `rtgen run` say of how components ended."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from small_systems import data_port, system_text

from rtgen.cli import run as rtgen

MODULE = """
from rtgen.runtime import (
    RTC_ERROR, RTC_OK, Component, ComponentProfile, OutPort, InPort, PortProfile)
from rtgen.runtime.library.rtc import TimedLong


class Worker(Component):
    profile = ComponentProfile("Worker", rate=20.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.turns = self.add_out_port("turns", TimedLong)

    def end(self):
        return self.fail("all is done")

    def on_execute(self, ec_id):
        self.turns.write(TimedLong())
        return self.end() if self.now() >= 750_000_000 else RTC_OK


class Silent(Worker):
    def end(self):
        return RTC_ERROR


class Raising(Worker):
    def end(self):
        raise ValueError("bad luck")


class Steady(Worker):
    def end(self):
        return RTC_OK


class Unready(Worker):
    def on_activated(self, ec_id):
        return self.fail("no file")


class Reader(Component):
    profile = ComponentProfile("Reader", rate=20.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.turns = self.add_in_port("turns", TimedLong)

    def on_execute(self, ec_id):
        while self.turns.is_new():
            self.turns.read()
        return RTC_OK


class Lazy(Reader):
    def on_execute(self, ec_id):
        return RTC_OK
"""
TYPES = ("Worker", "Silent", "Raising", "Steady", "Unready", "Reader", "Lazy")


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "workers.py").write_text(MODULE)
    lines = [f'{name} = "workers:{name}"\n' for name in TYPES]
    (tmp_path / "rtgen.toml").write_text("[components]\n" + "".join(lines))
    yield
    sys.modules.pop("workers", None)


FINISHES = {"finishes": "A0"}
UNTIL = {"until": "A0=ERROR,5"}


@pytest.mark.parametrize(
    ("type_", "properties", "options", "code", "state"),
    [
        ("Worker", {}, "--until 2", 1, "ERROR"),
        ("Silent", {}, "--until 2", 1, "ERROR"),
        ("Raising", {}, "--until 2", 1, "ERROR"),
        ("Unready", {}, "--until 2", 1, "ERROR"),
        ("Steady", {}, "--until 2", 0, "ACTIVE"),
        ("Worker", {}, "--until 0.5", 0, "ACTIVE"),
        # What the user waits for is no failure, and the system says nothing of it.
        ("Worker", {}, "--until A0=ERROR", 0, "ERROR"),
        ("Raising", {}, "--until A0=ERROR", 1, "ERROR"),
        ("Worker", FINISHES, "--until 2", 0, "finished"),
        ("Silent", FINISHES, "--until 2", 0, "finished"),
        ("Raising", FINISHES, "--until 2", 1, "ERROR"),
        ("Unready", FINISHES, "--until 2", 1, "ERROR"),
        ("Worker", FINISHES, "--until A0=ERROR", 0, "finished"),
        ("Worker", UNTIL, "", 0, "finished"),
        ("Worker", UNTIL, "--until 2", 0, "finished"),
        ("Unready", UNTIL, "--until 2", 1, "ERROR"),
        ("Steady", UNTIL, "", 1, "ACTIVE"),
        ("Worker", {}, "--until 2 --fail-on never", 0, "ERROR"),
        ("Raising", {}, "--until 2 --fail-on never", 0, "ERROR"),
        ("Steady", UNTIL, "--fail-on never", 1, "ACTIVE"),
    ],
)
def test_exit_code_and_state(
    type_: str,
    properties: dict[str, str],
    options: str,
    code: int,
    state: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("s.xml").write_text(system_text({"A0": type_}, **properties))
    assert rtgen(["run", "s.xml", *options.split()]) == code
    assert re.search(r"^A0 +(\w+)", capfd.readouterr().out, re.M)[1] == state


def test_one_in_error_among_others_that_have_finished(
    capfd: pytest.CaptureFixture[str],
) -> None:
    components = {"A0": "Worker", "B0": "Worker", "C0": "Steady"}
    Path("s.xml").write_text(system_text(components, finishes="A0"))
    assert rtgen(["run", "s.xml", "--until", "2"]) == 1
    states = dict(re.findall(r"^([A-C]0) +(\w+)", capfd.readouterr().out, re.M))
    assert states == {"A0": "finished", "B0": "ERROR", "C0": "ACTIVE"}


@pytest.mark.parametrize("type_", ["Worker", "Silent", "Raising"])
def test_a_state_has_its_exact_time(
    type_: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("s.xml").write_text(system_text({"A0": type_}))
    Path("t.toml").write_text('[[at]]\nt = 0.333\nreset = "A0"\ndeactivate = "A0"\n')
    rtgen(["run", "s.xml", "--until", "0.76", "--timeline", "t.toml"])
    lines = capfd.readouterr().err.splitlines()
    assert [line for line in lines if line.startswith("0.000")] == [
        "0.000 s: A0 ACTIVE"
    ]
    assert "0.350 s: A0 INACTIVE" in lines
    Path("t.toml").write_text("")
    rtgen(["run", "s.xml", "--until", "0.76", "--timeline", "t.toml"])
    assert "0.750 s: A0 ERROR" in capfd.readouterr().err


def test_each_change_between_two_looks_is_shown(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("s.xml").write_text(system_text({"A0": "Steady"}))
    Path("t.toml").write_text(
        '[[at]]\nt = 0.2\ndeactivate = "A0"\n[[at]]\nt = 0.25\nactivate = "A0"\n'
    )
    assert rtgen(["run", "s.xml", "--until", "1", "--timeline", "t.toml"]) == 0
    assert re.findall(r"^([\d.]+) s: A0 (\w+)", capfd.readouterr().err, re.M) == [
        ("0.000", "ACTIVE"),
        ("0.200", "INACTIVE"),
        ("0.250", "ACTIVE"),
    ]


@pytest.mark.parametrize(
    ("reader", "events", "why"),
    [
        ("Lazy", "", r"place; read while is_new\(\), or read_newest\(\), in each tick"),
        ("Reader", 'deactivate 0.1\n', "place; B0 is in INACTIVE and does not read"),
        ("Reader", "deactivate 0.1\nactivate 1.1", "place; B0 was not ACTIVE and did not read"),
        (
            "Lazy",
            "deactivate 0.1\nactivate 1.1",
            r"place; \d+ while B0 was not ACTIVE, \d+ while it was: read while is_new",
        ),
    ],
)  # fmt: skip
def test_why_samples_are_lost(
    reader: str, events: str, why: str, capfd: pytest.CaptureFixture[str]
) -> None:
    link = data_port("A0.turns", "B0.turns", "IDL:RTC/TimedLong:1.0")
    Path("s.xml").write_text(system_text({"A0": "Steady", "B0": reader}, link))
    at = [line.split() for line in events.splitlines()]
    Path("t.toml").write_text(
        "".join(f'[[at]]\nt = {time}\n{what} = "B0"\n' for what, time in at)
    )
    assert rtgen(["run", "s.xml", "--until", "2", "--timeline", "t.toml"]) == 0
    assert re.search(why, capfd.readouterr().out)


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"finishes": "A1"}, r"s.xml:\d+:\d+: error\[SYS0005\]: no component 'A1'"),
        ({"finishs": "A0"}, r"s.xml:\d+:\d+: error\[SYS0029\]: 'rtgen.run.finishs'"),
        ({"untill": "3"}, "did you mean rtgen.run.until?"),
        ({"until": "A0=GONE"}, r"s.xml:\d+:\d+: error\[SYS0006\]: no state 'GONE'"),
        ({"pose": "A0.p, C0.p"}, r"s.xml:\d+:\d+: error\[SYS0005\]: no component 'C0'"),
    ],
)
def test_properties_are_checked_before_the_run(
    properties: dict[str, str], message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("s.xml").write_text(system_text({"A0": "Steady"}, **properties))
    assert rtgen(["run", "s.xml", "--until", "1"]) == 2
    assert re.search(message, capfd.readouterr().err)
