"""The rates at which the components of a system write to the proxies of a bus."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.compiler.frontends import bus as front_end
from rtgen.compiler.layouts.can_messages import Writing
from rtgen.compiler.model import System
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.systems import reading as systems
from rtgen.tools.can.writing_rates import writings

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "specs/canopen"


@pytest.fixture
def beego() -> tuple[Bus, System]:
    bus = front_end.load(FOLDER / "rh3_beego.toml", root=ROOT).bus
    (system,) = systems.read([FOLDER / "rh3_beego.xml"], root=ROOT, output=ROOT).systems
    assert bus is not None
    return bus, system


def test_contexts_write_once_a_tick(beego: tuple[Bus, System]) -> None:
    found = writings(*beego)
    # RefHardRh3Canopen has 100 Hz, the proxies have 200.
    assert found == {
        (node, number): Writing(0.01, 0.005)
        for node in ("left", "right")
        for number in (1, 3)
    }


def test_a_faster_writer_and_a_periodic_connector(beego: tuple[Bus, System]) -> None:
    bus, system = beego
    components = tuple(
        replace(c, rate=1000.0) if c.instance == "RefHardRh3Canopen0" else c
        for c in system.components
    )
    periodic = (
        ("dataport.subscription_type", "periodic"),
        ("dataport.push_rate", "50"),
    )
    connections = tuple(
        replace(c, properties=periodic) if c.target.port == "rpdo3" else c
        for c in system.connections
    )
    found = writings(
        bus, replace(system, components=components, connections=connections)
    )
    assert found["left", 1] == Writing(0.001, 0.005)
    assert found["right", 3] == Writing(0.02, 0.005)


def test_on_the_command_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    arguments = ["can", "timing", "--json", "specs/canopen/rh3_beego.toml"]
    assert run([*arguments, "--system", "specs/canopen/rh3_beego.xml"]) == 0
    report = json.loads(capsys.readouterr().out)
    periods = {m["name"]: m["period_ns"] for m in report["messages"]}
    assert periods["left.rpdo1"] == 10_000_000
