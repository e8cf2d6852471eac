"""Units along the way from the goal in metres to the increments of the wheels."""

from __future__ import annotations

from math import tau
from pathlib import Path

import pytest

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.model.system_links import DATA_KINDS
from rtgen.compiler.typemap.canopen.drive_units import NoFactorError, drive_factor

ROOT = Path(__file__).parents[2]
SYSTEMS = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "specs").rglob("*.xml")
    if b"RtsProfile" in path.read_bytes()[:1000]
)
UNITS = ("RTC0593", "RTC0594", "RTC0595", "RTC0596", "LINT0021", "LINT0022")


@pytest.fixture(autouse=True)
def in_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.mark.nightly
def test_systems_of_the_reference_build_have_no_finding_about_units(
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert len(SYSTEMS) > 15
    assert run(["lint"]) == 0
    assert run(["inspect", *SYSTEMS]) == 0
    said = capfd.readouterr()
    assert [code for code in UNITS if code in said.out + said.err] == []


def test_ports_of_the_robot_with_measures_say_their_units() -> None:
    model = api.compile(sorted((ROOT / "specs" / "navigation").glob("*.idl")))
    names = ("Navigation", "OmniTo2WD", "PathFollower", "RefHardRh3", "Odometry")
    components = [d for d in model.declarations if d.name in [(n,) for n in names]]
    assert len(components) == len(names)
    for component in components:
        ports = [p for p in component.ports if p.kind in DATA_KINDS]
        assert [p.name for p in ports if p.unit]
        assert {p.name for p in ports if not p.unit} <= {"status"}


@pytest.mark.parametrize("name", ["rh3_beego.toml", "fourx.toml"])
def test_factors_of_the_drives_are_those_of_their_objects(name: str) -> None:
    bus = api.compile(ROOT / "specs" / "canopen" / name).buses[0]
    (kind,) = bus.kinds
    assert kind.factors
    for number, stated in kind.factors:
        computed = drive_factor(kind.device, number, dict(kind.units)[number])
        assert computed == pytest.approx(stated, rel=1e-12)


def test_units_of_a_drive() -> None:
    bus = api.compile(ROOT / "specs" / "canopen" / "rh3_beego.toml").buses[0]
    device = bus.kinds[0].device
    turn = drive_factor(device, (0x6064, 0), "rev")
    assert turn == pytest.approx(1 / (2000 * 14))
    assert drive_factor(device, (0x6064, 0), "deg") == pytest.approx(360 * turn)
    assert drive_factor(device, (0x60FF, 0), "rad/s") == pytest.approx(
        1e-3 * tau / 60 / 14
    )
    for number, unit, word in (
        ((0x6064, 0), "m", "not measured in m"),
        ((0x6064, 0), "rad/s", "not measured in rad/s"),
        ((0x60FF, 0), "Hz", "not measured in Hz"),
        ((0x6064, 0), "wags", "not a unit"),
        ((0x6064, 0), "", "no unit"),
        ((0x6041, 0), "rad", "not a position"),
    ):
        with pytest.raises(NoFactorError, match=word):
            drive_factor(device, number, unit)
