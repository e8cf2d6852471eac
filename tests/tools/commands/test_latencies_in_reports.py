"""The report of `rtgen run` has the latencies of chains of connections, as text and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from json_schemas import validator

from rtgen.cli import run as rtgen

ROOT = Path(__file__).parents[3]
SYSTEM = str(ROOT / "specs" / "navigation" / "rh3_goal.xml")
LOOP = "PathFollower0.velocity > RefHardRh30 > Odometry0 > PathFollower0.position"


@pytest.fixture(autouse=True)
def _in_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def test_in_the_text(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", SYSTEM, "--until", "1"]) == 0
    *_, report = capfd.readouterr().out.partition("samples  median [ms]")
    header, *rows = report.splitlines()
    assert header.split() == ["99", "%", "[ms]", "greatest", "[ms]", "chain"]
    found = [row.split(maxsplit=4) for row in rows if row]
    assert ["100", "1.000", "1.000", "1.000", LOOP] in found
    lengths = [row[4].count(">") for row in found]
    assert lengths == sorted(lengths, reverse=True)


@pytest.mark.sampled(0)
def test_in_json_of_all_chains(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", SYSTEM, "--until", "1", "--json"]) == 0
    report = json.loads(capfd.readouterr().out)
    validator("run.schema.json").validate(report)
    assert report["simulated"] == 1.0
    states = {each["instance"]: each["state"] for each in report["components"]}
    assert states["PathFollower0"] == "ACTIVE"
    [loop] = [each for each in report["latencies"] if each["name"] == LOOP]
    assert loop["samples"] == 100
    assert loop["least"] == loop["greatest"] == 1_000_000
    assert loop["ports"][0] == "PathFollower0.velocity"
    assert any(not each["samples"] for each in report["latencies"])


def test_in_real_time(capfd: pytest.CaptureFixture[str]) -> None:
    command = ["run", SYSTEM, "--clock", "real", "--until", "0.5", "--json"]
    assert rtgen(command) == 0
    report = json.loads(capfd.readouterr().out)
    validator("run.schema.json").validate(report)
    [loop] = [each for each in report["latencies"] if each["name"] == LOOP]
    assert 0 < loop["least"] <= loop["median"] <= loop["late"] <= loop["greatest"]


@pytest.mark.sampled(0)
def test_in_json_of_a_run_with_an_end(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", SYSTEM, "--json"]) == 0
    report = json.loads(capfd.readouterr().out)
    validator("run.schema.json").validate(report)
    assert report["end"] == {"met": True, "state": "PositionInput0 finished"}
