"""Units of members, from IDL to tables, pictures and recordings of runs."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from small_systems import system_text

from rtgen.cli import run

IDL = """
#include "ExtendedDataTypes.idl"
module Grips {
    enum Mode { OFF, ON };
    struct Joint { double angle;  ///< [rad]
        @unit("mm") double length; };
    /** A grip. */
    struct Grip {
        double width;             ///< Opening [mm].
        @unit("N") double force;  ///< Force of it.
        @unit("s") double when;   ///< See [1] and [2].
        Joint first;
        sequence<Joint> more;
        @unit("m/s") double speed[2];
        boolean closed;
        Mode how;
        long number;
    };
    struct Plain { double x; double y; long n; };
    struct Deep : Plain { Joint inner; };
    union Either switch (boolean) { case TRUE: double a; ///< [V]
        case FALSE: float b; ///< [V]
    };
};
@rtc(category="Demo", vendor="me", rate=10.0)
component Hand {
    publishes Grips::Grip grip;
    publishes Grips::Plain plain;
    @unit("m") publishes Grips::Plain metres;
    @unit("m, deg, count") publishes Grips::Plain several;
    @unit("deg, m") publishes Grips::Grip other;
    publishes Grips::Deep deep;
    publishes Grips::Either either;
    @unit("m, rad") publishes RTC::TimedPose2D pose;
    @unit("N*m") publishes RTC::TimedDouble torque;
};
"""
BEHAVIOUR = """
from grips.components.hand import HandBase
from grips import grips, rtc
from rtgen.runtime import RTC_OK


class Hand(HandBase):
    def on_execute(self, ec_id):
        joint = grips.Joint(1.0, 2.0)
        grip = grips.Grip(1.0, 2.0, 3.0, joint, [joint], [1.0, 2.0])
        self.grip.write(grip)
        self.other.write(grip)
        for port in (self.plain, self.metres, self.several):
            port.write(grips.Plain(1.0, 2.0, 3))
        self.deep.write(grips.Deep(1.0, 2.0, 3, joint))
        self.either.write(grips.Either.of_a(2.0))
        self.pose.write(rtc.TimedPose2D())
        self.torque.write(rtc.TimedDouble())
        return RTC_OK
"""


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grips")
    (folder / "grips.idl").write_text(IDL)
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["grips.idl"]\n[output]\npackage = "grips"\nskeletons = "src"\n'
    )
    command = [sys.executable, "-m", "rtgen", "generate", "-q", "--no-cache"]
    subprocess.run(command, cwd=folder, check=True)
    (folder / "src/hand.py").write_text(BEHAVIOUR)
    (folder / "s.xml").write_text(system_text({"Hand0": "Hand"}))
    return folder


@pytest.fixture(autouse=True)
def _project(
    generated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    monkeypatch.chdir(generated)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield
    for name in list(sys.modules):
        if name.partition(".")[0] in ("grips", "hand"):
            del sys.modules[name]


def units(titles: list[str]) -> dict[str, str]:
    """Return the units of the columns of a table by the names of members."""
    pairs = (title.partition(" ") for title in titles if title != "t")
    return {name.split(".", 2)[-1]: unit.strip("[]") for name, _, unit in pairs}


GRIP = {
    "width": "mm",
    "force": "N",
    "when": "s",
    "first.angle": "rad",
    "first.length": "mm",
    "more[0].angle": "rad",
    "more[0].length": "mm",
    "speed[0]": "m/s",
    "speed[1]": "m/s",
    "closed": "",
    "number": "",
}
PORTS = {
    "grip": GRIP,
    "plain": {"x": "", "y": "", "n": ""},
    "metres": {"x": "m", "y": "m", "n": ""},
    "several": {"x": "m", "y": "deg", "n": "count"},
    # The port has its own scales of the dimensions that it states.
    "other": {
        name: {"mm": "m", "rad": "deg"}.get(unit, unit) for name, unit in GRIP.items()
    },
    "deep": {"x": "", "y": "", "n": "", "inner.angle": "rad", "inner.length": "mm"},
    "either": {"discriminator": "", "value": "V"},
    "pose": {
        "data.position.x": "m",
        "data.position.y": "m",
        "data.heading": "rad",
    },
    "torque": {"data": "N*m"},
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("port", PORTS)
def test_tables_of_runs_and_of_recordings(
    port: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    name, table = f"Hand0.{port}", tmp_path / "new" / "a.csv"
    recording = str(tmp_path / "a.mcap")
    options = ["--csv", name, "--csv", str(table), "--record", recording]
    assert run(["run", "s.xml", "-q", "--until", "0.2", *options]) == 0
    header = table.read_text().splitlines()[0].split(",")
    expected = PORTS[port]
    if port in (
        "pose",
        "torque",
        "either",
    ):  # the only member besides the time is left out
        assert sorted(units(header).values()) == sorted(expected.values())
    else:
        assert units(header) == expected
    assert run(["log", "csv", recording, name]) == 0
    assert capfd.readouterr().out.splitlines()[0].split(",") == header


def test_a_member_alone_has_its_unit(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    options = ["Hand0.grip.force", "Hand0.pose.heading", "Hand0.grip.more[0].angle"]
    options = [text for name in options for text in ("--csv", name)]
    assert (
        run(["run", "s.xml", "-q", "--until", "0.2", *options, "--csv", str(table)])
        == 0
    )
    assert table.read_text().splitlines()[0] == (
        "t,Hand0.grip.force [N],Hand0.pose.heading [rad],Hand0.grip.more[0].angle [rad]"
    )


def test_a_picture_has_a_panel_for_each_unit(tmp_path: Path) -> None:
    picture = tmp_path / "a.svg"
    options = ["--plot", "Hand0.pose", "--plot", str(picture)]
    assert run(["run", "s.xml", "-q", "--until", "0.2", *options]) == 0
    texts = re.findall(r"<!-- (.*?) -->", picture.read_text())
    assert [text for text in texts if text.startswith("[")] == ["[m]", "[rad]"]
    panels = re.findall(r'<g id="axes_\d+">', picture.read_text())
    assert len(panels) == 2
